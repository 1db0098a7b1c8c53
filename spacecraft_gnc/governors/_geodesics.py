"""Batches of geodesics on SO(3), and their distance to the zones in closed form."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from spacecraft_gnc.governors.tail import kronecker
from spacecraft_gnc.ocp import PointingZone
from spacecraft_gnc.types import Array


def spread(n: int) -> tuple[Array, Array]:
    """Return n attitudes spread evenly over SO(3), (n, 3, 3), and their quaternions (n, 4) x y z w.

    The first m of them are spread evenly, too, whatever m. Shoemake's map takes the unit cube to
    unit quaternions and keeps volumes.
    """
    steps = kronecker(n, 3)
    radius, turns = steps[:, 0], 2.0 * math.pi * steps[:, 1:]
    inner, outer = np.sqrt(1.0 - radius), np.sqrt(radius)
    x, y = inner * np.sin(turns[:, 0]), inner * np.cos(turns[:, 0])
    z, w = outer * np.sin(turns[:, 1]), outer * np.cos(turns[:, 1])
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0), np.stack([x, y, z, w], axis=1)


def geodesics(starts: Array, ends: Array) -> tuple[Array, Array]:
    """Return unit axes (n, 3), body frame, and angles (n,) [rad] of the turns from start to end.

    Either argument is one attitude (3, 3) or n of them. An angle near pi leaves the axis badly
    determined: legs stay well below.
    """
    relative = np.swapaxes(starts, -1, -2) @ ends
    vectors = np.stack(
        [
            relative[..., 2, 1] - relative[..., 1, 2],
            relative[..., 0, 2] - relative[..., 2, 0],
            relative[..., 1, 0] - relative[..., 0, 1],
        ],
        axis=-1,
    )
    twice_sine = np.linalg.norm(vectors, axis=-1)
    angles = np.arctan2(twice_sine, np.trace(relative, axis1=-2, axis2=-1) - 1.0)
    return vectors / np.maximum(twice_sine, 1e-300)[..., None], angles


def closest_approach(
    zones: Sequence[PointingZone], starts: Array, axes: Array, angles: Array
) -> Array:
    """Return the smallest angle (n,) [rad] to any zone along each geodesic (negative: inside).

    Parameters
    ----------
    zones : sequence of PointingZone
    starts : (3, 3) or (n, 3, 3) array
        First attitude of each geodesic, body to inertial.
    axes : (n, 3) array
        Unit axis of the turn, body frame.
    angles : (n,) array
        Angle of the turn [rad].

    Notes
    -----
    Turned by s about n, a body axis v meets the direction d (in the frame of the first attitude)
    at v . exp(-s hat(n)) d = a + b cos(s) + c sin(s) = a + r cos(s - phi): its extremes over
    [0, angle] lie at the ends or, if it is on the way, at phi. Nothing is sampled.
    """
    smallest = np.full(len(angles), math.inf)
    for zone in zones:
        v, sign = np.asarray(zone.body_axis), zone.sign
        d = np.asarray(zone.inertial_axis) @ starts  # R^T d
        along = axes @ v
        a = along * np.sum(axes * d, axis=1)
        b = sign * (d @ v - a)
        c = sign * np.sum(np.cross(axes, v) * d, axis=1)
        phi = np.arctan2(c, b) % (2.0 * math.pi)
        at_ends = np.maximum(b, b * np.cos(angles) + c * np.sin(angles))
        largest = sign * a + np.where(phi <= angles, np.hypot(b, c), at_ends)
        angle = np.arccos(np.clip(sign * largest, -1.0, 1.0))
        smallest = np.minimum(smallest, sign * (angle - zone.half_angle))
    return smallest
