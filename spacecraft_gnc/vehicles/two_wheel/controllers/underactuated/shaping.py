"""Paths of rest-to-rest turns to any attitude, each of which two wheels can make.

With two wheels and no total momentum the bus turns at omega = c_1 nu_1 + c_2 nu_2. A rotation about
a fixed axis a of the plane of c_1 and c_2 is therefore made exactly, from rest to rest, by speeds
nu(t) in a fixed ratio. Let e1, e2, e3 be the prediction frame (`WheelOcp.frame`), with e1 along c_1
and e2 in that plane. Every rotation E is a product of three such turns about e1, e2, e1 (Euler
angles), and also of two about other axes of the plane: the quaternions p of turns about axes of the
plane are those without a part along e3, and p^-1 E = (w, x, y, z) is one as well where

    p . (z, -y, x) = 0,    p = (p_w, p_x, p_y),

one linear equation for a p of three parts, which always has solutions. A path is the product that
takes the wheels the least time (docs/full_range.md).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.types import Array, Matrix3, Vector3
from spacecraft_gnc.vehicles.two_wheel.ocp.problem import WheelOcp

_NOTHING: Final = 1e-12  # [rad] turn that is none


class Path(NamedTuple):
    """Turns one after the other from an attitude at rest."""

    start: Matrix3
    """(3, 3) body to inertial."""
    turns: Array
    """(n, 3) rotation vectors about axes fixed in the body, body frame [rad]; n <= 3."""
    times: Array
    """(n,) that each takes at the limits of the wheels, from rest to rest [s]."""

    @property
    def time(self) -> float:
        """Of all turns [s]."""
        return float(self.times.sum())

    def after(self, time: float) -> Path:
        """Return the rest of the path, from the attitude that lies ``time`` ahead on it."""
        start = self.start
        for i, own in enumerate(self.times):
            if time < own:
                part = time / own
                times = np.append((1.0 - part) * own, self.times[i + 1 :])
                turns = np.vstack([(1.0 - part) * self.turns[i], self.turns[i + 1 :]])
                return Path(start @ lie.exp(part * self.turns[i]), turns, times)
            start, time = start @ lie.exp(self.turns[i]), time - own
        return Path(start, np.empty((0, 3)), np.empty(0))


def path_between(ocp: WheelOcp, start: Matrix3, end: Matrix3) -> Path:
    """Return the fastest path from rest at one attitude to rest at another.

    Parameters
    ----------
    ocp : WheelOcp
        Bus, wheels and their limits.
    start, end : (3, 3) arrays
        Body to inertial.

    Returns
    -------
    Path
        Of at most three turns, whose product is ``start`` transposed times ``end``.
    """
    relative = ocp.frame.T @ start.T @ end @ ocp.frame
    paths = (_path(ocp, start, turns) for turns in _products(relative))
    return min(paths, key=lambda path: path.time)


def turn_time(ocp: WheelOcp, turn: Vector3) -> float:
    """Return the time [s] of a rotation (3,) in the prediction frame, from rest to rest.

    The faster wheel goes up to its limit of speed, if it gets there, and back, at its limit of
    acceleration, if it has one.
    """
    way = float(np.abs(np.linalg.solve(ocp.rates[:2], turn[:2])).max())
    top, most = ocp.max_speed, ocp.max_acceleration
    if not most:
        return way / top
    if way <= top * top / most:
        return 2.0 * math.sqrt(way / most)
    return way / top + top / most


def _path(ocp: WheelOcp, start: Matrix3, turns: Array) -> Path:
    kept = turns[np.linalg.norm(turns, axis=1) > _NOTHING]
    times = np.array([turn_time(ocp, turn) for turn in kept])
    return Path(start, kept @ ocp.frame.T, times)


def _products(relative: Matrix3) -> Iterator[Array]:
    """Yield turns (n, 3) in the prediction frame whose product is a rotation (3, 3)."""
    yield _two_turns(relative)
    for first in (0, 1):
        for upward in (True, False):
            yield _three_turns(relative, first, upward)


def _three_turns(relative: Matrix3, first: int, upward: bool) -> Array:
    """Return turns about e1, e2, e1 (``first`` = 0) or e2, e1, e2 with product ``relative``.

    With i the first axis, j the other one and s = (e_i x e_j) . e3, the column and the row i of
    exp(a e_i) exp(b e_j) exp(c e_i) are

        E_ii = cos b,   E_ji = sin a sin b,  E_3i = -s cos a sin b,
                        E_ij = sin b sin c,  E_i3 = s sin b cos c;

    ``upward``: sin b >= 0.
    """
    i, j = first, 1 - first
    sense = 1.0 if first == 0 else -1.0
    side = 1.0 if upward else -1.0
    sine = math.hypot(relative[j, i], relative[2, i])
    middle = math.atan2(side * sine, relative[i, i])
    begin = 0.0
    if sine > _NOTHING:
        begin = math.atan2(side * relative[j, i], -side * sense * relative[2, i])
    axes = np.eye(3)
    rest = lie.exp(-middle * axes[j]) @ lie.exp(-begin * axes[i]) @ relative
    end = math.atan2(sense * rest[2, j], rest[j, j])
    return np.array([begin * axes[i], middle * axes[j], end * axes[i]])


def _two_turns(relative: Matrix3) -> Array:
    """Return one or two equal turns about axes of the plane, with product ``relative``.

    Of the solutions p of the linear equation, the one halfway between the projections of the
    identity and of E makes both turns equally long.
    """
    x, y, z, w = lie.to_quaternion_xyzw(relative)
    normal = np.array([z, -y, x])
    size = float(np.linalg.norm(normal))
    if abs(z) < _NOTHING:
        return np.array([lie.log(relative)])
    basis = np.linalg.svd(normal[None] / size)[2][1:]  # (2, 3) of the solutions
    here, there = basis[:, 0], basis @ np.array([w, x, y])
    middle = here / max(np.hypot(*here), 1e-300) + there / max(np.hypot(*there), 1e-300)
    if np.hypot(*here) < _NOTHING or np.hypot(*middle) < _NOTHING:
        middle = np.array([1.0, 0.0])  # every solution is a half turn: any of them
    p = middle / np.hypot(*middle) @ basis
    first = lie.exp(_vector(p))
    return np.array([_vector(p), lie.log(first.T @ relative)])


def _vector(p: Array) -> Vector3:
    """Return the rotation vector (3,) of a quaternion (w, x, y) without a part along e3."""
    p = p if p[0] >= 0.0 else -p
    size = math.hypot(p[1], p[2])
    angle = 2.0 * math.atan2(size, p[0])
    return np.array([p[1], p[2], 0.0]) * (angle / size if size > 0.0 else 0.0)
