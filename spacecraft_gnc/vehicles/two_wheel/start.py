"""Attitudes that a scenario gives, without kernels."""

from __future__ import annotations

import math

import numpy as np

from spacecraft_gnc.types import Array, ArrayLike, Matrix3
from spacecraft_gnc.vehicles.two_wheel.euler import from_euler_321


def attitude_at(euler_321: ArrayLike, rotation_vector: ArrayLike) -> Matrix3:
    """Return the attitude (3, 3) of the Euler angles, of the vector where those are not given."""
    angles = np.asarray(euler_321, dtype=np.float64)
    if angles.size == 3 and np.isfinite(angles).all():
        return from_euler_321(angles)
    return rotation(np.asarray(rotation_vector, dtype=np.float64))


def rotation(vector: Array) -> Matrix3:
    """Return the rotation (3, 3) of a rotation vector, by Rodrigues' formula."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector
    hat = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    half = np.sinc(0.5 * angle / math.pi)
    return np.asarray(np.eye(3) + np.sinc(angle / math.pi) * hat + 0.5 * half**2 * hat @ hat)
