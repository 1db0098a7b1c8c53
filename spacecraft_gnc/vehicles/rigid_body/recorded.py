"""Flight of a rigid body read from a bag, aligned by control step."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.audit.evidence import Progress
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.plant.actuators import Actuators, component_limits
from spacecraft_gnc.recording.aligned import overridden, period_of, targets_of, times_of
from spacecraft_gnc.recording.bag import Bag
from spacecraft_gnc.recording.columns import Columns, read_columns, require_reach
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.signals.attitude import ACCEPTED_TARGET, GOVERNOR_STATUS, REFERENCE
from spacecraft_gnc.status import NO_SOLVE
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.flight import RigidBodyFlight
from spacecraft_gnc.vehicles.rigid_body.signals import (
    APPLIED,
    INVARIANTS,
    PLAN_STATUS,
    SOLVER_STATUS,
    STATE,
    TORQUE,
)

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario

_TOPICS: Final = (
    STATE, REFERENCE, ACCEPTED_TARGET, TORQUE, SOLVER_STATUS, GOVERNOR_STATUS, INVARIANTS,
    PLAN_STATUS,
)  # fmt: skip
_UNLIMITED: Final = Actuators(None, "N m")
PLANS: Final = ("predicted_attitudes", "predicted_momenta", "predicted_torques")


class Torques(NamedTuple):
    """Torque [N m] and source that acted in each control step."""

    steps: NDArray[np.int64]
    torque: Array
    source: NDArray[np.int64]


class Recorded(NamedTuple):
    """A flight as a bag holds it."""

    trajectory: RigidBodyFlight
    missing: dict[str, tuple[int, ...]]
    """Steps without a message, by topic."""
    overridden: tuple[int, ...]
    """Steps whose applied torque differs from the command."""


def read_recorded(
    bag: Bag, namespace: str | None, scenario: Scenario | None, progress: Progress | None = None
) -> Recorded:
    """Read the flight in a bag; a row that lacks a message holds NaN (status, source: -1).

    The torque of a row is the one that the plant applied, as ``plant_invariants`` tells; where that
    was not recorded it is the command. A flight whose last state was not recorded ends one step
    earlier.

    Raises
    ------
    RecordingError
        If there is no flight in it.
    """
    columns = read_columns(bag, _TOPICS, namespace, progress, leave_out=PLANS)
    most = math.inf if scenario is None else scenario.plant.max_torque or math.inf
    torques = acted(columns, Actuators(component_limits(most), "N m"))
    n = whole_steps(bag, columns, torques)
    missing = _missing(columns, torques)
    period = scenario.period if scenario is not None else period_of(columns[STATE])
    initial = None if scenario is None else lie.exp(scenario.governor.target_rotation_vector)
    targets = targets_of(n, columns[ACCEPTED_TARGET], initial)
    if scenario is not None:
        torques = torques._replace(source=scenario.method.current_sources(torques.source))
    is_moving = scenario is not None and scenario.law.moves and bool(columns[REFERENCE].steps.size)
    trajectory = _trajectory(n, columns, torques, targets, period, is_moving)
    return Recorded(trajectory, missing, overridden(columns, APPLIED))


def acted(columns: Mapping[Signal, Columns], actuators: Actuators = _UNLIMITED) -> Torques:
    """Return what the plant applied; where it did not tell, what actuators give of the command."""
    commands, applied = columns[TORQUE], columns[INVARIANTS]
    told = applied.steps > 0  # an entry tells of the step that ended there
    steps = np.concatenate([applied.steps[told] - 1, commands.steps])
    torque = [applied.fields["applied_torque"][told]] if told.any() else []
    source = [applied.fields["applied_source"][told]] if told.any() else []
    if commands.steps.size:
        torque.append(actuators.given(commands.fields["torque"]))
        source.append(commands.fields["source"])
    if not steps.size:
        return Torques(steps, np.empty((0, 3)), np.empty(0, dtype=np.int64))
    acted, first = np.unique(steps, return_index=True)
    return Torques(acted, np.concatenate(torque)[first], np.concatenate(source)[first])


def whole_steps(bag: Bag, columns: Mapping[Signal, Columns], torques: Torques) -> int:
    """Return the number of whole control steps: those with a state before and after them.

    Raises
    ------
    RecordingError
        If there is none, or a step number lies far beyond what was recorded.
    """
    states = columns[STATE].steps
    count = 0
    require_reach(bag, states, torques.steps)
    if states.size and torques.steps.size:
        count = int(min(torques.steps[-1] + 1, states[-1]))
    if count < 1 or count not in states:
        raise RecordingError(
            f"{bag.path}: received {states.size} states and {torques.steps.size} torques; required "
            "at least one whole control step; record a longer run"
        )
    return count


def _missing(columns: Mapping[Signal, Columns], torques: Torques) -> dict[str, tuple[int, ...]]:
    """Return the steps without a message, by topic; a topic never recorded is not listed."""
    flown = int(torques.steps[-1]) + 1
    missing = {
        STATE: columns[STATE].missing(0, flown),
        TORQUE: tuple(np.setdiff1d(np.arange(flown), torques.steps).tolist()),
    }
    for topic in (REFERENCE, SOLVER_STATUS):
        if columns[topic].steps.size:
            missing[topic] = columns[topic].missing(0, flown - 1)
    return {topic.name: absent for topic, absent in missing.items() if absent}


def _trajectory(
    n: int,
    columns: Mapping[Signal, Columns],
    torques: Torques,
    targets: Array,
    period: float,
    is_moving: bool,
) -> RigidBodyFlight:
    states, references, solves, decisions, planned = (
        columns[topic] for topic in (STATE, REFERENCE, SOLVER_STATUS, GOVERNOR_STATUS, PLAN_STATUS)
    )
    reference = _filled(n, references, "attitude", (9,)).reshape(n, 3, 3)
    if not references.steps.size:  # a run without a governor regulates to the identity
        reference = np.tile(np.eye(3), (n, 1, 1))
    known = np.flatnonzero(np.isfinite(reference).all(axis=(1, 2)))
    last = reference[known[-1]] if known.size else np.full((3, 3), math.nan)
    if is_moving:  # the governor answers the last state, too
        targets, last = (
            reference,
            _placed(n + 1, references.steps, references.fields["attitude"])[n],
        )
    final = int(np.searchsorted(states.steps, n))
    status = _integers(n, -1, solves.steps, solves.fields.get("status"))
    return RigidBodyFlight(
        period=period,
        time=times_of(n, states, period),
        attitude=_filled(n, states, "attitude", (9,)).reshape(n, 3, 3),
        momentum=_filled(n, states, "angular_momentum", (3,)),
        torque=_placed(n, torques.steps, torques.torque),
        external_torque=_external(n, columns[INVARIANTS]),
        reference=reference,
        reference_rate=_feedforward(n, references, "angular_velocity"),
        reference_torque=_feedforward(n, references, "torque"),
        target=targets,
        iterations=_integers(n, 0, solves.steps, solves.fields.get("iterations")),
        residual=_filled(n, solves, "residual"),
        cost=_filled(n, solves, "cost"),
        solve_time=_filled(n, solves, "wall_solve_time"),
        status=np.where(status == NO_SOLVE, -1, status),
        source=_integers(n, -1, torques.steps, torques.source),
        alpha=_filled(n, decisions, "alpha"),
        governor_margin=_filled(n, decisions, "margin"),
        plan=_integers(n, -1, planned.steps, planned.fields.get("number")),
        plan_phase=_integers(n, -1, planned.steps, planned.fields.get("phase")),
        plan_error=_filled(n, planned, "attitude_error"),
        plan_torque=_filled(n, planned, "torque", (3,)),
        plan_momentum=_filled(n, planned, "momentum", (3,)),
        final_attitude=states.fields["attitude"][final].reshape(3, 3),
        final_momentum=states.fields["angular_momentum"][final],
        final_reference=last.reshape(3, 3),
    )


def _feedforward(n: int, references: Columns, name: str) -> Array:
    """Return (n, 3) numbers that come with a reference; zero where a run has no governor."""
    return _filled(n, references, name, (3,)) if references.steps.size else np.zeros((n, 3))


def _external(n: int, invariants: Columns) -> Array:
    """Return (n, 3) torques of the disturbances: each message tells of the step that ended."""
    told = invariants.steps > 0
    values = invariants.fields.get("external_torque", np.empty((0, 3)))
    return _placed(n, invariants.steps[told] - 1, values[told])


def _filled(n: int, columns: Columns, name: str, shape: tuple[int, ...] = ()) -> Array:
    """Return (n, *shape) values of a field by step; NaN where a step has none."""
    return _placed(n, columns.steps, columns.fields.get(name, np.empty((0, *shape))))


def _placed(n: int, steps: NDArray[np.int64], values: Array) -> Array:
    array = np.full((n, *values.shape[1:]), math.nan)
    within = steps < n
    array[steps[within]] = values[within]
    return array


def _integers(
    n: int, absent: int, steps: NDArray[np.int64], values: NDArray[np.int64] | None
) -> NDArray[np.int64]:
    """Return (n,) integers by step; ``absent`` where a step has none."""
    array = np.full(n, absent, dtype=np.int64)
    if values is not None:
        within = steps < n
        array[steps[within]] = values[within]
    return array
