"""Steps without a command in time, and the controls that a plant applies in their place."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.signals.applied import Applied
from spacecraft_gnc.signals.graph import WALL_TIMING
from spacecraft_gnc.types import Array


def held_steps(evidence: Evidence, applied: Applied) -> NDArray[np.int64]:
    """Return the steps for which the plant says that no command came in time.

    In free run its count grows by one at each. In lockstep, where it is told now and then only,
    the idle steps of the plant's own must be as many as it counts in all. Of several craft, that of
    one is enough.
    """
    timing = evidence.columns[WALL_TIMING]
    none = np.empty(0, dtype=np.int64)
    if not timing.steps.size:
        return none
    steps = np.arange(evidence.n)
    if evidence.scenario.plant.mode == "free_run":
        told = evidence.rows(WALL_TIMING, "held_commands", steps + 1)
        return np.flatnonzero(np.diff(np.concatenate([[0], told])) == 1)
    commands = [
        evidence.rows(command, "source", steps) for command in evidence.topics.each(applied.command)
    ]
    of_each = evidence.n, len(commands)
    source = evidence.rows(applied.told, applied.source, steps + 1).reshape(of_each)
    control = evidence.rows(applied.told, applied.control, steps + 1).reshape(*of_each, -1)
    idle = (source == Source.ZERO) & (control == 0.0).all(axis=2)
    found = np.flatnonzero((idle & (np.stack(commands, axis=1) != Source.ZERO)).any(axis=1))
    return found if found.size == timing.fields["held_commands"].max() else none


def stand_ins(evidence: Evidence, held: NDArray[np.int64], applied: Applied) -> tuple[Array, Array]:
    """Return controls and sources that act without a command: the last ones, or zero.

    In free run the last command is held for ``plant.max_held_steps``, in lockstep not at all.
    """
    plant = evidence.scenario.plant
    most = plant.max_held_steps if plant.mode == "free_run" else 0
    runs = np.ones(held.size, dtype=np.int64)
    for i in np.flatnonzero(np.diff(held) == 1):
        runs[i + 1] = runs[i] + 1
    control = np.nan_to_num(evidence.rows(applied.told, applied.control, held))
    source = evidence.rows(applied.told, applied.source, held)
    control[runs > most] = 0.0
    source[(runs > most) | (held == 0)] = Source.ZERO
    return control, source
