"""References whose periodic steady state keeps every constraint with a margin.

The set V = {v : (C_k S_k + D_k) v <= c_k - (1 - share) |c_k| for every k}. If V is empty, so is
every O_infinity,k, and the other way round: the steady state of a v in V belongs to all of them.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors.periodic.problem import PeriodicConstraints, PeriodicLoop
from spacecraft_gnc.governors.periodic.redundancy import needed_rows
from spacecraft_gnc.types import Array

_WIDEST: Final = 1.0  # largest ball looked for, in the units of the reference
_NARROWEST: Final = 1e-9  # radius of a ball in a set that is taken to have an interior
_NO_EFFECT: Final = 1e-12  # of a row, relative to the coefficients that it is computed from


class EmptySetError(ParameterError):
    """No reference keeps every constraint in steady state.

    Attributes
    ----------
    conflict : tuple of str
        Names of constraints that cannot be kept together.
    """

    def __init__(self, message: str, conflict: tuple[str, ...]) -> None:
        super().__init__(message)
        self.conflict = conflict

    def __reduce__(self) -> tuple[type[EmptySetError], tuple[str, tuple[str, ...]]]:
        return type(self), (str(self), self.conflict)


class SteadyReferences(NamedTuple):
    """Rows of V that are not redundant, and a point inside."""

    rows: Array
    """(r, q)"""
    bounds: Array
    """(r,)"""
    constraint: NDArray[np.int64]
    """(r,) index of the constraint."""
    inside: Array
    """(q,) center of the largest ball in V, of radius 1 at most."""


def steady_references(
    loop: PeriodicLoop, constraints: PeriodicConstraints, share: float, tolerance: float
) -> SteadyReferences:
    """Return the set V.

    Raises
    ------
    EmptySetError
        If it is empty, or has no interior.
    """
    steady = loop.steady_maps()
    through = constraints.state_rows @ steady
    rows = through + constraints.reference_rows
    size = np.abs(constraints.state_rows) @ np.abs(steady) + np.abs(constraints.reference_rows)
    rows[np.abs(rows) <= _NO_EFFECT * size] = 0.0
    applies = np.isfinite(constraints.bounds)
    constraint, rows, bounds = np.nonzero(applies)[1], rows[applies], constraints.bounds[applies]
    bounds = bounds - (1.0 - share) * np.abs(bounds)
    idle: NDArray[np.bool_] = ~np.any(rows, axis=1)
    _require_kept(bounds, idle, constraint, constraints.names)
    rows, bounds, constraint = rows[~idle], bounds[~idle], constraint[~idle]
    if not len(rows):
        nothing = np.empty(0, dtype=np.int64)
        q = loop.n_references
        return SteadyReferences(np.empty((0, q)), bounds, nothing, np.zeros(q))
    inside = _center(rows, bounds, [constraints.names[i] for i in constraint], share)
    kept = needed_rows(rows / (bounds - rows @ inside)[:, None], tolerance).indices
    return SteadyReferences(rows[kept], bounds[kept], constraint[kept], inside)


def _require_kept(
    bounds: Array, idle: NDArray[np.bool_], constraint: NDArray[np.int64], names: tuple[str, ...]
) -> None:
    """Refuse rows that no reference changes in steady state and that have no room there."""
    broken = sorted({names[i] for i in constraint[idle & ~(bounds > 0.0)]})
    if broken:
        raise EmptySetError(
            f"O_infinity: received constraints {_shown(broken)}, which no reference influences in "
            "steady state, with a bound that leaves no room there; required a positive bound; "
            "widen it",
            tuple(broken),
        )


def _center(rows: Array, bounds: Array, names: list[str], share: float) -> Array:
    """Return the center of the largest ball in {v : rows v <= bounds}."""
    from scipy.optimize import linprog  # loaded where it is needed

    lengths = np.linalg.norm(rows, axis=1)
    q = rows.shape[1]
    found = linprog(
        np.append(np.zeros(q), -1.0),
        A_ub=np.column_stack([rows / lengths[:, None], np.ones(len(rows))]),
        b_ub=bounds / lengths,
        bounds=[(None, None)] * q + [(None, _WIDEST)],
        method="highs",
    )
    if found.status != 0:
        raise ParameterError(
            f"O_infinity: received rows for which HiGHS ends with {found.message!r}; required "
            "rows of comparable size; scale states, references and rows"
        )
    radius = float(found.x[-1])
    if radius < _NARROWEST:
        pressing = np.flatnonzero(found.ineqlin.marginals < -1e-9)
        conflict = sorted({names[i] for i in pressing})
        raise EmptySetError(
            f"O_infinity: received constraints {_shown(conflict)}, which no constant reference "
            f"keeps together in steady state at {share:g} of their bounds (the best one misses "
            f"by {-radius:.3g} in the units of the reference); required a set with an interior; "
            "widen a bound, or change the loop",
            tuple(conflict),
        )
    return np.asarray(found.x[:q])


def _shown(names: list[str]) -> str:
    return ", ".join(repr(name) for name in names)
