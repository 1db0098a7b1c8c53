"""Quadratic program of the governor: the admissible reference nearest to the one wished for.

min 1/2 (v - w)' M (v - w) subject to H v <= b (report of AFRL, (12)-(13), with a weight M). With
M = L L' and y = L' (v - w) it is the projection of the origin onto {y : a_j . y <= b_j - h_j . w},
each row scaled to unit length. Solved by DAQP, a dual active-set method: exact active set and
multipliers, and a certificate where no reference is admissible.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import daqp
import numpy as np
from scipy.linalg import solve_triangular

from spacecraft_gnc.arrays import as_finite, as_float
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.types import Array

OPTIMAL, INFEASIBLE, NOT_SOLVED = 0, 1, 2

_TOLERANCE: Final = 1e-9  # of a row, in the weighted unit of the reference
_MOST_ITERATIONS: Final = 5000
_FREE: Final = 1e30  # no bound, for the solver
_STATUS: Final = {1: OPTIMAL, -1: INFEASIBLE}


class Nearest(NamedTuple):
    """Solution of the program."""

    reference: Array
    """v (q,); NaN where not optimal."""
    multipliers: Array
    """lambda (r,) >= 0 with M (v - w) + H' lambda = 0; NaN where not optimal."""
    status: int
    """OPTIMAL, INFEASIBLE or NOT_SOLVED."""
    iterations: int


class Weight:
    """Weight M of the distance between references.

    Parameters
    ----------
    matrix : (q, q) or (q,) array
        Positive definite, or the diagonal.

    Raises
    ------
    ParameterError
        If it is not symmetric and positive definite.
    """

    def __init__(self, matrix: object) -> None:
        shape = as_float("weight", matrix, "finite numbers").shape
        square = shape * 2 if len(shape) == 1 else (shape[-1:] or (1,)) * 2
        full = as_finite("weight", matrix, shape, "finite numbers")
        full = np.diag(full) if len(shape) == 1 else full
        refusal = ParameterError(
            f"weight: received an array of shape {shape} that is not positive definite; required "
            "positive numbers, or a symmetric positive definite matrix; correct it"
        )
        if full.shape != square or not np.allclose(full, full.T, rtol=1e-12, atol=0.0):
            raise refusal
        try:
            self.root = np.linalg.cholesky(full)
            self.unscale = solve_triangular(self.root, np.eye(len(full)), lower=True)
        except np.linalg.LinAlgError:
            raise refusal from None

    def scaled(self, rows: Array) -> tuple[Array, Array]:
        """Return the rows (r, q) for y, scaled to unit length, and the lengths (r,) they had."""
        rows = rows @ self.unscale.T
        lengths = np.linalg.norm(rows, axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.ascontiguousarray(rows / lengths[:, None]), lengths


def nearest_reference(weight: Weight, wish: Array, rows: Array, bounds: Array) -> Nearest:
    """Return the reference v nearest to ``wish`` (q,) with rows (r, q) v <= bounds (r,).

    Rows must not be zero.
    """
    scaled, lengths = weight.scaled(rows)
    return nearest_of_scaled(weight, wish, scaled, lengths, bounds - rows @ wish)


def nearest_of_scaled(
    weight: Weight, wish: Array, scaled: Array, lengths: Array, rooms: Array
) -> Nearest:
    """Solve for rows of `Weight.scaled`, where ``rooms`` (r,) are bounds - rows @ wish."""
    q, r = len(wish), len(rooms)
    if r == 0 or rooms.min() >= 0.0:  # the wish itself is admissible
        return Nearest(wish.copy(), np.zeros(r), OPTIMAL, 0)
    y, _, flag, info = daqp.solve(
        np.eye(q), np.zeros(q), scaled, rooms / lengths, np.full(r, -_FREE),
        np.zeros(r, dtype=np.intc), primal_tol=_TOLERANCE, iter_limit=_MOST_ITERATIONS,
    )  # fmt: skip
    status = _STATUS.get(flag, NOT_SOLVED)
    if status != OPTIMAL:
        return Nearest(np.full(q, np.nan), np.full(r, np.nan), status, int(info["iterations"]))
    v = wish + y @ weight.unscale
    return Nearest(np.asarray(v), np.asarray(info["lam"]) / lengths, status, info["iterations"])
