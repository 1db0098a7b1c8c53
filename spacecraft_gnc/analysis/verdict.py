"""What the audit says of a run, in a line."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from spacecraft_gnc.recording.reader import NPZ_SUFFIX

if TYPE_CHECKING:
    from spacecraft_gnc.recording.reader import Flight


class Verdict(NamedTuple):
    """Outcome of an audit."""

    passed: bool | None
    """None: not audited."""
    text: str


def audit_verdict(flight: Flight) -> Verdict:
    """Audit the bag of a flight.

    A file of ``gnc simulate`` holds neither plans nor commands to recompute, and is not audited.
    """
    path = flight.info.path
    if path.suffix == NPZ_SUFFIX and not path.is_dir():
        return Verdict(None, "not audited: a .npz file holds no plans; record a bag")
    return Verdict(None, "not audited: this version has no audit")
