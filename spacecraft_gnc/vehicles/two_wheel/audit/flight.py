"""Audit of a flight: motion, wheels, references, plans, commands, diagnosis."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.applied import held_steps
from spacecraft_gnc.audit.channels import channel_of
from spacecraft_gnc.audit.counts import Counts
from spacecraft_gnc.audit.evidence import Evidence, Topics
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.audit.limits import Exceedance
from spacecraft_gnc.audit.order import audit_each_step, audit_stamps
from spacecraft_gnc.audit.telemetry import error_of, pose_of
from spacecraft_gnc.audit.vehicle import Watch
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording.aligned import whole_steps
from spacecraft_gnc.signals.attitude import ACCEPTED_TARGET, GOVERNOR_STATUS, REFERENCE
from spacecraft_gnc.signals.graph import WALL_TIMING
from spacecraft_gnc.vehicles.two_wheel.audit.commands import (
    audit_applied,
    audit_law,
    audit_references,
)
from spacecraft_gnc.vehicles.two_wheel.audit.diagnosis import audit_diagnosis
from spacecraft_gnc.vehicles.two_wheel.audit.motion import audit_motion
from spacecraft_gnc.vehicles.two_wheel.audit.plans import audit_plans
from spacecraft_gnc.vehicles.two_wheel.recorded import PLANS
from spacecraft_gnc.vehicles.two_wheel.signals import (
    APPLIED,
    COMMAND,
    DIAGNOSIS,
    SOLVER_STATUS,
    STATE,
)

_TOPICS: Final = Topics(
    every_step=(STATE, REFERENCE, GOVERNOR_STATUS, COMMAND),
    sparse=(ACCEPTED_TARGET, WALL_TIMING, SOLVER_STATUS, DIAGNOSIS),  # older bags lack the last two
    solves=SOLVER_STATUS,
    plans=tuple(PLANS),
    telemetry=(pose_of(STATE), error_of(STATE, COMMAND)),
    later=dict.fromkeys((SOLVER_STATUS, DIAGNOSIS), lambda s: s.controller.method != "feedback"),
)
_OF_A_WHEEL: Final = (
    (STATE, "wheel_speed"),
    (STATE, "healthy"),
    (STATE, "applied_acceleration"),
    (COMMAND, "acceleration"),
)


class WheelAudit:
    """Implements `audit.vehicle.VehicleAudit`."""

    topics = _TOPICS

    def require_flight(self, evidence: Evidence) -> None:
        """Refuse what holds no whole control step, or other wheels than the scenario."""
        whole_steps(evidence.bag, evidence.columns, APPLIED)
        if evidence.scenario is None:
            return
        m = evidence.scenario.plant.wheel_inertias.size
        for signal, name in _OF_A_WHEEL:
            found = evidence.columns[signal].fields.get(name)
            if found is not None and found.shape[1:] != (m,):
                raise RecordingError(
                    f"{evidence.path}: {signal}.{name}: received {found.shape[-1]} numbers; "
                    f"required {m}, one for each wheel of the scenario; the bag is damaged"
                )

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
        """Enter every check of the flight; no limit can be exceeded, for a wheel saturates."""
        del counts  # no failure is looked into
        for topic in (SOLVER_STATUS, DIAGNOSIS):
            if channel_of(evidence, topic) is not None:
                audit_each_step(evidence, ledger, topic, held)
                audit_stamps(evidence, ledger, topic)
        audit_motion(evidence, ledger, tolerance, watch("integrating"))
        audit_references(evidence, ledger)
        audit_law(evidence, ledger, tolerance, watch("asking the law"))
        audit_plans(evidence, ledger, watch("certifying the plans"))
        audit_applied(evidence, held, ledger)
        audit_diagnosis(evidence, ledger)
        return ()


AUDIT: Final = WheelAudit()
