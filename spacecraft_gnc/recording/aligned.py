"""Flights aligned by control step, from the columns of a bag: what vehicles of every kind share."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.loop.flight import Column
from spacecraft_gnc.recording.bag import Bag
from spacecraft_gnc.recording.columns import Columns, require_reach
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


def whole_steps(bag: Bag, columns: Mapping[Signal, Columns], applied: Applied) -> int:
    """Return the number of whole control steps: those with a state before and after them.

    Raises
    ------
    RecordingError
        If there is none, or a step number lies far beyond what was recorded.
    """
    states, commands = columns[applied.told].steps, columns[applied.command].steps
    require_reach(bag, states, commands)
    count = int(states[-1]) if states.size else 0
    if count < 1 or not commands.size:
        raise RecordingError(
            f"{bag.path}: received {states.size} states and {commands.size} commands; required at "
            "least one whole control step; record a longer run"
        )
    return count


def at_steps(columns: Columns | None, column: Column, n: int) -> NDArray[Any]:
    """Return what a column holds of n steps, or of the end of the last one."""
    found = None if columns is None else columns.fields.get(column.member)
    if columns is None or found is None:
        shape = tuple(max(size, 0) for size in column.shape)
        filled: NDArray[Any] = np.full((n, *shape), column.missing, column.type)
        return filled[-1] if column.at_end else filled
    shape = tuple(found.shape[1:]) if -1 in column.shape else column.shape
    array: NDArray[Any] = np.full((n + 1, *shape), column.missing, column.type)
    within = columns.steps <= n
    array[columns.steps[within]] = found[within].reshape(int(within.sum()), *shape)
    return array[n] if column.at_end else array[:n]


def missing_steps(
    columns: Mapping[Signal, Columns], state: Signal, answers: Iterable[Signal]
) -> dict[str, tuple[int, ...]]:
    """Return the steps without a message, by topic; of answers only what was ever recorded."""
    last = int(columns[state].steps[-1])
    absent = {state.name: columns[state].missing(0, last)}
    for signal in answers:
        if columns[signal].steps.size:
            absent[signal.name] = columns[signal].missing(0, last - 1)
    return {topic: steps for topic, steps in absent.items() if steps}


def overridden(columns: Mapping[Signal, Columns], applied: Applied) -> tuple[int, ...]:
    """Return the steps in which the plant applied another control than commanded."""
    commands, told = columns[applied.command], columns[applied.told]
    both, at, after = np.intersect1d(commands.steps, told.steps - 1, return_indices=True)
    if not both.size:
        return ()
    commanded, acted = commands.fields[applied.commanded][at], told.fields[applied.control][after]
    return tuple(both[(commanded != acted).any(axis=1)].tolist())
