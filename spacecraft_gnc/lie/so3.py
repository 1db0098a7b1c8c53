"""Rotations: the group SO(3), its algebra, and conversions to quaternions.

Conventions
-----------
A rotation maps body to inertial components. Quaternions are unit, ordered x, y, z, w as in ROS;
those returned have w >= 0 (q and -q are the same rotation). Perturbations are on the right:
R exp(hat(eta)).
"""

from __future__ import annotations

import math

import numpy as np

from spacecraft_gnc.arguments import as_limit
from spacecraft_gnc.arrays import as_finite, as_shaped, as_stack
from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.types import ROTATION_TOLERANCE, Array, Matrix3, Vector3

# --- the algebra so(3) ---------------------------------------------------------------------


def hat(vector: Vector3) -> Matrix3:
    """Return the (3, 3) matrix of the cross product: hat(a) b = a x b."""
    return _hat(as_shaped("vector", vector, (3,)))


def _hat(vector: Vector3) -> Matrix3:
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def vee(matrix: Matrix3) -> Vector3:
    """Return the vector (3,) whose `hat` is the antisymmetric part (A - A^T)/2 of ``matrix``."""
    m = as_shaped("matrix", matrix, (3, 3))
    return 0.5 * np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])


# --- exponential and logarithm -------------------------------------------------------------


def exp(rotation_vector: Vector3) -> Matrix3:
    """Return the rotation (3, 3) by ``|v|`` radians about ``v`` (3,).

    R = I + 2 w hat(q) + 2 hat(q)^2 with q = sin(|v|/2) v/|v|, w = cos(|v|/2): the half angle keeps
    full precision at every angle.

    Raises
    ------
    ShapeError, ParameterError
        If it is not three finite numbers.
    """
    vector = as_shaped("rotation_vector", rotation_vector, (3,))
    half = 0.5 * float(np.linalg.norm(vector))
    if not math.isfinite(half):
        raise ParameterError(
            f"rotation_vector: received {vector.tolist()}; required 3 finite numbers [rad]; remove "
            "NaN and infinity"
        )
    q = (0.5 * np.sinc(half / math.pi)) * vector
    return _from_half_angle(q, math.cos(half))


def log(rotation: Matrix3) -> Vector3:
    """Return the rotation vector (3,) of ``rotation``, with length in [0, pi] [rad].

    Notes
    -----
    At exactly pi the axis is defined up to its sign; its largest component is then positive.

    Raises
    ------
    ShapeError, ParameterError
        If it is not a (3, 3) array of finite numbers.
    """
    q = to_quaternion_xyzw(rotation)
    sine = float(np.linalg.norm(q[:3]))
    if sine == 0.0:
        return np.zeros(3)
    if math.isnan(sine):
        as_finite("rotation", rotation, (3, 3), "a rotation matrix")
    angle = 2.0 * math.atan2(sine, float(q[3]))
    return np.asarray((angle / sine) * q[:3])


def angle_between(first: Matrix3, second: Matrix3) -> float:
    """Return the angle in [0, pi] [rad] of the rotation from ``first`` to ``second``.

    NaN if either is unknown. Raises ShapeError if one is not a (3, 3) array.
    """
    relative = as_shaped("first", first, (3, 3)).T @ as_shaped("second", second, (3, 3))
    sine = float(np.linalg.norm(vee(relative)))
    return math.atan2(sine, 0.5 * (float(np.trace(relative)) - 1.0))


def vector_angle(first: Array, second: Array) -> Array:
    """Return the angle in [0, pi] [rad] between vectors (..., 3), as (...), whatever their length.

    atan2 of sine and cosine keeps full precision near 0 and pi, unlike the arc cosine. NaN where a
    vector is not known, 0 where one of them has no length.
    """
    sine = np.linalg.norm(np.cross(first, second), axis=-1)
    is_one = np.ndim(second) == 1
    cosine = first @ second if is_one else np.sum(np.multiply(first, second), axis=-1)
    return np.asarray(np.arctan2(sine, cosine))


def angles_between(first: Array, second: Array) -> Array:
    """Return `angle_between` for stacks (n, 3, 3) of rotations, as (n,) [rad].

    One of them may be a single rotation (3, 3), used for all. Raises ShapeError for other shapes.
    """
    first, second = as_stack("first", first), as_stack("second", second)
    try:
        first, second = np.broadcast_arrays(first, second)
        relative = np.einsum("nji,njk->nik", first, second)
    except ValueError:
        raise ShapeError(
            f"first, second: received arrays of shapes {first.shape} and {second.shape}; required "
            "(n, 3, 3) for both, or one rotation (3, 3); give as many of each"
        ) from None
    antisymmetric = 0.5 * (relative - relative.transpose(0, 2, 1))
    sine = np.sqrt(0.5 * np.einsum("nij,nij->n", antisymmetric, antisymmetric))
    return np.asarray(np.arctan2(sine, 0.5 * (np.trace(relative, axis1=1, axis2=2) - 1.0)))


# --- quaternions (message edges only) ------------------------------------------------------


def to_quaternion_xyzw(rotation: Matrix3) -> Array:
    """Return the unit quaternion (4,) x, y, z, w of ``rotation``, w >= 0.

    The largest of the four squared components is found first, to avoid division by a small number
    (Shepperd's method). NaN if the rotation is unknown. Raises ShapeError if it is not a (3, 3)
    array.
    """
    r = as_shaped("rotation", rotation, (3, 3)).tolist()  # single numbers of a list come sooner
    trace = r[0][0] + r[1][1] + r[2][2]
    squares = [1.0 + 2.0 * r[i][i] - trace for i in range(3)] + [1.0 + trace]
    largest = squares.index(max(squares))
    if largest == 3:
        raw = [r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1], squares[3]]
    else:
        i, j, k = largest, (largest + 1) % 3, (largest + 2) % 3
        raw = [0.0] * 4
        raw[i] = squares[i]
        raw[j] = r[i][j] + r[j][i]
        raw[k] = r[i][k] + r[k][i]
        raw[3] = r[k][j] - r[j][k]
    q = np.array(raw)
    q /= math.sqrt(q @ q)
    return np.asarray(-q if q[3] < 0.0 else q)


def from_quaternion_xyzw(quaternion: Array) -> Matrix3:
    """Return the rotation (3, 3) of a quaternion (4,) x, y, z, w, which is normalized first.

    Raises
    ------
    ShapeError, ParameterError
        If it is not four finite numbers of nonzero norm.
    """
    q = as_shaped("quaternion", quaternion, (4,), "give x, y, z, w")
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
    tolerance = as_limit("tolerance", tolerance)
    try:
        m = as_finite("matrix", matrix, (3, 3), "a rotation matrix")
    except (ShapeError, ParameterError):
        return False
    return bool(np.linalg.norm(m.T @ m - np.eye(3)) <= tolerance and np.linalg.det(m) > 0.0)


def orthonormalize(matrix: Matrix3) -> Matrix3:
    """Return the rotation (3, 3) nearest to ``matrix`` in the Frobenius norm.

    Raises ShapeError or ParameterError if it is not a (3, 3) array of finite numbers.
    """
    u, _, vt = np.linalg.svd(as_finite("matrix", matrix, (3, 3), "a 3x3 matrix"))
    u[:, -1] *= np.sign(np.linalg.det(u @ vt))
    return np.asarray(u @ vt)


def _from_half_angle(q: Vector3, w: float) -> Matrix3:
    q_hat = _hat(q)
    return np.asarray(np.eye(3) + 2.0 * w * q_hat + 2.0 * (q_hat @ q_hat))
