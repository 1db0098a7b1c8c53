"""Removal of redundant rows from polyhedra that contain the origin.

A polyhedron {z : a_j . z <= 1} is given by its polar rows a_j. Row i is needed if some z goes
beyond it and keeps the others: then the ray through z meets row i first. Rays that are known, or
spread evenly, show this for most of the rows. The rest are decided by Clarkson's method, one small
program for each: is there a z with a_i . z >= 1 + tolerance inside the needed rows found so far?
If there is, the row that the ray through it meets is needed; if there is none, row i is redundant
(Farkas). The program is a feasibility LP, solved as the projection of the origin by a dual
active-set method, which ends with a certificate in either case.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import daqp
import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array

_FREE: Final = 1e30  # no bound, for the solver
_FEASIBLE: Final = 1
_INFEASIBLE: Final = -1
_SPREAD: Final = 512  # rays beside the known ones
_BLOCK: Final = 512  # rays compared with every row at a time, for the sake of memory
_CLEAR: Final = 0.5  # of the tolerance; points that were looked for go just beyond it
_SHARPEST: Final = 1e-12  # relative singular value below which the rows do not span a direction


class NeededRows(NamedTuple):
    """Rows that describe a polyhedron."""

    indices: NDArray[np.int64]
    """(r,) sorted."""
    rays: Array
    """(r, d) points on the polyhedron's border; each shows that its row is needed."""


def needed_rows(polar: Array, tolerance: float, rays: Array | None = None) -> NeededRows:
    """Return the rows that describe the same polyhedron, to a tolerance.

    Parameters
    ----------
    polar : (m, d) array
        Rows a_j of {z : a_j . z <= 1}.
    tolerance : float
        Share of 1 by which a row that is left out may be exceeded.
    rays : (s, d) array, optional
        Rays from the origin that are likely to meet different rows first.

    Notes
    -----
    A row that the solver cannot decide stays: a row too many changes nothing.
    """
    if not polar.any():
        return NeededRows(np.empty(0, dtype=np.int64), np.empty((0, polar.shape[1])))
    turn = _rounding(polar)
    rows = np.ascontiguousarray(polar @ turn)
    spread = np.random.Generator(np.random.Philox(key=0)).standard_normal((_SPREAD, rows.shape[1]))
    if rays is not None:
        spread = np.vstack([np.linalg.lstsq(turn, rays.T, rcond=None)[0].T, spread])
    needed, witness = _first_met(rows, spread, tolerance)
    inside = _Inside(rows, needed)
    for i in np.flatnonzero(~needed & rows.any(axis=1)):
        while not needed[i]:
            beyond = inside.beyond(rows[i], tolerance)
            if beyond is None:
                break
            along = rows @ beyond
            met = int(np.argmax(along))
            met = int(i) if needed[met] else met
            needed[met], witness[met] = True, beyond / along[met]
            inside.add(rows[met])
    found = np.flatnonzero(needed)
    return NeededRows(found, witness[found] @ turn.T)


def is_implied(row: Array, polar: Array, tolerance: float) -> bool:
    """Tell whether row . z <= 1 + tolerance on {z : a_j . z <= 1}; False where undecided."""
    rows = np.vstack([polar, row])
    rows = np.ascontiguousarray(rows @ _rounding(rows))
    among = np.arange(len(rows)) < len(polar)
    return _Inside(rows, among).beyond(rows[-1], tolerance) is None


def farthest(row: Array, polar: Array) -> float:
    """Return the largest row . z on {z : a_j . z <= 1}; infinity where there is none."""
    from scipy.optimize import linprog  # loaded where it is needed

    found = linprog(-row, A_ub=polar, b_ub=np.ones(len(polar)), bounds=(None, None), method="highs")
    return -float(found.fun) if found.status == 0 else np.inf


def _rounding(polar: Array) -> Array:
    """Return the map (d, e), z = map y, to coordinates in which rows point about everywhere.

    Directions that no row sees are left out.
    """
    _, singular, right = np.linalg.svd(polar, full_matrices=False)
    seen = singular > _SHARPEST * singular[0]
    return np.asarray(right[seen].T * (np.sqrt(len(polar)) / singular[seen]))


def _first_met(rows: Array, rays: Array, tolerance: float) -> tuple[NDArray[np.bool_], Array]:
    """Return a mask (m,) of rows that rays meet well before any other, and where (m, d)."""
    needed, witness = np.zeros(len(rows), dtype=bool), np.zeros_like(rows)
    for start in range(0, len(rays), _BLOCK):
        block = rays[start : start + _BLOCK]
        along, each = block @ rows.T, np.arange(len(block))
        met = along.argmax(axis=1)
        farthest = along[each, met]
        along[each, met] = 0.0
        clear = farthest > (1.0 + _CLEAR * tolerance) * along.max(axis=1)
        needed[met[clear]] = True
        witness[met[clear]] = block[clear] / farthest[clear, None]
    return needed, witness


class _Inside:
    """Search of points in a growing polyhedron {y : a_j . y <= 1}."""

    def __init__(self, rows: Array, among: NDArray[np.bool_]) -> None:
        self._count = int(np.count_nonzero(among))
        self._rows = np.empty((len(rows) + 1, rows.shape[1]))
        self._rows[: self._count] = rows[among]
        self._upper, self._lower = np.ones(len(rows) + 1), np.full(len(rows) + 1, -_FREE)
        self._senses = np.zeros(len(rows) + 1, dtype=np.intc)
        self._metric, self._slope = np.eye(rows.shape[1]), np.zeros(rows.shape[1])

    def add(self, row: Array) -> None:
        """Cut the polyhedron by another row."""
        self._rows[self._count] = row
        self._count += 1

    def beyond(self, row: Array, tolerance: float) -> Array | None:
        """Return a point with row . y >= 1 + tolerance; None if there is none."""
        last, end = self._count, self._count + 1
        self._rows[last] = row
        self._upper[last], self._lower[last] = _FREE, 1.0 + tolerance
        self._senses[:end] = 0
        y, _, status, _ = daqp.solve(
            self._metric, self._slope, self._rows[:end], self._upper[:end], self._lower[:end],
            self._senses[:end], primal_tol=0.1 * tolerance,
        )  # fmt: skip
        self._upper[last], self._lower[last] = 1.0, -_FREE
        if status == _INFEASIBLE:
            return None
        return np.asarray(y) if status == _FEASIBLE else row.copy()
