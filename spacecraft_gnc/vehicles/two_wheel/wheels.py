"""Requirements on axes and inertias of reaction wheels, without kernels."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.arguments import as_limit, as_real
from spacecraft_gnc.arrays import as_finite, as_float, listed
from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.types import Array, ArrayLike, Matrix3, read_only

_SPANS: Final = 1e-3
"""Least singular value of the unit axes that counts as a direction: two axes 0.08 deg apart."""

_SPAN: Final = {
    2: ("else not every attitude can be reached", "add a wheel about another axis"),
    3: (
        "else no torque about some axis can be had",
        "add a wheel, or use a method for two wheels",
    ),
}


def as_axes(value: ArrayLike) -> Array:
    """Return unit axes (3, m), read-only."""
    array = as_float("wheel_axes", value, "a 3 x m matrix")
    if array.ndim != 2 or array.shape[0] != 3 or array.shape[1] < 1:
        raise ShapeError(
            f"wheel_axes: received an array of shape {array.shape}; required (3, m), one column "
            "for each wheel; check the row order"
        )
    array = as_finite("wheel_axes", array, array.shape, "a 3 x m matrix")
    lengths = np.linalg.norm(array, axis=0)
    for i in np.flatnonzero(lengths < 1e-12):
        raise ParameterError(
            f"wheel_axes: received a column {i} of zeros; required the spin axis of each wheel; "
            "remove the column"
        )
    return read_only(array / lengths)


def as_axial(value: ArrayLike, n_wheels: int) -> Array:
    """Return positive axial inertias (m,), read-only."""
    axial = as_finite("wheel_inertias", value, (n_wheels,), f"{n_wheels} numbers [kg m^2]")
    if axial.min() <= 0.0:
        raise ParameterError(
            f"wheel_inertias: received {listed(axial)}; required positive numbers [kg m^2]; give "
            "each wheel's inertia about its spin axis"
        )
    return axial


def as_friction(name: str, value: ArrayLike, n_wheels: int) -> Array:
    """Return the friction of each wheel (m,), or (0,) where there is none, read-only."""
    if np.size(value) == 0:
        return read_only(np.empty(0))
    friction = as_finite(name, value, (n_wheels,), f"{n_wheels} numbers, or none")
    if friction.min() < 0.0:
        raise ParameterError(
            f"{name}: received {listed(friction)}; required numbers >= 0; give 0 for a wheel that "
            "turns freely"
        )
    return friction


def as_loss(share: object, friction: object) -> tuple[float, float]:
    """Return what is left of a command, and what brakes [N m], once a wheel is lost."""
    remedy = "give 0 for a motor that is dead"
    return (
        as_real("lost_share", share, lambda x: 0.0 <= x <= 1.0, "a share of 0 to 1", remedy),
        as_limit("lost_friction", friction),
    )


def decelerations(viscous: Array, coulomb: Array, axial: Array) -> Array:
    """Return (2, m) c / Js [1/s] and tau / Js [rad/s^2] by friction; (2, 0) where there is none."""
    if not (viscous.any() or coulomb.any()):
        return read_only(np.empty((2, 0)))
    parts = [part if part.size else np.zeros(axial.size) for part in (viscous, coulomb)]
    return read_only(np.array(parts) / axial)


def require_bus(inertia: Matrix3, axes: Array, axial: Array) -> None:
    """Raise ParameterError if the wheels have more axial inertia than all has together."""
    least = float(np.linalg.eigvalsh(inertia - (axes * axial) @ axes.T)[0])
    if least <= 0.0:
        raise ParameterError(
            f"wheel_inertias: received {listed(axial)} kg m^2, which leaves the bus a moment of "
            f"{least:.6g} kg m^2; required a positive one; `inertia` is that of bus and locked "
            "wheels together"
        )


def span_of(axes: Array) -> int:
    """Return how many dimensions unit axes (3, m) span."""
    return int(np.linalg.matrix_rank(axes, tol=_SPANS)) if axes.size else 0


def require_span(axes: Array, least: int = 3) -> None:
    """Raise ParameterError if unit axes (3, m) span fewer dimensions than ``least``, 2 or 3."""
    rank = span_of(axes)
    if rank < least:
        why, remedy = _SPAN[least]
        raise ParameterError(
            f"wheel_axes: received {axes.shape[1]} healthy wheel(s) whose axes span {rank} "
            f"dimension(s) (axes less than some 0.1 deg apart count as one); required {least}, "
            f"{why}; {remedy}"
        )


def read_only_mask(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return a mask (m,), which nothing may change any more."""
    mask.setflags(write=False)
    return mask
