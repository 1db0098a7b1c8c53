"""Requirements on axes and inertias of reaction wheels, without kernels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.arrays import as_finite, as_float, listed
from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.types import Array, ArrayLike, Matrix3, read_only

_SPANS = 1e-6  # least singular value of the unit axes that counts as a direction


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


def require_bus(inertia: Matrix3, axes: Array, axial: Array) -> None:
    """Raise ParameterError if the wheels have more axial inertia than all has together."""
    least = float(np.linalg.eigvalsh(inertia - (axes * axial) @ axes.T)[0])
    if least <= 0.0:
        raise ParameterError(
            f"wheel_inertias: received {listed(axial)} kg m^2, which leaves the bus a moment of "
            f"{least:.6g} kg m^2; required a positive one; `inertia` is that of bus and locked "
            "wheels together"
        )


def require_span(axes: Array) -> None:
    """Raise ParameterError if unit axes (3, m) span fewer than three dimensions."""
    rank = int(np.linalg.matrix_rank(axes, tol=_SPANS)) if axes.size else 0
    if rank < 3:
        raise ParameterError(
            f"wheel_axes: received {axes.shape[1]} healthy wheel(s) whose axes span {rank} "
            "dimension(s); required 3, else no torque about some axis can be had; add a wheel, or "
            "use a method for two wheels"
        )


def read_only_mask(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return a mask (m,), which nothing may change any more."""
    mask.setflags(write=False)
    return mask
