"""Array types, values exchanged between the parts, and checks of public arguments."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.arrays import as_finite, as_float, listed
from spacecraft_gnc.errors import ParameterError, ShapeError

Array: TypeAlias = NDArray[np.float64]
Vector3: TypeAlias = NDArray[np.float64]
"""Shape (3,)."""
Matrix3: TypeAlias = NDArray[np.float64]
"""Shape (3, 3)."""
ArrayLike: TypeAlias = Array | Sequence[float] | Sequence[Sequence[float]] | float

ROTATION_TOLERANCE = 1e-6
"""Largest Frobenius norm of R^T R - I accepted as input; allows single-precision sources."""

MOMENTS = (1e-12, 1e15)
"""Smallest and largest principal moment of inertia [kg m^2]: dust grain to small asteroid."""
_PRODUCTS = (
    "off-diagonal entries are negative products of inertia, J_xy = -(integral of x y dm): where a "
    "table gives them without the sign, change it"
)


class State(NamedTuple):
    """State of the spacecraft at the start of control step ``step``."""

    step: int
    attitude: Matrix3
    """(3, 3) rotation, body to inertial."""
    momentum: Vector3
    """(3,) angular momentum, body frame [N m s]."""


class Reference(NamedTuple):
    """Reference to track during one control step."""

    attitude: Matrix3
    """(3, 3) rotation, body to inertial."""
    angular_velocity: Vector3
    """(3,) feed-forward body rate [rad/s]."""
    torque: Vector3
    """(3,) feed-forward body torque [N m]."""


class GovernorDecision(NamedTuple):
    """Reference admitted by the governor, and the reason."""

    reference: Reference
    alpha: float
    """Admitted fraction of the way to the target, or to the next intermediate reference."""
    admissible: bool
    """Whether the prediction under this reference keeps every constraint."""
    margin: float
    """Smallest constraint margin along the prediction, in the unit of that constraint (infinite if
    nothing is predicted)."""
    active_constraint: str
    """Name of the constraint that limited alpha; empty if none did."""
    evaluations: int
    """Predictions made."""
    violation_step: int = -1
    """Predicted step at which that constraint would have been violated under the smallest
    refused alpha, counted from this control step; -1 if nothing was refused."""
    horizon: int = 0
    """Largest number of steps of a prediction; 0 if nothing is predicted."""
    waypoints: int = 0
    """Intermediate references still ahead of the target."""
    report: Any = None
    """What the law says of it beside; None where it has nothing to say."""


class Invariants(NamedTuple):
    """Quantities conserved in free motion, and the orthogonality error of the rotation matrix."""

    kinetic_energy: float
    """[J]"""
    inertial_momentum: Vector3
    """(3,) angular momentum, inertial frame [N m s]."""
    orthogonality_error: float
    """Frobenius norm of R^T R - I."""


def as_vector3(name: str, value: ArrayLike) -> Vector3:
    """Return ``value`` as a read-only float64 array of shape (3,).

    Raises
    ------
    ShapeError
        If it is not three numbers.
    ParameterError
        If a number is NaN or infinite.
    """
    return as_finite(name, value, (3,), "3 numbers")


def as_matrix3(name: str, value: ArrayLike) -> Matrix3:
    """Return ``value`` (3x3, 9 numbers row-major, or a scalar times I) as a read-only (3, 3) array.

    Raises
    ------
    ShapeError
        If it has another shape.
    ParameterError
        If a number is NaN or infinite.
    """
    array = as_float(name, value, "a 3x3 matrix, 9 numbers row-major, or one number")
    if array.ndim == 0:
        array = array * np.eye(3)
    if array.shape == (9,):
        array = array.reshape(3, 3)
    return as_finite(name, array, (3, 3), "a 3x3 matrix, 9 numbers row-major, or one number")


def as_rotation(name: str, value: ArrayLike) -> Matrix3:
    """Return ``value`` as a read-only rotation matrix (3, 3), body to inertial.

    Raises
    ------
    ParameterError
        If R^T R differs from I by more than `ROTATION_TOLERANCE`, or det R < 0.
    """
    rotation = as_matrix3(name, value)
    defect = float(np.linalg.norm(rotation.T @ rotation - np.eye(3)))
    if defect > ROTATION_TOLERANCE or np.linalg.det(rotation) < 0.0:
        raise ParameterError(
            f"{name}: received a matrix with |R^T R - I| = {defect:.3g} and determinant "
            f"{np.linalg.det(rotation):.6g}; required a rotation (defect at most "
            f"{ROTATION_TOLERANCE:g}, determinant 1); orthonormalize it first"
        )
    return rotation


def as_symmetric(name: str, value: ArrayLike) -> Matrix3:
    """Return ``value`` as a read-only symmetric (3, 3) matrix.

    Raises
    ------
    ParameterError
        If it differs from its transpose.
    """
    matrix = as_matrix3(name, value)
    asymmetry = float(np.abs(matrix - matrix.T).max())
    if asymmetry > 1e-12 * float(np.abs(matrix).max()):
        raise ParameterError(
            f"{name}: received a matrix that differs from its transpose by {asymmetry:.3g}; "
            "required a symmetric matrix; mirror the off-diagonal entries"
        )
    return matrix


def as_inertia(name: str, value: ArrayLike) -> Matrix3:
    """Return ``value`` as a read-only inertia matrix (3, 3) [kg m^2], body frame.

    Raises
    ------
    ParameterError
        If it is not symmetric or not positive definite, if its principal moments violate the
        (strict) triangle inequality of a rigid body with volume, or if one of them lies outside
        `MOMENTS`.

    Notes
    -----
    The entries are those of the tensor: J_xy = -(integral of x y dm). Change the sign of a product
    of inertia that a table gives as +(integral of x y dm).
    """
    inertia = as_symmetric(name, value)
    moments = np.linalg.eigvalsh(inertia)
    if moments[0] <= 0.0:
        raise ParameterError(
            f"{name}: received principal moments {listed(moments)}; required a positive definite "
            f"matrix; check the signs and the row order{_on_signs(inertia)}"
        )
    if moments[2] >= moments[0] + moments[1]:
        raise ParameterError(
            f"{name}: received principal moments {listed(moments)}; required each smaller than "
            f"the sum of the other two (triangle inequality); check the largest one"
            f"{_on_signs(inertia)}"
        )
    if moments[0] < MOMENTS[0] or moments[2] > MOMENTS[1]:
        raise ParameterError(
            f"{name}: received principal moments {listed(moments)}; required {MOMENTS[0]:g} to "
            f"{MOMENTS[1]:g} kg m^2, so that double precision holds the products of the dynamics "
            "and of the cost; check the unit"
        )
    return inertia


def _on_signs(inertia: Matrix3) -> str:
    """Return what to know of products of inertia; empty where there are none."""
    return "" if (inertia == np.diag(np.diag(inertia))).all() else f" ({_PRODUCTS})"


def as_semidefinite(name: str, value: ArrayLike) -> Matrix3:
    """Return ``value`` as a read-only symmetric positive semi-definite (3, 3) weight.

    Raises
    ------
    ParameterError
        If it is not symmetric or has a negative eigenvalue.
    """
    weight = as_symmetric(name, value)
    size = max(float(np.abs(weight).max()), 1e-300)
    smallest = float(np.linalg.eigvalsh(weight)[0])
    if smallest < -1e-12 * size:
        raise ParameterError(
            f"{name}: received a matrix with eigenvalue {smallest:.6g}; required a positive "
            "semi-definite weight; use non-negative eigenvalues"
        )
    return weight


def as_actuators(value: ArrayLike | None) -> Array:
    """Return the actuator matrix (3, m) of torque = B u, read-only; the identity for None.

    Raises
    ------
    ShapeError
        If it does not have 3 rows.
    ParameterError
        If a number is NaN or infinite, or an actuator (a column) gives no torque.
    """
    if value is None:
        return read_only(np.eye(3))
    array = as_float("actuators", value, "a 3 x m matrix")
    if array.ndim != 2 or array.shape[0] != 3 or array.shape[1] < 1:
        raise ShapeError(
            f"actuators: received an array of shape {array.shape}; required (3, m), one column of "
            "torque for each actuator; check the row order"
        )
    matrix = as_finite("actuators", array, array.shape, "a 3 x m matrix")
    for i in np.flatnonzero(np.abs(matrix).max(axis=0) == 0.0):
        raise ParameterError(
            f"actuators: received a column {i} of zeros; required a torque from each actuator; "
            "remove the column"
        )
    return matrix


def unit_vector(name: str, value: ArrayLike) -> Vector3:
    """Return ``value`` normalized, as a read-only array of shape (3,).

    Raises
    ------
    ParameterError
        If its length is zero.
    """
    vector = as_vector3(name, value)
    length = float(np.linalg.norm(vector))
    if length < 1e-12:
        raise ParameterError(
            f"{name}: received {listed(vector)}; required a direction of non-zero length; give "
            "the axis, for example [1.0, 0.0, 0.0]"
        )
    return read_only(vector / length)


def read_only(array: Array) -> Array:
    """Mark ``array`` read-only and return it."""
    array.setflags(write=False)
    return array
