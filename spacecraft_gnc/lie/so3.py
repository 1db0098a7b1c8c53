"""Rotations: the group SO(3), its algebra, and quaternions at the edges.

Conventions
-----------
A rotation maps body to inertial components. Quaternions are unit, ordered x, y, z, w as in ROS,
with w >= 0 where we make them (q and -q are the same rotation). Perturbations are on the right:
R exp(hat(eta)).
"""

from __future__ import annotations

import math

import numpy as np

from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.types import ROTATION_TOLERANCE, Array, Matrix3, Vector3

# --- the algebra so(3) ---------------------------------------------------------------------


def hat(vector: Vector3) -> Matrix3:
    """Return the (3, 3) matrix of the cross product: hat(a) b = a x b."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def vee(matrix: Matrix3) -> Vector3:
    """Return the vector (3,) whose `hat` is the antisymmetric part (A - A^T)/2 of ``matrix``."""
    m = np.asarray(matrix)
    return 0.5 * np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])


# --- exponential and logarithm -------------------------------------------------------------


def exp(rotation_vector: Vector3) -> Matrix3:
    """Return the rotation (3, 3) by ``|v|`` radians about ``v`` (3,).

    R = I + 2 w hat(q) + 2 hat(q)^2 with q = sin(|v|/2) v/|v|, w = cos(|v|/2): the half angle keeps
    full precision at every angle.
    """
    vector = np.asarray(rotation_vector, dtype=np.float64)
    half = 0.5 * float(np.linalg.norm(vector))
    q = (0.5 * np.sinc(half / math.pi)) * vector
    return _from_half_angle(q, math.cos(half))


def log(rotation: Matrix3) -> Vector3:
    """Return the rotation vector (3,) of ``rotation``, with length in [0, pi] [rad].

    Notes
    -----
    At exactly pi the axis is defined up to its sign; its largest component is then positive.
    """
    q = to_quaternion_xyzw(rotation)
    sine = float(np.linalg.norm(q[:3]))
    if sine == 0.0:
        return np.zeros(3)
    angle = 2.0 * math.atan2(sine, float(q[3]))
    return np.asarray((angle / sine) * q[:3])


def angle_between(first: Matrix3, second: Matrix3) -> float:
    """Return the angle in [0, pi] [rad] of the rotation from ``first`` to ``second``."""
    relative = np.asarray(first).T @ np.asarray(second)
    sine = float(np.linalg.norm(vee(relative)))
    return math.atan2(sine, 0.5 * (float(np.trace(relative)) - 1.0))


def angles_between(first: Array, second: Array) -> Array:
    """Return `angle_between` for stacks (n, 3, 3) of rotations, as (n,) [rad]."""
    relative = np.einsum("nji,njk->nik", first, np.broadcast_to(second, first.shape))
    antisymmetric = 0.5 * (relative - relative.transpose(0, 2, 1))
    sine = np.sqrt(0.5 * np.einsum("nij,nij->n", antisymmetric, antisymmetric))
    return np.asarray(np.arctan2(sine, 0.5 * (np.trace(relative, axis1=1, axis2=2) - 1.0)))


# --- quaternions (message edges only) ------------------------------------------------------


def to_quaternion_xyzw(rotation: Matrix3) -> Array:
    """Return the unit quaternion (4,) x, y, z, w of ``rotation``, w >= 0.

    The largest of the four squared components is found first, so that nothing is divided by a
    small number (Shepperd's method).
    """
    r = np.asarray(rotation)
    trace = float(r[0, 0] + r[1, 1] + r[2, 2])
    squares = [1.0 + 2.0 * float(r[i, i]) - trace for i in range(3)] + [1.0 + trace]
    largest = int(np.argmax(squares))
    if largest == 3:
        raw = [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], squares[3]]
    else:
        i, j, k = largest, (largest + 1) % 3, (largest + 2) % 3
        raw = [0.0] * 4
        raw[i] = squares[i]
        raw[j] = float(r[i, j] + r[j, i])
        raw[k] = float(r[i, k] + r[k, i])
        raw[3] = float(r[k, j] - r[j, k])
    q = np.array(raw) / np.linalg.norm(raw)
    return np.asarray(-q if q[3] < 0.0 else q)


def from_quaternion_xyzw(quaternion: Array) -> Matrix3:
    """Return the rotation (3, 3) of a quaternion (4,) x, y, z, w; it is normalised first.

    Raises
    ------
    ShapeError, ParameterError
        If it is not four finite numbers of non-zero norm.
    """
    q = np.asarray(quaternion, dtype=np.float64)
    if q.shape != (4,):
        raise ShapeError(
            f"quaternion: received an array of shape {q.shape}; required 4 numbers x, y, z, w"
        )
    norm = float(np.linalg.norm(q))
    if not math.isfinite(norm) or norm < 1e-9:
        raise ParameterError(
            f"quaternion: received {q.tolist()}; required four finite numbers of non-zero norm; "
            "give x, y, z, w"
        )
    q = q / norm
    return _from_half_angle(q[:3], float(q[3]))


def is_rotation(matrix: Matrix3, tolerance: float = ROTATION_TOLERANCE) -> bool:
    """Tell whether ``matrix`` is finite, orthonormal within ``tolerance``, and proper."""
    m = np.asarray(matrix)
    if m.shape != (3, 3) or not np.isfinite(m).all():
        return False
    return bool(np.linalg.norm(m.T @ m - np.eye(3)) <= tolerance and np.linalg.det(m) > 0.0)


def orthonormalize(matrix: Matrix3) -> Matrix3:
    """Return the rotation (3, 3) nearest to ``matrix`` in the Frobenius norm."""
    u, _, vt = np.linalg.svd(matrix)
    u[:, -1] *= np.sign(np.linalg.det(u @ vt))
    return np.asarray(u @ vt)


def _from_half_angle(q: Vector3, w: float) -> Matrix3:
    q_hat = hat(q)
    return np.asarray(np.eye(3) + 2.0 * w * q_hat + 2.0 * (q_hat @ q_hat))
