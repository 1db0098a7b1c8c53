"""Check the references and the governor's account of them for consistency."""

from __future__ import annotations

from typing import Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.signals.attitude import GOVERNOR_STATUS, REFERENCE

ROUNDING: Final = 1e-13
_ATTITUDE, _ORIENTATION = "attitude_reference.attitude", "attitude_reference.orientation"


def audit_references(evidence: Evidence, ledger: Ledger) -> None:
    """Check the references, then the governor's claims, without asking the governor."""
    columns = evidence.columns[REFERENCE]
    if not columns.steps.size:
        ledger.skip("references are rotations", "attitude_reference was not recorded")
        return
    attitudes = columns.fields["attitude"].reshape(-1, 3, 3)
    defect = np.einsum("kji,kjl->kil", attitudes, attitudes) - np.eye(3)
    ledger.bound("references are rotations", columns.steps, _ATTITUDE, defect, ROUNDING)
    name = "quaternion = rotation matrix"
    again = np.array([lie.to_quaternion_xyzw(attitude) for attitude in attitudes])
    recorded = columns.fields["orientation"]
    ledger.compare(name, columns.steps, {_ORIENTATION: recorded}, {_ORIENTATION: again})
    _decisions(evidence, ledger)


def _decisions(evidence: Evidence, ledger: Ledger) -> None:
    """Check that a share lies between 0 and 1, and that what is admissible has room."""
    columns = evidence.columns[GOVERNOR_STATUS]
    name, sign = "alpha between 0 and 1", "margin >= 0 where admissible"
    if not columns.steps.size:
        for skipped in (name, sign):
            ledger.skip(skipped, "governor_status was not recorded")
        return
    alpha, margin = columns.fields["alpha"], columns.fields["margin"]
    kept = (alpha >= 0.0) & (alpha <= 1.0)
    ledger.require(name, "always", columns.steps, "governor_status.alpha", kept)
    admissible = columns.fields["admissible"]
    where = "governor_status.margin"
    ledger.require(sign, "always", columns.steps, where, (margin >= 0.0) == admissible)
