"""Pairs of craft, the distances between them, and the angles of communication."""

from __future__ import annotations

from itertools import combinations
from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array

UNDEFINED_DEG: Final = 180.0
"""Angle where one of the two directions is none, as two craft are at one place: the worst."""


def pairs(n: int) -> NDArray[np.int64]:
    """Return the pairs of n craft (m, 2): 01, 02, ..., 12, ..."""
    return np.array(list(combinations(range(n), 2)), dtype=np.int64).reshape(-1, 2)


def relative_positions(position: Array) -> Array:
    """Return the second less the first of each pair (..., m, 3) of positions (..., n, 3)."""
    first, second = pairs(position.shape[-2]).T
    return np.asarray(position[..., second, :] - position[..., first, :])


def separations(position: Array) -> Array:
    """Return the distance (..., m) between the craft of each pair, from positions (..., n, 3)."""
    return np.asarray(np.linalg.norm(relative_positions(position), axis=-1))


def communication_angles_deg(position: Array, commanded: Array) -> Array:
    """Return the angle of each pair (..., m), from where the other craft is to where it belongs.

    In degrees.

    Parameters
    ----------
    position, commanded : (..., n, 3) arrays
        Actual and commanded positions. The report does not define the angle; this is how its
        constraint is read (docs/formation.md).
    """
    actual, wanted = relative_positions(position), relative_positions(commanded)
    cross = np.linalg.norm(np.cross(actual, wanted), axis=-1)
    along = (actual * wanted).sum(axis=-1)
    is_none = (cross == 0.0) & (along == 0.0)
    return np.where(is_none, UNDEFINED_DEG, np.degrees(np.arctan2(cross, along)))
