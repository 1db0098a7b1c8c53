"""Audit of a docking flight: motion, navigation, governor, diagnosis, law, and limits exceeded.

It calls none of the code that flies: it has equations of its own, linearizes them, solves the
Riccati equation, and simulates the closed loop for every reference.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.applied import held_steps
from spacecraft_gnc.audit.counts import Counts
from spacecraft_gnc.audit.evidence import Evidence, Topics
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.audit.limits import Exceedance
from spacecraft_gnc.audit.vehicle import Watch
from spacecraft_gnc.recording.aligned import whole_steps
from spacecraft_gnc.signals.graph import WALL_TIMING
from spacecraft_gnc.vehicles.docking.audit.commands import audit_applied, audit_law
from spacecraft_gnc.vehicles.docking.audit.diagnosis import audit_diagnosis
from spacecraft_gnc.vehicles.docking.audit.governor import audit_governor
from spacecraft_gnc.vehicles.docking.audit.law import believed_model
from spacecraft_gnc.vehicles.docking.audit.motion import audit_motion
from spacecraft_gnc.vehicles.docking.audit.navigation import audit_navigation
from spacecraft_gnc.vehicles.docking.audit.pose import POSES
from spacecraft_gnc.vehicles.docking.limits import limits_exceeded
from spacecraft_gnc.vehicles.docking.recorded import read_recorded
from spacecraft_gnc.vehicles.docking.signals import (
    ACCEPTED_TARGET,
    APPLIED,
    COMMAND,
    GOVERNOR_STATUS,
    REFERENCE,
    STATE,
)

_TOPICS: Final = Topics(
    every_step=(STATE, REFERENCE, GOVERNOR_STATUS, COMMAND),
    sparse=(ACCEPTED_TARGET, WALL_TIMING),
    telemetry=(POSES,),
)


class DockingAudit:
    """Implements `audit.vehicle.VehicleAudit`."""

    topics = _TOPICS

    def require_flight(self, evidence: Evidence) -> None:
        """Refuse what holds no whole control step."""
        whole_steps(evidence.bag, evidence.columns, APPLIED)

    def held_steps(self, evidence: Evidence) -> NDArray[np.int64]:
        """Return the steps for which the plant says that no command came in time."""
        return held_steps(evidence, APPLIED)

    def audit(
        self,
        evidence: Evidence,
        ledger: Ledger,
        counts: Counts,
        held: NDArray[np.int64],
        tolerance: float | None,
        watch: Watch,
    ) -> tuple[Exceedance, ...]:
        """Enter every check of the flight; return the limits that it exceeded."""
        del counts, tolerance  # no failure is looked into; every tolerance is the audit's own
        audit_motion(evidence, ledger, watch("integrating"))
        audit_navigation(evidence, ledger)
        model = believed_model(evidence.scenario)
        audit_governor(evidence, ledger, model, watch("certifying the governor"))
        audit_diagnosis(evidence, ledger, model)
        audit_law(evidence, ledger, model)
        audit_applied(evidence, held, ledger)
        flown = read_recorded(evidence.bag, evidence.namespace, evidence.scenario).trajectory
        return limits_exceeded(flown, evidence.scenario)


AUDIT: Final = DockingAudit()
