"""Check what messages carry beside their numbers: the frame, and how they are encoded."""

from __future__ import annotations

from typing import Final

from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.audit.ledger import Ledger

FRAMES: Final = "frames"
DECLARED: Final = "as declared"
ENCODING: Final = "encoding"
CANONICAL: Final = "bytes of the fields"


def audit_wire(evidence: Evidence, ledger: Ledger) -> None:
    """Compare the frame of each message with its signal's, and its bytes with those of its fields.

    Of the topics that nodes publish at a step; what users publish is encoded by others.
    """
    for topic in (*evidence.topics.every_step, *evidence.topics.sparse):
        columns = evidence.columns[topic]
        if not topic.publishers or not columns.steps.size:
            continue
        where, same = f"{topic}.header.frame_id", columns.frames == topic.frame
        ledger.require(FRAMES, DECLARED, columns.steps, where, same)
        ledger.require(ENCODING, CANONICAL, columns.steps, f"{topic} (bytes)", columns.exact)
