"""A recorded flight as a trajectory, from a bag or from a file of ``gnc simulate``."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.loop.trajectory import Trajectory
from spacecraft_gnc.recording.bag import Bag, open_bag
from spacecraft_gnc.recording.run_info import SCENARIO_ATTACHMENT, RunInfo, parse_scenario
from spacecraft_gnc.recording.steps import (
    GOVERNOR_STATUS,
    INVARIANTS,
    REFERENCE,
    SOLVER_STATUS,
    STATE,
    TORQUE,
    Steps,
    read_steps,
)
from spacecraft_gnc.types import Array

NPZ_SUFFIX: Final = ".npz"
_NO_SOLVE: Final = 255  # SolverStatus.NO_SOLVE
_GRID_TOLERANCE: Final = 1e-6  # [s] stamps are whole nanoseconds, the grid is k times the period


class Flight(NamedTuple):
    """A recorded run."""

    trajectory: Trajectory
    info: RunInfo


class _Rows(NamedTuple):
    """Messages of the flight by step, and the number of whole control steps."""

    n: int
    states: Mapping[int, Any]
    references: Mapping[int, Any]
    statuses: Mapping[int, Any]
    torques: Mapping[int, tuple[Sequence[float], int]]
    """Torque [N m] and source that acted in each step."""
    decisions: Mapping[int, Any]
    """The governor's."""


def load_run(path: Path | str, *, allow_unfinished: bool = False) -> Flight:
    """Read a run: bag folder, .mcap file, or .npz file of ``gnc simulate --out``.

    Parameters
    ----------
    path
        What to read.
    allow_unfinished
        Read what is whole of a bag that was cut off, instead of refusing it.

    Raises
    ------
    RecordingError
        If it is none of these, or damaged.
    """
    path = Path(path)
    if path.suffix == NPZ_SUFFIX and not path.is_dir():
        return Flight(Trajectory.load(path), RunInfo(path=path))
    return read_flight(path, allow_unfinished=allow_unfinished)


def read_flight(
    path: Path | str, *, namespace: str | None = None, allow_unfinished: bool = False
) -> Flight:
    """Read the flight in a bag, its topics aligned by the control step in every message.

    The torque of a row is the one that the plant applied, as ``plant_invariants`` tells; where that
    was not recorded it is the command. A row that lacks a message holds NaN in its place (status
    and source: -1), and `RunInfo.missing` names the step. A flight whose last state was not
    recorded ends one step earlier.

    Parameters
    ----------
    path
        Bag folder or .mcap file.
    namespace
        Of the spacecraft, where the bag holds several.
    allow_unfinished
        Read what is whole of a bag that was cut off, instead of refusing it.

    Raises
    ------
    RecordingError
        If there is no readable bag, or no flight of one spacecraft in it.
    """
    with open_bag(path, allow_unfinished=allow_unfinished) as bag:
        topics = (STATE, REFERENCE, TORQUE, SOLVER_STATUS, GOVERNOR_STATUS, INVARIANTS)
        steps = read_steps(bag, topics, namespace)
        text = bag.attachments().get(SCENARIO_ATTACHMENT, b"").decode(errors="replace")
        scenario, problem = parse_scenario(text, bag.path)
        rows = _rows(bag, steps)
        info = RunInfo(
            path=bag.path,
            scenario=scenario,
            scenario_text=text,
            scenario_problem=problem,
            unfinished=bag.unfinished,
            missing=_missing(steps, rows),
            overridden=_overridden(steps),
            metadata=bag.metadata(),
        )
    period = scenario.period if scenario is not None else _period(rows.states)
    return Flight(_trajectory(rows, period), info)


def _rows(bag: Bag, steps: Mapping[str, Steps]) -> _Rows:
    """Find the whole control steps: those with a state before and after them."""
    states = steps[STATE].messages
    torques = {
        step: (_xyz(message.torque), int(message.source))
        for step, message in steps[TORQUE].messages.items()
    }
    for step, message in steps[INVARIANTS].messages.items():
        if step > 0:  # it tells of the step that ended there
            torques[step - 1] = (_xyz(message.applied_torque), int(message.applied_source))
    count = min(max(torques, default=-1) + 1, max(states, default=-1))
    if count < 1 or count not in states:
        raise RecordingError(
            f"{bag.path}: received {len(states)} states and {len(torques)} torques; required at "
            "least one whole control step; record a longer run"
        )
    references, statuses, decisions = (
        steps[topic].messages for topic in (REFERENCE, SOLVER_STATUS, GOVERNOR_STATUS)
    )
    return _Rows(count, states, references, statuses, torques, decisions)


def _missing(steps: Mapping[str, Steps], rows: _Rows) -> dict[str, tuple[int, ...]]:
    """Return the steps without a message, by topic; a topic never recorded is not listed."""
    flown = max(rows.torques) + 1
    missing = {
        STATE: steps[STATE].missing(flown),
        TORQUE: tuple(step for step in range(flown) if step not in rows.torques),
        REFERENCE: steps[REFERENCE].missing(flown - 1) if rows.references else (),
        SOLVER_STATUS: steps[SOLVER_STATUS].missing(flown - 1) if rows.statuses else (),
    }
    return {topic: absent for topic, absent in missing.items() if absent}


def _overridden(steps: Mapping[str, Steps]) -> tuple[int, ...]:
    applied = steps[INVARIANTS].messages
    return tuple(
        step
        for step, message in sorted(steps[TORQUE].messages.items())
        if step + 1 in applied and _xyz(applied[step + 1].applied_torque) != _xyz(message.torque)
    )


def _period(states: Mapping[int, Any]) -> float:
    """Return the control period [s] from the stamps of the first and the last state."""
    first, last = min(states), max(states)
    return round((_stamp(states[last]) - _stamp(states[first])) / (last - first), 9)


def _trajectory(rows: _Rows, period: float) -> Trajectory:
    n, statuses = rows.n, rows.statuses
    reference = _filled(n, (3, 3), rows.references, lambda m: _matrix(m.attitude))
    if not rows.references:  # a run without a governor regulates to the identity
        reference = np.tile(np.eye(3), (n, 1, 1))
    known = np.flatnonzero(np.isfinite(reference).all(axis=(1, 2)))
    final = rows.states[n]
    return Trajectory(
        period=period,
        time=_times(rows, period),
        attitude=_filled(n, (3, 3), rows.states, lambda m: _matrix(m.attitude)),
        momentum=_filled(n, (3,), rows.states, lambda m: _xyz(m.angular_momentum)),
        torque=_filled(n, (3,), rows.torques, lambda torque: torque[0]),
        reference=reference,
        iterations=_filled_integers(n, 0, statuses, lambda m: m.iterations),
        residual=_filled(n, (), statuses, lambda m: m.residual),
        cost=_filled(n, (), statuses, lambda m: m.cost),
        solve_time=_filled(n, (), statuses, lambda m: m.wall_solve_time),
        status=_filled_integers(
            n, -1, statuses, lambda m: -1 if m.status == _NO_SOLVE else m.status
        ),
        source=_filled_integers(n, -1, rows.torques, lambda torque: torque[1]),
        alpha=_filled(n, (), rows.decisions, lambda m: m.alpha),
        governor_margin=_filled(n, (), rows.decisions, lambda m: m.margin),
        final_attitude=_matrix(final.attitude),
        final_momentum=np.array(_xyz(final.angular_momentum)),
        final_reference=reference[known[-1]] if known.size else np.full((3, 3), math.nan),
    )


def _times(rows: _Rows, period: float) -> Array:
    """Return (n,) times of the steps: the grid, unless the stamps tell otherwise."""
    grid = np.asarray(period * np.arange(rows.n), dtype=np.float64)
    stamps = _filled(rows.n, (), rows.states, _stamp)
    recorded = np.isfinite(stamps)
    if np.allclose(stamps[recorded], grid[recorded], rtol=0.0, atol=_GRID_TOLERANCE):
        return grid
    return np.asarray(np.where(recorded, stamps, grid))


def _filled(
    n: int, shape: tuple[int, ...], by_step: Mapping[int, Any], value: Callable[[Any], Any]
) -> Array:
    """Return (n, *shape) values by step; NaN where a step has none."""
    array = np.full((n, *shape), math.nan)
    for step, item in by_step.items():
        if step < n:
            array[step] = value(item)
    return array


def _filled_integers(
    n: int, absent: int, by_step: Mapping[int, Any], value: Callable[[Any], int]
) -> NDArray[np.int64]:
    """Return (n,) integers by step; ``absent`` where a step has none."""
    array = np.full(n, absent, dtype=np.int64)
    for step, item in by_step.items():
        if step < n:
            array[step] = value(item)
    return array


def _xyz(vector: Any) -> tuple[float, float, float]:
    return vector.x, vector.y, vector.z


def _matrix(nine: Any) -> Array:
    return np.asarray(nine, dtype=np.float64).reshape(3, 3)


def _stamp(message: Any) -> float:
    stamp = message.header.stamp
    return float(stamp.sec + 1e-9 * stamp.nanosec)
