"""Flight of a spacecraft with wheels read from a bag, aligned by control step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.audit.evidence import Progress
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.loop.flight import Column
from spacecraft_gnc.recording.aligned import overridden, period_of, targets_of, times_of
from spacecraft_gnc.recording.bag import Bag
from spacecraft_gnc.recording.columns import Columns, read_columns, require_reach
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.signals.attitude import ACCEPTED_TARGET, REFERENCE
from spacecraft_gnc.status import NO_SOLVE
from spacecraft_gnc.vehicles.two_wheel.euler import to_euler_321
from spacecraft_gnc.vehicles.two_wheel.flight import WheelFlight
from spacecraft_gnc.vehicles.two_wheel.signals import (
    APPLIED,
    COMMAND,
    DIAGNOSIS,
    SOLVER_STATUS,
    STATE,
)

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.two_wheel.scenario import Scenario

PLANS: Final = frozenset(
    name for name in SOLVER_STATUS.fields if name.startswith("predicted_") or name == "drift"
)
"""Fields that are long, and that a flight does not keep."""
Topics: TypeAlias = Mapping[Signal, Columns]
_SIGNALS: Final = (STATE, REFERENCE, ACCEPTED_TARGET, COMMAND, SOLVER_STATUS, DIAGNOSIS)


class Recorded(NamedTuple):
    """A flight as a bag holds it."""

    trajectory: WheelFlight
    missing: dict[str, tuple[int, ...]]
    """Steps without a message, by topic."""
    overridden: tuple[int, ...]
    """Steps whose applied acceleration differs from the command."""


def read_recorded(
    bag: Bag, namespace: str | None, scenario: Scenario | None, progress: Progress | None = None
) -> Recorded:
    """Read the flight in a bag; a row that lacks a message holds NaN (source: -1).

    A flight whose last state was not recorded ends one step earlier.

    Raises
    ------
    RecordingError
        If there is no whole control step in it.
    """
    columns = read_columns(bag, _SIGNALS, namespace, progress, leave_out=PLANS)
    n = whole_steps(bag, columns)
    period = period_of(columns[STATE]) if scenario is None else scenario.period
    named = {signal.name: columns[signal] for signal in _SIGNALS}
    values = {
        name: _at(named.get(column.signal), column, n) for name, column in WheelFlight.columns()
    }
    without = values["status"] == NO_SOLVE
    values["status"][without] = values["terminal"][without] = -1
    values["euler_321"] = to_euler_321(values["attitude"])
    initial = None if scenario is None else lie.exp(scenario.governor.target_rotation_vector)
    values["target"] = targets_of(n, columns[ACCEPTED_TARGET], initial)
    flight = WheelFlight(period=period, time=times_of(n, columns[STATE], period), **values)
    return Recorded(flight, _missing(columns), overridden(columns, APPLIED))


def whole_steps(bag: Bag, columns: Topics) -> int:
    """Return the number of whole control steps: those with a state before and after them.

    Raises
    ------
    RecordingError
        If there is none, or a step number lies far beyond what was recorded.
    """
    states, commands = columns[STATE].steps, columns[COMMAND].steps
    require_reach(bag, states, commands)
    count = int(states[-1]) if states.size else 0
    if count < 1 or not commands.size:
        raise RecordingError(
            f"{bag.path}: received {states.size} states and {commands.size} commands; required at "
            "least one whole control step; record a longer run"
        )
    return count


def _at(columns: Columns | None, column: Column, n: int) -> NDArray[Any]:
    """Return what a column holds of n steps, or of the end of the last one."""
    found = None if columns is None else columns.fields.get(column.member)
    if columns is None or found is None:
        shape = tuple(max(size, 0) for size in column.shape)
        filled: NDArray[Any] = np.full((n, *shape), column.missing, column.type)
        return filled[-1] if column.at_end else filled
    shape = tuple(found.shape[1:]) if -1 in column.shape else column.shape
    array: NDArray[Any] = np.full((n + 1, *shape), column.missing, column.type)
    within = columns.steps <= n
    array[columns.steps[within]] = found[within].reshape(-1, *shape)
    return array[n] if column.at_end else array[:n]


def _missing(columns: Topics) -> dict[str, tuple[int, ...]]:
    """Return the steps without a message, by topic; a topic never recorded is not listed."""
    last = int(columns[STATE].steps[-1])
    absent = {STATE.name: columns[STATE].missing(0, last)}
    for signal in (COMMAND, REFERENCE, SOLVER_STATUS, DIAGNOSIS):
        if columns[signal].steps.size:
            absent[signal.name] = columns[signal].missing(0, last - 1)
    return {topic: steps for topic, steps in absent.items() if steps}
