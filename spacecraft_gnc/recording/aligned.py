"""Flights aligned by control step, from the columns of a bag: what vehicles of every kind share."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

import numpy as np

from spacecraft_gnc.recording.columns import Columns
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.signals.applied import Applied
from spacecraft_gnc.types import Array

_GRID_TOLERANCE: Final = 1e-6  # [s] stamps are whole nanoseconds, the grid is k times the period


def period_of(states: Columns) -> float:
    """Return the control period [s] from the stamps of the first and the last state."""
    (first, last), (start, end) = states.steps[[0, -1]], states.stamps[[0, -1]]
    return round(float(end - start) / int(last - first), 9)


def times_of(n: int, states: Columns, period: float) -> Array:
    """Return (n,) times of the steps: the grid, unless the stamps tell otherwise."""
    times = np.asarray(period * np.arange(n), dtype=np.float64)
    within = states.steps < n
    steps, stamps = states.steps[within], states.stamps[within]
    if not np.allclose(stamps, times[steps], rtol=0.0, atol=_GRID_TOLERANCE):
        times[steps] = stamps
    return times


def targets_of(n: int, taken: Columns, initial: Array | None) -> Array:
    """Return (n, 3, 3) targets: the initial one, then those that the governor took in flight.

    NaN where the initial one is not known.
    """
    targets = np.full((n, 3, 3), math.nan)
    if initial is not None:
        targets[:] = initial
    for i, step in enumerate(taken.steps.tolist()):
        targets[step:] = taken.fields["attitude"][i].reshape(3, 3)
    return targets


def overridden(columns: Mapping[Signal, Columns], applied: Applied) -> tuple[int, ...]:
    """Return the steps in which the plant applied another control than commanded."""
    commands, told = columns[applied.command], columns[applied.told]
    both, at, after = np.intersect1d(commands.steps, told.steps - 1, return_indices=True)
    if not both.size:
        return ()
    commanded, acted = commands.fields[applied.commanded][at], told.fields[applied.control][after]
    return tuple(both[(commanded != acted).any(axis=1)].tolist())
