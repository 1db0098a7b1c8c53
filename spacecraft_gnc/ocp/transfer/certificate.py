"""Proof that a transfer is too short, from the bounds alone.

**Momentum.** Over a step, Pi_k+1 - h u_k = F^T Pi_k: the norm |Pi| changes by at most h |u|, and
component i by at most h |u_i|, the gyroscopic h |(J^-1 Pi x Pi)_i|, and |q|^2 (2 + s) |Pi| for the
length of the step, where q is the vector part of F, |q| = sin(angle / 2), and
s = (J_max - J_min) / J_min. From both ends, and with its bounds, this is a box for each Pi_k.

**Step.** With w the rotation vector of the step, 2 q0 q + 2 J^-1 (q x J q) = h J^-1 Pi is
sinc(|w|) w = h J^-1 Pi - e, |e| <= s |q|^2. What is convex in Pi is largest at a corner of the box.

**Way.** Steps turn by at most |w| each, which have to add up to the angle of the transfer.
Moreover, for any axis a of the body, the transfer swings a by phi and turns by tau <= pi about it.
On the unit sphere, a goes a way of length L, phi <= L <= sum |w x a|, and tau is the sum of w . a
and the area between this way and the shortest one, up to whole turns. That area is at most

    D(L) = min(A(L + phi), A(2 L) / 2),    A(l) = 2 pi - sqrt(4 pi^2 - l^2),

as a loop of length l < 2 pi encloses at most A(l) (isoperimetric inequality of the sphere; where
the loop crosses itself, of each of its parts, as A is convex), and the way with itself, turned by
half a turn about the middle between its ends, is a loop too. So for each a

    tau <= max over L of (min over c >= 0 of (sum max(|w . a| + c |w x a|) - c L) + D(L)).

The axis of the transfer itself is tried (phi = 0), those on which the torque limits the turn (for
a diagonal inertia the axes of the body), and some between them.

Where one of these fails, no torque within the bounds makes the transfer.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.ocp.transfer._bound_kernels import envelope, farthest
from spacecraft_gnc.ocp.transfer.problem import AttitudeTransfer
from spacecraft_gnc.types import Array, Matrix3, Vector3

_WEIGHTS: Final = np.concatenate([[0.0], np.geomspace(0.02, 8.0, 19)])
_LENGTHS: Final = 400  # intervals of L
_SHARES: Final = (1.0, 0.5, 0.75, 0.25)  # of an axis of the body, the rest of the transfer's
_SURE: Final = 1.0 + 1e-9  # for rounding


def is_too_short(problem: AttitudeTransfer, n_steps: int, thorough: bool = True) -> bool:
    """Tell whether no torque within the bounds makes the transfer in ``n_steps`` steps.

    Unless it is to be ``thorough``, of the axes only that of the transfer is tried.
    """
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
    for axis in _axes(turn / angle, body.inertia) if thorough else [turn / angle]:
        farthest(h, inverse, spread, moments[0], axis, _WEIGHTS, largest, sizes, turned)
        if turned[-1] * _SURE < angle or _is_out_of_reach(turn, axis, turned):
            return True
    return False


def _axes(direction: Vector3, inertia: Matrix3) -> Iterator[Vector3]:
    """Yield the axes of the body that are tried, the transfer's first."""
    yield direction
    for share in _SHARES:
        for row in inertia:
            facet = math.copysign(1.0, row @ direction) * row / np.linalg.norm(row)
            axis = (1.0 - share) * direction + share * facet
            yield axis / np.linalg.norm(axis)


def _gyroscopic(inverse: Matrix3) -> Array:
    """Return (3, 3, 3) sizes of the symmetric forms (J^-1 p x p)_i."""
    forms = np.array([np.cross(inverse.T, np.eye(3)[k]) for k in range(3)])  # [k, l, i]: p_k, p_l
    symmetric = 0.5 * (forms + forms.transpose(1, 0, 2))
    return np.ascontiguousarray(np.abs(symmetric).transpose(2, 0, 1))


def _is_out_of_reach(turn: Vector3, axis: Vector3, turned: Array) -> bool:
    """Tell whether the swing of the axis, or the turn about it, is more than can be made."""
    angle = float(np.linalg.norm(turn))
    along = math.sin(0.5 * angle) * float(turn @ axis) / angle
    about = 2.0 * math.atan2(abs(along), math.cos(0.5 * angle))
    swing = 2.0 * math.acos(min(1.0, math.hypot(along, math.cos(0.5 * angle))))
    longest = float(turned[-2]) * _SURE
    if longest < swing:
        return True
    if longest >= 2.0 * math.pi:  # a loop of that length encloses any area
        return False
    edges = np.linspace(swing, longest, _LENGTHS + 1)
    # On each interval, the largest of what decreases with L and of what increases.
    directly = (turned[:-2, None] - _WEIGHTS[:, None] * edges[:-1]).min(axis=0)
    area = np.minimum(_area(edges[1:] + swing), 0.5 * _area(2.0 * edges[1:]))
    return float((directly + area).max()) * _SURE < about


def _area(length: Array) -> Array:
    """Return the largest area within a loop on the unit sphere; infinite from 2 pi on."""
    rest = 4.0 * math.pi**2 - length**2
    return np.where(rest > 0.0, 2.0 * math.pi - np.sqrt(np.maximum(rest, 0.0)), math.inf)


def shortest_possible_steps(problem: AttitudeTransfer) -> int:
    """Return the fewest steps that `is_too_short` does not rule out; 2, as a plan has, at least."""
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
