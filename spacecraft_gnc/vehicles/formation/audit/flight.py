"""Audit of a flight in formation: motion, references, shifts, commands, and limits exceeded.

It calls none of the code that flies: it has equations of its own, solves the Riccati equation, and
enumerates the candidates of every step by predictions of its own.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.counts import Counts
from spacecraft_gnc.audit.evidence import Evidence, Topics
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.audit.limits import Exceedance
from spacecraft_gnc.audit.vehicle import Watch
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording.aligned import whole_steps
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.signals.graph import WALL_TIMING
from spacecraft_gnc.vehicles.formation.audit import commands
from spacecraft_gnc.vehicles.formation.audit.governor import audit_governor
from spacecraft_gnc.vehicles.formation.audit.motion import audit_motion
from spacecraft_gnc.vehicles.formation.limits import limits_exceeded
from spacecraft_gnc.vehicles.formation.recorded import read_recorded
from spacecraft_gnc.vehicles.formation.signals import (
    APPLIED,
    COMMAND,
    GOVERNOR_STATUS,
    REFERENCE,
    STATE,
)

_TOPICS: Final = Topics(
    every_step=(STATE, REFERENCE, GOVERNOR_STATUS, COMMAND), sparse=(WALL_TIMING,)
)
_OF_EACH: Final[tuple[tuple[Signal, dict[str, int]], ...]] = (
    (
        STATE,
        {"position": 3, "velocity": 3, "healthy": 1, "applied_delta_v": 3, "applied_source": 1},
    ),
    (REFERENCE, {"shift": 1, "position": 3, "velocity": 3}),
)
"""Fields with so many numbers for each craft."""


class FormationAudit:
    """Implements `audit.vehicle.VehicleAudit`."""

    topics = _TOPICS

    def require_flight(self, evidence: Evidence) -> None:
        """Refuse what holds no whole control step, or other craft than the scenario."""
        if evidence.scenario is None:  # which craft there are is not known
            return
        for signal in commands.commands(evidence):
            whole_steps(evidence.bag, evidence.columns, APPLIED._replace(command=signal))
        n = len(evidence.scenario.plant.spacecraft)
        for signal, fields in _OF_EACH:
            for name, each in fields.items():
                found = evidence.columns[signal].fields.get(name)
                if found is not None and found.shape[1:] != (each * n,):
                    raise RecordingError(
                        f"{evidence.path}: {signal}.{name}: received {found.shape[-1]} numbers; "
                        f"required {each * n}, {each} for each craft of the scenario; the bag is "
                        "damaged"
                    )

    def held_steps(self, evidence: Evidence) -> NDArray[np.int64]:
        """Return the steps for which the plant says that a command did not come in time."""
        return commands.held_steps(evidence)

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
        audit_motion(evidence, ledger)
        audit_governor(evidence, ledger, watch("enumerating the shifts"))
        commands.audit_law(evidence, ledger)
        commands.audit_applied(evidence, held, ledger)
        flown = read_recorded(evidence.bag, evidence.namespace, evidence.scenario).trajectory
        return limits_exceeded(flown, evidence.scenario)


AUDIT: Final = FormationAudit()
