"""Docking flight read from a bag, aligned by control step."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from spacecraft_gnc.audit.evidence import Progress
from spacecraft_gnc.recording.aligned import (
    at_steps,
    missing_steps,
    overridden,
    period_of,
    times_of,
    whole_steps,
)
from spacecraft_gnc.recording.bag import Bag
from spacecraft_gnc.recording.columns import Columns, read_columns
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

_SIGNALS: Final = (STATE, REFERENCE, ACCEPTED_TARGET, COMMAND, GOVERNOR_STATUS)
_HALVES: Final = (("force", slice(3)), ("moment", slice(3, None)))
_ANSWERS: Final = (COMMAND, REFERENCE, GOVERNOR_STATUS)


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
    n = whole_steps(bag, columns, APPLIED)
    period = period_of(columns[STATE]) if scenario is None else scenario.period
    named = {signal.name: columns[signal] for signal in _SIGNALS}
    values = {
        name: at_steps(named.get(column.signal), column, n)
        for name, column in DockingFlight.columns()
    }
    wrench = _rows(columns[COMMAND], ("wrench",), n)
    values |= {name: wrench[:, half] for name, half in _HALVES}
    values["reference"] = _rows(columns[REFERENCE], ("port_offset", "rotation_vector"), n)
    values["target"] = _targets(n, columns[ACCEPTED_TARGET], scenario)
    flight = DockingFlight(period=period, time=times_of(n, columns[STATE], period), **values)
    return Recorded(flight, missing_steps(columns, STATE, _ANSWERS), overridden(columns, APPLIED))


def _rows(columns: Columns, names: tuple[str, ...], n: int) -> Array:
    """Return fields side by side (n, 6) by step; NaN where there is no message."""
    rows = np.full((n, 6), np.nan)
    if not columns.steps.size:
        return rows
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
