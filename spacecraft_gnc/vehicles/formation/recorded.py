"""Flight in formation read from a bag, aligned by control step."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.evidence import Progress
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.recording.aligned import (
    at_steps,
    missing_steps,
    period_of,
    times_of,
    whole_steps,
)
from spacecraft_gnc.recording.bag import Bag
from spacecraft_gnc.recording.columns import NO_COLUMNS, Columns, read_columns
from spacecraft_gnc.recording.steps import craft_in
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.craft import craft
from spacecraft_gnc.vehicles.formation.flight import FormationFlight
from spacecraft_gnc.vehicles.formation.geometry import communication_angles_deg, separations
from spacecraft_gnc.vehicles.formation.signals import (
    APPLIED,
    COMMAND,
    GOVERNOR_STATUS,
    REFERENCE,
    STATE,
)

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.formation.scenario import Scenario

_SIGNALS: Final = (STATE, REFERENCE, GOVERNOR_STATUS)
_VECTORS: Final = (-1, 3)
"""Shape of a column with a vector of each craft."""
_UNKNOWN: Final = -1


class Recorded(NamedTuple):
    """A flight as a bag holds it."""

    trajectory: FormationFlight
    missing: dict[str, tuple[int, ...]]
    """Steps without a message, by topic."""
    overridden: tuple[int, ...]
    """Steps in which something else was asked of a craft than was commanded."""


def read_recorded(
    bag: Bag, namespace: str | None, scenario: Scenario | None, progress: Progress | None = None
) -> Recorded:
    """Read the flight in a bag; a row that lacks a message holds NaN (integers: -1).

    The delta-v of a craft whose command is missing is NaN, and the source of the step then `ZERO`.
    A flight whose last state was not recorded ends one step earlier.

    Raises
    ------
    RecordingError
        If there is no whole control step in it.
    """
    names = craft_in(bag, COMMAND, STATE, namespace) if scenario is None else craft(scenario)
    commands = tuple(COMMAND.of(name) for name in names)
    columns = read_columns(bag, (*_SIGNALS, *commands), namespace, progress)
    n = _whole_steps(bag, columns, commands)
    period = period_of(columns[STATE]) if scenario is None else scenario.period
    named = {signal.name: columns[signal] for signal in _SIGNALS}
    values = {
        name: at_steps(named.get(column.signal), column, n)
        for name, column in FormationFlight.columns()
    }
    for name, column in FormationFlight.columns():
        if column.shape == _VECTORS:
            values[name] = _by_craft(values[name], () if column.at_end else (n,))
    position = values["position"]
    values["separation"] = separations(position)
    values["communication_angle_deg"] = _angles(position, values["reference_position"])
    values["delta_v"], values["source"] = _commanded(columns, commands, n)
    flight = FormationFlight(period=period, time=times_of(n, columns[STATE], period), **values)
    missing = missing_steps(columns, STATE, (*commands, REFERENCE, GOVERNOR_STATUS))
    return Recorded(flight, missing, _overridden(columns, commands))


def _whole_steps(bag: Bag, columns: Mapping[Signal, Columns], commands: Sequence[Signal]) -> int:
    """Return the whole control steps, of which one craft's commands at least were recorded."""
    most = max(commands, key=lambda each: columns[each].steps.size, default=COMMAND)
    return whole_steps(bag, {COMMAND: NO_COLUMNS, **columns}, APPLIED._replace(command=most))


def _by_craft(numbers: Array, steps: tuple[int, ...]) -> Array:
    """Return numbers of a message as vectors of the craft (*steps, craft, 3)."""
    return numbers.reshape(*steps, numbers.size // (3 * math.prod(steps)), 3)


def _angles(position: Array, wanted: Array) -> Array:
    """Return the angles (n, pairs) [deg]; NaN without references, or where one is missing."""
    if wanted.shape != position.shape:
        wanted = np.full(position.shape, np.nan)
    angles = communication_angles_deg(position, wanted)
    known = np.isfinite(separations(position) + separations(wanted))
    return np.where(known, angles, np.nan)


def _commanded(
    columns: Mapping[Signal, Columns], commands: Sequence[Signal], n: int
) -> tuple[Array, NDArray[np.int64]]:
    """Return delta-v (n, craft, 3) and the source (n,): the worst of the craft's."""
    delta_v = np.full((n, len(commands), 3), np.nan)
    sources = np.full((n, len(commands)), _UNKNOWN)
    for i, signal in enumerate(commands):
        told = columns[signal]
        within = told.steps < n
        if within.any():
            delta_v[told.steps[within], i] = told.fields["delta_v"][within]
            sources[told.steps[within], i] = told.fields["source"][within]
    together = np.where((sources == Source.METHOD).all(axis=1), Source.METHOD, Source.ZERO)
    return delta_v, np.where((sources == _UNKNOWN).all(axis=1), _UNKNOWN, together)


def _overridden(columns: Mapping[Signal, Columns], commands: Sequence[Signal]) -> tuple[int, ...]:
    """Return the steps in which something else was asked of a craft than was commanded."""
    told, found = columns[STATE], set[int]()
    for i, signal in enumerate(commands):
        command = columns[signal]
        both, at, after = np.intersect1d(command.steps, told.steps - 1, return_indices=True)
        if both.size:
            asked = told.fields[APPLIED.control][after, 3 * i : 3 * i + 3]
            other = (command.fields[APPLIED.commanded][at] != asked).any(axis=1)
            found.update(both[other].tolist())
    return tuple(sorted(found))
