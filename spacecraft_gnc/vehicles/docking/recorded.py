"""Docking flight read from a bag, aligned by control step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.evidence import Progress
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.loop.flight import Column
from spacecraft_gnc.recording.aligned import overridden, period_of, times_of
from spacecraft_gnc.recording.bag import Bag
from spacecraft_gnc.recording.columns import Columns, read_columns, require_reach
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.flight import DockingFlight
from spacecraft_gnc.vehicles.docking.signals import (
    ACCEPTED_TARGET,
    APPLIED,
    COMMAND,
    GOVERNOR_STATUS,
    REFERENCE,
    STATE,
)

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.docking.scenario import Scenario

Topics: TypeAlias = Mapping[Signal, Columns]
_SIGNALS: Final = (STATE, REFERENCE, ACCEPTED_TARGET, COMMAND, GOVERNOR_STATUS)
_HALVES: Final = (("force", slice(3)), ("moment", slice(3, None)))


class Recorded(NamedTuple):
    """A flight as a bag holds it."""

    trajectory: DockingFlight
    missing: dict[str, tuple[int, ...]]
    """Steps without a message, by topic."""
    overridden: tuple[int, ...]
    """Steps over which another wrench acted than was commanded."""


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
    columns = read_columns(bag, _SIGNALS, namespace, progress)
    n = whole_steps(bag, columns)
    period = period_of(columns[STATE]) if scenario is None else scenario.period
    named = {signal.name: columns[signal] for signal in _SIGNALS}
    values = {
        name: _at(named.get(column.signal), column, n) for name, column in DockingFlight.columns()
    }
    wrench = _rows(columns[COMMAND], ("wrench",), n)
    values |= {name: wrench[:, half] for name, half in _HALVES}
    values["reference"] = _rows(columns[REFERENCE], ("port_offset", "rotation_vector"), n)
    values["target"] = _targets(n, columns[ACCEPTED_TARGET], scenario)
    flight = DockingFlight(period=period, time=times_of(n, columns[STATE], period), **values)
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
    array: NDArray[Any] = np.full((n + 1, *column.shape), column.missing, column.type)
    found = None if columns is None else columns.fields.get(column.member)
    if columns is not None and found is not None:
        within = columns.steps <= n
        array[columns.steps[within]] = found[within].reshape(-1, *column.shape)
    return array[n] if column.at_end else array[:n]


def _rows(columns: Columns, names: tuple[str, ...], n: int) -> Array:
    """Return fields side by side (n, 6) by step; NaN where there is no message."""
    rows = np.full((n, 6), np.nan)
    within = columns.steps < n
    rows[columns.steps[within]] = np.hstack([columns.fields[name][within] for name in names])
    return rows


def _targets(n: int, taken: Columns, scenario: Scenario | None) -> Array:
    """Return (n, 6) targets: the scenario's, then those taken in flight; NaN: not known."""
    targets = np.full((n, 6), np.nan)
    if scenario is not None:
        g = scenario.governor
        targets[:] = np.concatenate([g.target_port_offset, g.target_rotation_vector])
    for i, step in enumerate(taken.steps.tolist()):
        parts = (taken.fields[name][i] for name in ("port_offset", "rotation_vector"))
        targets[step:] = np.concatenate(list(parts))
    return targets


def _missing(columns: Topics) -> dict[str, tuple[int, ...]]:
    """Return the steps without a message, by topic; a topic never recorded is not listed."""
    last = int(columns[STATE].steps[-1])
    absent = {STATE.name: columns[STATE].missing(0, last)}
    for signal in (COMMAND, REFERENCE, GOVERNOR_STATUS):
        if columns[signal].steps.size:
            absent[signal.name] = columns[signal].missing(0, last - 1)
    return {topic: steps for topic, steps in absent.items() if steps}
