"""Proof that a transfer is too short, from the bounds alone.

**Momentum.** Over a step, Pi_k+1 - h u_k = F^T Pi_k: the norm |Pi| changes by at most h |u|, and
component i by at most h |u_i|, the gyroscopic h |(J^-1 Pi x Pi)_i|, and |q|^2 (2 + s) |Pi| for the
length of the step, where q is the vector part of F, |q| = sin(angle / 2), and
s = (J_max - J_min) / J_min. From both ends, and with its bounds, this is a box for each Pi_k.

**Step.** With w the rotation vector of the step, 2 q0 q + 2 J^-1 (q x J q) = h J^-1 Pi is
sinc(|w|) w = h J^-1 Pi - e, |e| <= s |q|^2. What is convex in Pi is largest at a corner of the box.

**Way.** Let the transfer turn by theta <= pi about n. Steps turn by at most |w| each. Moreover the
body's axis n ends where it began: on the unit sphere it goes round a loop of length
L <= sum |w x n|, and the turn about it is the sum of w . n and the area of the loop, up to whole
turns. A loop of length L < 2 pi encloses at most A(L) = 2 pi - sqrt(4 pi^2 - L^2) (isoperimetric
inequality of the sphere; where it crosses itself, of each of its parts, as A is convex). So

    theta <= max over L of (min over c >= 0 of (sum max(|w . n| + c |w x n|) - c L) + A(L)).

Where one of these fails, no torque within the bounds makes the transfer.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.ocp.transfer._bound_kernels import envelope, farthest
from spacecraft_gnc.ocp.transfer.problem import AttitudeTransfer
from spacecraft_gnc.types import Array, Matrix3

_WEIGHTS: Final = np.concatenate([[0.0], np.geomspace(0.02, 8.0, 19)])
_LENGTHS: Final = 400  # intervals of L
_SURE: Final = 1.0 + 1e-9  # for rounding


def is_too_short(problem: AttitudeTransfer, n_steps: int) -> bool:
    """Tell whether no torque within the bounds makes the transfer in ``n_steps`` steps."""
    body, h = problem.body, problem.body.time_step
    ends = np.abs([problem.start_momentum, problem.goal_momentum])
    torque, box = np.abs(problem.limits).reshape(2, 2, 3).max(axis=1)
    norms = np.linalg.norm(ends, axis=1)
    if abs(norms[0] - norms[1]) > n_steps * h * np.linalg.norm(torque) * _SURE:
        return True
    turn = lie.log(problem.start.T @ problem.goal)
    angle = float(np.linalg.norm(turn))
    if angle == 0.0:
        return False
    moments = np.linalg.eigvalsh(body.inertia)
    spread = (moments[-1] - moments[0]) / moments[0]
    inverse = np.asarray(np.linalg.inv(body.inertia), dtype=np.float64)
    largest, sizes = np.empty((n_steps, 3)), np.empty(n_steps)
    if not envelope(
        h, _gyroscopic(inverse), spread, moments[0], torque, box, ends, np.empty(3), largest, sizes
    ):
        return False
    turned = np.empty(len(_WEIGHTS) + 2)
    farthest(
        h, inverse, spread, moments[0], turn / angle, _WEIGHTS, largest, sizes, np.empty((4, 3)),
        turned,
    )  # fmt: skip
    return min(float(turned[-1]), _most_about_axis(turned[:-2], float(turned[-2]))) * _SURE < angle


def _gyroscopic(inverse: Matrix3) -> Array:
    """Return (3, 3, 3) sizes of the symmetric forms (J^-1 p x p)_i."""
    forms = np.array([np.cross(inverse.T, np.eye(3)[k]) for k in range(3)])  # [k, l, i]: p_k, p_l
    symmetric = 0.5 * (forms + forms.transpose(1, 0, 2))
    return np.asarray(np.abs(symmetric).transpose(2, 0, 1))


def _most_about_axis(weighted: Array, longest: float) -> float:
    """Return the largest angle about the axis, of a loop of at most this length."""
    edges = np.linspace(0.0, longest, _LENGTHS + 1)
    # On each interval, the largest of what decreases with L and of what increases.
    along = (weighted[:, None] - _WEIGHTS[:, None] * edges[:-1]).min(axis=0)
    return float((along + _area(edges[1:])).max())


def _area(length: Array) -> Array:
    """Return the largest area within a loop on the unit sphere."""
    return 2.0 * math.pi - np.sqrt(np.maximum(4.0 * math.pi**2 - length**2, 0.0))


def shortest_possible_steps(problem: AttitudeTransfer) -> int:
    """Return the fewest steps that `is_too_short` does not rule out; a lower bound."""
    low, high = 1, 2
    while is_too_short(problem, high):
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if is_too_short(problem, middle) else (low, middle)
    return high


def time_bound_text(problem: AttitudeTransfer) -> str:
    """Return the lower bound on the time, in words."""
    steps = shortest_possible_steps(problem)
    time = steps * problem.body.time_step
    return (
        f"{problem.duration:g} s are too short for {math.degrees(problem.angle):.6g} deg within "
        f"the bounds: no torque makes it in less than {time:g} s"
    )
