"""Flight of a spacecraft with wheels read from a bag, aligned by control step."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

from spacecraft_gnc import lie
from spacecraft_gnc.audit.evidence import Progress
from spacecraft_gnc.recording.aligned import (
    at_steps,
    missing_steps,
    overridden,
    period_of,
    targets_of,
    times_of,
    whole_steps,
)
from spacecraft_gnc.recording.bag import Bag
from spacecraft_gnc.recording.columns import read_columns
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
_SIGNALS: Final = (STATE, REFERENCE, ACCEPTED_TARGET, COMMAND, SOLVER_STATUS, DIAGNOSIS)
_ANSWERS: Final = (COMMAND, REFERENCE, SOLVER_STATUS, DIAGNOSIS)


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
    n = whole_steps(bag, columns, APPLIED)
    period = period_of(columns[STATE]) if scenario is None else scenario.period
    named = {signal.name: columns[signal] for signal in _SIGNALS}
    values = {
        name: at_steps(named.get(column.signal), column, n)
        for name, column in WheelFlight.columns()
    }
    without = values["status"] == NO_SOLVE
    values["status"][without] = values["terminal"][without] = -1
    values["euler_321"] = to_euler_321(values["attitude"])
    initial = None if scenario is None else lie.exp(scenario.governor.target_rotation_vector)
    values["target"] = targets_of(n, columns[ACCEPTED_TARGET], initial)
    flight = WheelFlight(period=period, time=times_of(n, columns[STATE], period), **values)
    return Recorded(flight, missing_steps(columns, STATE, _ANSWERS), overridden(columns, APPLIED))
