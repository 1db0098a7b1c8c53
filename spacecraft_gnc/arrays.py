"""Checks of arrays: finite numbers of the required shape."""

from __future__ import annotations

from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.arguments import shown
from spacecraft_gnc.errors import ParameterError, ShapeError

Array: TypeAlias = NDArray[np.float64]
FLOAT64: Final = np.dtype(np.float64)
_COUNT: Final = "check the number of entries"
_LISTED: Final = 9  # numbers of an array that a message shows


def as_shaped(
    name: str,
    value: object,
    shape: tuple[int, ...],
    remedy: str = _COUNT,
) -> Array:
    """Return ``value`` as a float64 array of a shape; NaN and infinity pass.

    Raises
    ------
    ShapeError
        If it has another shape, or holds non-numeric values.
    """
    if type(value) is np.ndarray and value.dtype is FLOAT64 and value.shape == shape:
        return value
    required = f"an array of shape {shape}"
    array = as_float(name, value, required)
    if array.shape != shape:
        raise _wrong_shape(name, array, required, remedy)
    return array


def as_stack(name: str, value: object) -> Array:
    """Return matrices (..., 3, 3) as a float64 array; NaN and infinity pass.

    Raises
    ------
    ShapeError
        If it has another shape, or holds non-numeric values.
    """
    array = as_float(name, value, "an array of shape (..., 3, 3)")
    if array.shape[-2:] != (3, 3):
        raise _wrong_shape(name, array, "(..., 3, 3)", "stack one matrix in each row")
    return array


def as_rows(name: str, value: object, columns: int) -> Array:
    """Return rows (n, columns), or one row, as a new float64 array (n, columns); NaN passes.

    Raises
    ------
    ShapeError
        If it has another shape, or holds non-numeric values.
    """
    array = np.atleast_2d(as_float(name, value, f"rows of {columns} numbers"))
    if array.ndim != 2 or array.shape[1] != columns:
        raise _wrong_shape(name, array, f"(n, {columns})", "give one row for each step")
    return array


def as_finite(name: str, value: object, shape: tuple[int, ...], required: str) -> Array:
    """Return ``value`` as a read-only float64 array of a shape; ``required`` describes the content.

    Raises
    ------
    ShapeError
        If it has another shape, or holds non-numeric values.
    ParameterError
        If a number is NaN or infinite.
    """
    array = as_float(name, value, required)
    if array.shape != shape:
        raise _wrong_shape(name, array, required, _COUNT)
    if not np.isfinite(array).all():
        raise ParameterError(
            f"{name}: received {listed(array.ravel())}; required finite numbers; "
            "remove NaN and infinity"
        )
    array = np.ascontiguousarray(array)
    array.setflags(write=False)
    return array


def _wrong_shape(name: str, array: Array, required: str, remedy: str) -> ShapeError:
    return ShapeError(
        f"{name}: received an array of shape {array.shape}; required {required}; {remedy}"
    )


def listed(values: NDArray[np.floating[Any]]) -> str:
    """Return numbers as shown in a message; of many, only the first ones."""
    texts = [f"{value:.6g}" for value in values[:_LISTED]]
    return "[" + ", ".join([*texts, "..."] if len(values) > _LISTED else texts) + "]"


def as_float(name: str, value: object, required: str) -> Array:
    """Return ``value`` as a new float64 array of any shape; NaN and infinity pass.

    Raises
    ------
    ShapeError
        If it holds non-numeric values, such as a bool or a text, or rows of different lengths.
    """
    try:
        array = np.asarray(value)
    except (TypeError, ValueError):  # rows of different lengths
        array = np.empty(0, dtype=object)
    if array.dtype.kind not in "fiu" or _holds_bool(value):
        raise ShapeError(
            f"{name}: received {shown(value)}; required {required}; give plain numbers"
        )
    return np.array(array, dtype=np.float64)


def _holds_bool(value: object) -> bool:
    """Whether a nested list holds a bool, which NumPy would accept as a number."""
    if isinstance(value, (list, tuple)):
        return any(_holds_bool(item) for item in value)
    return isinstance(value, (bool, np.bool_))
