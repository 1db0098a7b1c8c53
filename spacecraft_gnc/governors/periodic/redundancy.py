"""Removal of redundant rows from polyhedra that contain the origin.

A polyhedron {z : a_j . z <= 1} is given by its polar rows a_j. Row i is redundant if a_i . z <= 1
follows from the others. Rays from the origin find most of the rows that are needed: the row that a
ray meets first is one. The rest are decided by Clarkson's method, one small program for each: is
there a z with a_i . z >= 1 + tolerance inside the needed rows found so far? If there is, the ray
through it meets a needed row; if there is none, row i is redundant (Farkas). The program is a
feasibility LP, solved as the projection of the origin by a dual active-set method, which ends with
a certificate in either case.
"""

from __future__ import annotations

from typing import Final

import daqp
import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array

_FREE: Final = 1e30  # no bound, for the solver
_FEASIBLE: Final = 1
_INFEASIBLE: Final = -1
_RAYS: Final = 512
_NEARLY_PARALLEL: Final = 1e-12  # 1 - cos^2 of rows that are compared number by number
_SAME: Final = 1e-3  # of the tolerance, within which numbers count as equal
_SHARPEST: Final = 1e-12  # relative singular value below which the rows do not span a direction


def needed_rows(polar: Array, tolerance: float) -> NDArray[np.int64]:
    """Return the sorted indices of rows that describe the same polyhedron, to a tolerance.

    Parameters
    ----------
    polar : (m, d) array
        Rows a_j of {z : a_j . z <= 1}. Of equal rows the first one stays.
    tolerance : float
        Share of 1 by which a row that is left out may be exceeded.

    Notes
    -----
    A row that the solver cannot decide stays: a row too many changes nothing.
    """
    if not len(polar):
        return np.empty(0, dtype=np.int64)
    rows = _rounded(polar)
    left = _distinct(rows, tolerance)
    rows = rows[left]
    needed = _first_met(rows)
    for i in range(len(rows)):
        while not needed[i]:
            beyond = _point_beyond(rows, needed, i, tolerance)
            if beyond is None:
                break
            met = int(np.argmax(rows @ beyond))
            needed[i if needed[met] else met] = True
    return np.asarray(left[needed])


def is_implied(row: Array, polar: Array, tolerance: float) -> bool:
    """Tell whether row . z <= 1 + tolerance on {z : a_j . z <= 1}; False where undecided."""
    rows = _rounded(np.vstack([polar, row]))
    among = np.arange(len(rows)) < len(polar)
    return _point_beyond(rows, among, len(polar), tolerance) is None


def _rounded(polar: Array) -> Array:
    """Return the rows in coordinates in which they point in all directions about equally.

    Directions that no row sees are left out.
    """
    _, singular, right = np.linalg.svd(polar, full_matrices=False)
    seen = singular > _SHARPEST * singular[0]
    return np.asarray((polar @ right[seen].T) * (np.sqrt(len(polar)) / singular[seen]))


def _distinct(rows: Array, tolerance: float) -> NDArray[np.int64]:
    """Return indices without rows that another row in the same direction implies."""
    squares = np.einsum("ij,ij->i", rows, rows)
    products = rows @ rows.T
    with np.errstate(invalid="ignore", divide="ignore"):
        share = products / squares[None, :]  # a_i is about share a_j
        near = np.abs(1.0 - share * products / squares[:, None]) <= _NEARLY_PARALLEL
    i, j = np.nonzero(near & (share >= 0.0) & (share <= 1.0 + tolerance))
    apart = np.abs(rows[i] - share[i, j, None] * rows[j]).max(axis=1)
    implied = np.zeros_like(near)
    implied[i, j] = apart <= _SAME * tolerance * np.sqrt(squares[i])
    np.fill_diagonal(implied, val=False)
    later = np.tril(np.ones_like(implied), -1)
    implied &= ~implied.T | later  # of two equal rows the later one goes
    return np.flatnonzero(~implied.any(axis=1) & (squares > 0.0))


def _first_met(rows: Array) -> NDArray[np.bool_]:
    """Return a mask (m,) of the rows that rays meet first: along each row, and evenly spread."""
    generator = np.random.Generator(np.random.Philox(key=0))
    rays = np.vstack([rows, generator.standard_normal((_RAYS, rows.shape[1]))])
    along = rows @ rays.T
    met = along.argmax(axis=0)
    needed = np.zeros(len(rows), dtype=bool)
    needed[met[along[met, np.arange(len(rays))] > 0.0]] = True
    return needed


def _point_beyond(rows: Array, among: NDArray[np.bool_], i: int, tolerance: float) -> Array | None:
    """Return a z beyond row i that keeps the rows ``among``; None if there is none."""
    chosen = np.append(np.flatnonzero(among), i)
    upper, lower = np.ones(len(chosen)), np.full(len(chosen), -_FREE)
    upper[-1], lower[-1] = _FREE, 1.0 + tolerance
    d = rows.shape[1]
    z, _, status, _ = daqp.solve(
        np.eye(d), np.zeros(d), rows[chosen], upper, lower,
        np.zeros(len(chosen), dtype=np.intc), primal_tol=0.1 * tolerance,
    )  # fmt: skip
    if status == _INFEASIBLE:
        return None
    return np.asarray(z if status == _FEASIBLE else rows[i])


def farthest(row: Array, polar: Array) -> float:
    """Return the largest row . z on {z : a_j . z <= 1}; infinity where there is none."""
    from scipy.optimize import linprog  # loaded where it is needed

    found = linprog(-row, A_ub=polar, b_ub=np.ones(len(polar)), bounds=(None, None), method="highs")
    return -float(found.fun) if found.status == 0 else np.inf
