"""Compare applied torques with commands, and with the fallback where a command was late."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.signals.graph import WALL_TIMING
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.signals import INVARIANTS, TORQUE

_APPLIED: Final = "plant_invariants.applied_torque"
_SOURCE: Final = "plant_invariants.applied_source"


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
    _compare(evidence, ledger, name, steps, evidence.rows(TORQUE, "torque", steps),
             evidence.rows(TORQUE, "source", steps))  # fmt: skip
    if held.size:
        expected, source = _stand_ins(evidence, held)
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


def held_steps(evidence: Evidence) -> NDArray[np.int64]:
    """Return the steps for which the plant says that no command came in time.

    In free run its count grows by one at each. In lockstep, where it is told now and then only,
    the steps with zero torque of the plant's own must be as many as it counts in all.
    """
    timing = evidence.columns[WALL_TIMING]
    if not timing.steps.size:
        return np.empty(0, dtype=np.int64)
    counts = timing.fields["held_commands"]
    if evidence.scenario.plant.mode == "free_run":
        told = np.concatenate([[0], evidence.rows(WALL_TIMING, "held_commands", _after(evidence))])
        return np.flatnonzero(np.diff(told) == 1)
    steps = np.arange(evidence.n)
    zero = evidence.rows(INVARIANTS, "applied_torque", steps + 1) == 0.0
    given_up = zero.all(axis=1) & (
        evidence.rows(INVARIANTS, "applied_source", steps + 1) == Source.ZERO
    )
    commanded = evidence.rows(TORQUE, "source", steps) == Source.ZERO
    candidates = np.flatnonzero(given_up & ~commanded)
    return candidates if candidates.size == counts.max() else np.empty(0, dtype=np.int64)


def _after(evidence: Evidence) -> NDArray[np.int64]:
    return np.arange(1, evidence.n + 1)


def _stand_ins(evidence: Evidence, held: NDArray[np.int64]) -> tuple[Array, Array]:
    """Return torque and source that act without a command: the last ones, or zero.

    In free run the last torque is held for ``plant.max_held_steps``, in lockstep not at all.
    """
    plant = evidence.scenario.plant
    most = plant.max_held_steps if plant.mode == "free_run" else 0
    runs = np.ones(held.size, dtype=np.int64)
    for i in np.flatnonzero(np.diff(held) == 1):
        runs[i + 1] = runs[i] + 1
    torque = np.nan_to_num(evidence.rows(INVARIANTS, "applied_torque", held))
    source = evidence.rows(INVARIANTS, "applied_source", held)
    torque[runs > most] = 0.0
    source[(runs > most) | (held == 0)] = Source.ZERO
    return torque, source
