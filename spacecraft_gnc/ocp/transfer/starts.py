"""Plans to start a solve from: along the eigenaxis, off it, and the other way round.

The eigenaxis plan of a transfer about a principal axis is symmetric, and so is every iterate from
it: it leads to a saddle where the optimum leaves the axis. Those off the axis are not symmetric.

Ways that turn by a whole turn more or less lead to minima of their own. Which one is the cheapest
depends on the way that the momenta at the ends lead the body by themselves.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from typing import Final, NamedTuple

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.ocp.transfer.problem import AttitudeTransfer
from spacecraft_gnc.types import Array, Vector3

STRAIGHT: Final = "eigenaxis"
_TILT: Final = 0.35  # of the rate off the axis, over the largest along it
_OFF: Final = (("off axis 1+", 1.0, 0.25), ("off axis 1-", -1.0, -0.25),
               ("off axis 2+", -0.25, 1.0), ("off axis 2-", 0.25, -1.0))  # fmt: skip
NAMES: Final = (STRAIGHT, *(name for name, _, _ in _OFF))
OTHER_WAY: Final = "other way"
_OTHER_WAY_OFF: Final = {
    "other way, off axis": (-0.25, 1.0),
    "other way, far off axis": (-0.5, 2.0),
}
COASTING: Final = "coasting"
_OFF_AXIS: Final = {name: (first, second) for name, first, second in _OFF} | _OTHER_WAY_OFF
_ONE_WAY: Final = 2.1
"""Turn and drift [rad] up to which the other ways are not tried. In an isotropic body without
bounds they cannot be cheaper below pi; of the transfers measured, none was below 3.4."""


class Start(NamedTuple):
    """Torque (N, 3) [N m] and momentum (N+1, 3) [N m s] to start from; they need not agree."""

    name: str
    torque: Array
    momentum: Array


def to_try(problem: AttitudeTransfer, least: int, minima: Collection[str]) -> Iterator[str]:
    """Yield the names of the starts, the next one when ``minima`` tells what led to a minimum.

    The first ``least`` are tried in any case, the others about the axis only where there is none.
    """
    yield from NAMES[:least]
    if has_other_ways(problem):
        yield OTHER_WAY
        if OTHER_WAY not in minima:
            yield from _OTHER_WAY_OFF
        yield COASTING
    for name in NAMES[least:]:
        if not minima:
            yield name


def has_other_ways(problem: AttitudeTransfer) -> bool:
    """Tell whether turning the other way, or with the momenta of the ends, may be cheaper."""
    drift = float(np.linalg.norm(_mean_rate(problem))) * problem.duration
    return problem.angle + drift > _ONE_WAY


def make_start(problem: AttitudeTransfer, name: str) -> Start:
    """Return a start: a cubic turn about an axis, and a loop off it."""
    if name == COASTING:
        return _make_coasting(problem)
    turn, part = _turn(problem), _parts(problem)
    if name == OTHER_WAY or name in _OTHER_WAY_OFF:
        turn = turn - 2.0 * math.pi * _axis(turn)
    rate = turn * (6.0 * part * (1.0 - part) / problem.duration)
    if name in _OFF_AXIS:
        first, second = _OFF_AXIS[name]
        size, axis = float(np.linalg.norm(turn)), _axis(turn)
        e1 = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
        e1 /= np.linalg.norm(e1)
        off = first * e1 + second * np.cross(axis, e1)
        peak = _TILT * 1.5 * max(size, 0.1) / problem.duration
        rate = rate + peak * np.sin(2.0 * np.pi * part) * off
    ends = problem.start_momentum * (1.0 - part) ** 3 + problem.goal_momentum * part**3
    return _make(problem, name, rate @ problem.body.inertia + ends)


def _make_coasting(problem: AttitudeTransfer) -> Start:
    """Return the turn to which the rates of the ends lead, and the rest of the way from there."""
    part, T = _parts(problem), problem.duration
    first, last = np.linalg.solve(problem.body.inertia, _ends(problem)).T
    drift = _mean_rate(problem) * T
    turn = drift + lie.log(lie.exp(-drift) @ problem.start.T @ problem.goal)
    rate = first * (1.0 - part) * (1.0 - 3.0 * part) + last * part * (3.0 * part - 2.0)
    rate = rate + turn * (6.0 * part * (1.0 - part) / T)
    return _make(problem, COASTING, rate @ problem.body.inertia)


def _make(problem: AttitudeTransfer, name: str, momentum: Array) -> Start:
    """Return the start with a momentum, and the torque that it takes."""
    inertia = problem.body.inertia
    momentum[0], momentum[-1] = problem.start_momentum, problem.goal_momentum
    middle = 0.5 * (momentum[1:] + momentum[:-1])
    gyroscopic = np.cross(np.linalg.solve(inertia, middle.T).T, middle)
    return Start(name, np.diff(momentum, axis=0) / problem.body.time_step + gyroscopic, momentum)


def _parts(problem: AttitudeTransfer) -> Array:
    return np.linspace(0.0, 1.0, problem.n_steps + 1)[:, None]


def _turn(problem: AttitudeTransfer) -> Vector3:
    return lie.log(problem.start.T @ problem.goal)


def _axis(turn: Vector3) -> Vector3:
    size = float(np.linalg.norm(turn))
    return turn / size if size > 1e-9 else np.array([1.0, 0.0, 0.0])


def _ends(problem: AttitudeTransfer) -> Array:
    """Return (3, 2) first and last momentum."""
    return np.column_stack([problem.start_momentum, problem.goal_momentum])


def _mean_rate(problem: AttitudeTransfer) -> Vector3:
    """Return the mean of the first and the last angular velocity (3,) [rad/s]."""
    rates = np.linalg.solve(problem.body.inertia, _ends(problem))
    return np.asarray(rates.mean(axis=1), dtype=np.float64)
