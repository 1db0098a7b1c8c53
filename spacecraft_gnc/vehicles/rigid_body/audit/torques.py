"""Compare applied torques with commands within limits, or with the fallback where one was late."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.applied import stand_ins
from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.parameters.plant import PlantParameters
from spacecraft_gnc.vehicles.rigid_body.signals import APPLIED, INVARIANTS, TORQUE

_APPLIED: Final = "plant_invariants.applied_torque"
_SOURCE: Final = "plant_invariants.applied_source"


def given(plant: PlantParameters, torques: Array) -> Array:
    """Return what actuators within ``plant.max_torque`` give of torques (n, 3); NaN stays."""
    most = plant.max_torque
    return np.asarray(np.maximum(np.minimum(torques, most), -most)) if most else torques


def audit_torques(evidence: Evidence, held: NDArray[np.int64], ledger: Ledger) -> None:
    """Compare commands with what acted; ``held`` are the steps without a command in time."""
    name, late = "applied torque = command", "torque where no command came in time"
    if not evidence.columns[INVARIANTS].steps.size:
        ledger.skip(name, "plant_invariants was not recorded: the commands are taken as applied")
        ledger.skip(late, "plant_invariants was not recorded")
        return
    steps = evidence.common(TORQUE)
    steps = steps[(steps < evidence.n) & ~np.isin(steps, held)]
    steps = steps[np.isfinite(evidence.rows(INVARIANTS, "applied_source", steps + 1))]
    commanded = evidence.rows(TORQUE, "torque", steps)
    acting = given(evidence.scenario.plant, commanded)
    _compare(evidence, ledger, name, steps, acting, evidence.rows(TORQUE, "source", steps))
    cut = int(np.count_nonzero((acting != commanded).any(axis=1)))
    if cut:
        most = evidence.scenario.plant.max_torque
        ledger.check(name, "", f"cut to plant.max_torque, {most:g} N m, at {cut} steps")
    if held.size:
        held_torque, source = stand_ins(evidence, held, APPLIED)
        expected = given(evidence.scenario.plant, held_torque)
        _compare(evidence, ledger, late, held, expected, source)
        ledger.check(late, "", f"{held.size} steps held or zero, as wall_timing counts them")
    else:
        ledger.skip(late, "every command came in time")
    start = np.zeros(1, dtype=np.int64)
    first = evidence.rows(INVARIANTS, "applied_torque", start)
    ledger.compare(
        "no torque before step 0", start, {_APPLIED: first}, {_APPLIED: np.zeros((1, 3))}
    )


def _compare(
    evidence: Evidence,
    ledger: Ledger,
    name: str,
    steps: NDArray[np.int64],
    torque: Array,
    source: Array,
) -> None:
    applied = evidence.rows(INVARIANTS, "applied_torque", steps + 1)
    ledger.compare(name, steps, {_APPLIED: applied}, {_APPLIED: torque})
    told = evidence.rows(INVARIANTS, "applied_source", steps + 1)
    ledger.compare(name, steps, {_SOURCE: told}, {_SOURCE: source})
