"""Circles on the unit sphere: cones and the graticule."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import numpy as np

from spacecraft_gnc.types import Array

_WHEEL_REACH: Final = 0.4  # of the rim of a wheel from the center of the sphere
_WHEEL_ANGLE: Final = 0.36  # [rad] of its rim, seen from there
_EVERY: Final = 30.0  # [deg] between two circles of the graticule


def circle(axis: Array, half_angle: float, points: int) -> Array:
    """Return a closed circle on the unit sphere, where a cone cuts it.

    Parameters
    ----------
    axis
        (3,) unit vector of the cone.
    half_angle
        Of the cone [rad].
    points
        Of the circle; the first one follows once more at the end.

    Returns
    -------
    array
        (points + 1, 3).
    """
    helper = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = np.cross(axis, helper)
    first /= np.linalg.norm(first)
    turn = np.linspace(0.0, 2.0 * math.pi, points + 1)
    around = np.outer(np.cos(turn), first) + np.outer(np.sin(turn), np.cross(axis, first))
    return np.asarray(math.cos(half_angle) * axis + math.sin(half_angle) * around)


def rim(axis: Array) -> Array:
    """Return the rim (37, 3) of a wheel in the unit sphere, turned about ``axis`` (3,)."""
    return _WHEEL_REACH * circle(axis, _WHEEL_ANGLE, 36)


def graticule(points: int) -> Iterator[Array]:
    """Yield the circles (points + 1, 3) of latitude and longitude, every 30 degrees."""
    for latitude in np.radians(np.arange(-90.0 + _EVERY, 90.0, _EVERY)):
        yield circle(np.array([0.0, 0.0, 1.0]), math.pi / 2 - latitude, points)
    for longitude in np.radians(np.arange(0.0, 180.0, _EVERY)):
        normal = np.array([-math.sin(longitude), math.cos(longitude), 0.0])
        yield circle(normal, math.pi / 2, points)
