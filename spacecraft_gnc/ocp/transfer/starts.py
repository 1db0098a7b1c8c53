"""Plans to start a solve from: along the eigenaxis, and off it.

The eigenaxis plan of a transfer about a principal axis is symmetric, and so is every iterate from
it: it leads to a saddle where the optimum leaves the axis. The others have no such symmetry.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.ocp.transfer.problem import AttitudeTransfer
from spacecraft_gnc.types import Array

STRAIGHT: Final = "eigenaxis"
_TILT: Final = 0.35  # of the rate off the axis, over the largest along it
_OFF: Final = (("off axis 1+", 1.0, 0.25), ("off axis 1-", -1.0, -0.25),
               ("off axis 2+", -0.25, 1.0), ("off axis 2-", 0.25, -1.0))  # fmt: skip
NAMES: Final = (STRAIGHT, *(name for name, _, _ in _OFF))


class Start(NamedTuple):
    """Torque (N, 3) [N m] and momentum (N+1, 3) [N m s] to start from; they need not agree."""

    name: str
    torque: Array
    momentum: Array


def make_start(problem: AttitudeTransfer, name: str) -> Start:
    """Return a start: a cubic turn about the eigenaxis, and a loop off it."""
    turn = lie.log(problem.start.T @ problem.goal)
    part = np.linspace(0.0, 1.0, problem.n_steps + 1)[:, None]
    rate = turn * (6.0 * part * (1.0 - part) / problem.duration)
    for which, first, second in _OFF:
        if which == name:
            size = float(np.linalg.norm(turn))
            axis = turn / size if size > 1e-9 else np.array([1.0, 0.0, 0.0])
            e1 = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
            e1 /= np.linalg.norm(e1)
            off = first * e1 + second * np.cross(axis, e1)
            peak = _TILT * 1.5 * max(size, 0.1) / problem.duration
            rate = rate + peak * np.sin(2.0 * np.pi * part) * off
    inertia = problem.body.inertia
    ends = problem.start_momentum * (1.0 - part) ** 3 + problem.goal_momentum * part**3
    momentum = rate @ inertia + ends
    momentum[0], momentum[-1] = problem.start_momentum, problem.goal_momentum
    middle = 0.5 * (momentum[1:] + momentum[:-1])
    gyroscopic = np.cross(np.linalg.solve(inertia, middle.T).T, middle)
    return Start(name, np.diff(momentum, axis=0) / problem.body.time_step + gyroscopic, momentum)
