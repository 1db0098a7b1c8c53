"""Numbers that describe a parameter of any form: components, norms, angles, principal moments."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np

from spacecraft_gnc.drawing.representations import quaternions_xyzw
from spacecraft_gnc.types import Array

_LONGEST: Final = 12  # numbers of a vector whose components are told apart
_AXES: Final = ("x", "y", "z")
_MOMENTS: Final = ("least", "middle", "greatest")
_LOOKED_AT: Final = 1000  # runs that tell a rotation from another matrix
_BLOCK: Final = 65536  # matrices whose eigenvalues are found together
_SAME: Final = 1e-6


class Feature(NamedTuple):
    """A number of each run that a parameter gives.

    Attributes
    ----------
    name
        Parameter, and which of its numbers it is.
    values
        (n,), NaN where a run has none.
    """

    name: str
    values: Array


def features(name: str, values: Array) -> Iterator[Feature]:
    """Yield what describes the (n,) or (n, m) values of a parameter."""
    if values.ndim == 1:
        yield Feature(name, values)
    elif values.shape[1] == 1:
        yield Feature(name, values[:, 0])
    elif values.shape[1] == 3 and name.endswith("rotation_vector"):
        yield Feature(f"{name}: angle [deg]", np.degrees(np.linalg.norm(values, axis=1)))
        yield from _components(name, values)
    elif values.shape[1] == 9 and _are_rotations(values):
        yield from _rotation(name, values)
    elif values.shape[1] == 9 and _are_symmetric(values):
        yield from _moments(name, values)
    elif values.shape[1] == 4 and _are_unit(values):
        yield from _quaternion(name, values)
    else:
        yield Feature(f"{name}: norm", np.linalg.norm(values, axis=1))
        yield from _components(name, values)


def _components(name: str, values: Array) -> Iterator[Feature]:
    width = values.shape[1]
    if width <= _LONGEST:
        marks = {3: _AXES, 4: (*_AXES, "w")}.get(width, range(1, width + 1))
        for i, mark in enumerate(marks):
            yield Feature(f"{name}: {mark}", values[:, i])


def _rotation(name: str, matrices: Array) -> Iterator[Feature]:
    xyzw = quaternions_xyzw(matrices.reshape(-1, 3, 3))
    xyzw *= np.where(xyzw[:, 3:] < 0.0, -1.0, 1.0)  # the rotation of at most half a turn
    sine = np.linalg.norm(xyzw[:, :3], axis=1)
    angle = 2.0 * np.arctan2(sine, xyzw[:, 3])
    yield Feature(f"{name}: angle [deg]", np.degrees(angle))
    factor = np.where(sine > 0.0, angle / np.where(sine > 0.0, sine, 1.0), 2.0)
    for i, axis in enumerate(_AXES):
        yield Feature(f"{name}: rotation vector {axis}", factor * xyzw[:, i])


def _moments(name: str, matrices: Array) -> Iterator[Feature]:
    known = np.isfinite(matrices).all(axis=1)
    moments = np.full((len(matrices), 3), np.nan)
    for rows in np.array_split(np.flatnonzero(known), len(matrices) // _BLOCK + 1):
        moments[rows] = np.linalg.eigvalsh(matrices[rows].reshape(-1, 3, 3))
    for i, which in enumerate(_MOMENTS):
        yield Feature(f"{name}: {which} principal value", moments[:, i])


def _quaternion(name: str, xyzw: Array) -> Iterator[Feature]:
    sine = np.linalg.norm(xyzw[:, :3], axis=1)
    yield Feature(f"{name}: angle [deg]", np.degrees(2.0 * np.arctan2(sine, np.abs(xyzw[:, 3]))))
    yield from _components(name, xyzw)


def _first_known(values: Array) -> Array:
    return values[np.isfinite(values).all(axis=1)][:_LOOKED_AT]


def _are_rotations(values: Array) -> bool:
    found = _first_known(values).reshape(-1, 3, 3)
    return np.allclose(found @ found.transpose(0, 2, 1), np.eye(3), rtol=0.0, atol=_SAME)


def _are_symmetric(values: Array) -> bool:
    found = _first_known(values).reshape(-1, 3, 3)
    return np.allclose(found, found.transpose(0, 2, 1), rtol=_SAME, atol=0.0)


def _are_unit(values: Array) -> bool:
    return np.allclose(np.linalg.norm(_first_known(values), axis=1), 1.0, rtol=0.0, atol=_SAME)
