"""Maximal output admissible sets O_infinity,k of a periodic loop, computed off-line.

O_k holds the pairs (x, v) from which, with v held, every constraint is kept from step k on. One
backward step leads to it from the next one, O_k = {C_k x + D_k v <= c_k} and {(A_k x + B_k v, v) in
O_{k+1}}, and redundant rows are removed after each. The recursion starts from the steady-state
rows, tightened, and goes round the period until a set comes out as it was one period before: from
then on it repeats, so that the sets are invariant. docs/periodic_governor.md has theory and
figures. Source: report of AFRL, section 3.2.2; Gilbert and Tan, IEEE TAC 36(9), 1991.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from spacecraft_gnc.arguments import as_count, as_real, require_kind
from spacecraft_gnc.arrays import as_shaped
from spacecraft_gnc.governors.periodic.problem import PeriodicConstraints, PeriodicLoop
from spacecraft_gnc.governors.periodic.redundancy import farthest, is_implied, needed_rows
from spacecraft_gnc.governors.periodic.steady import (
    EmptySetError,
    SteadyReferences,
    steady_references,
)
from spacecraft_gnc.types import Array, read_only

__all__ = ["AdmissibleSet", "AdmissibleSets", "EmptySetError", "SetOptions", "admissible_sets"]

STEADY: Final = -1
"""``ahead`` of a steady-state row."""

Indices = NDArray[np.int64]
Progress = Callable[[int, int, int], None]
"""Called with (backward steps done, most backward steps, rows of the set just found)."""


@dataclass(frozen=True, slots=True)
class SetOptions:
    """Options of `admissible_sets`.

    Attributes
    ----------
    steady_share : float
        Share of each bound that steady states may use; below 1, so that the sets are finitely
        determined. What is kept back is (1 - share) |bound|.
    most_steps : int
        Largest number of steps ahead up to which rows are computed.
    tolerance : float
        Share of the room at a steady state inside the set by which a removed row may be exceeded.
    """

    steady_share: float = 0.99
    most_steps: int = 1000
    tolerance: float = 1e-9

    def __post_init__(self) -> None:
        between = "a number between 0 and 1, both excluded"
        as_real("steady_share", self.steady_share, lambda x: 0.0 < x < 1.0, between, "give 0.99")
        as_real("tolerance", self.tolerance, lambda x: 1e-12 <= x <= 1e-3, "1e-12 to 1e-3", "1e-9")
        as_count("most_steps", self.most_steps)


@dataclass(frozen=True, slots=True, eq=False)
class AdmissibleSet:
    """O_k = {(x, v) : state_rows x + reference_rows v <= bounds}.

    Attributes
    ----------
    state_rows : (r, n) array
    reference_rows : (r, q) array
    bounds : (r,) array
    constraint : (r,) int array
        Which constraint a row is of.
    ahead : (r,) int array
        In how many steps the row has that constraint kept; -1 in steady state.
    """

    state_rows: Array
    reference_rows: Array
    bounds: Array
    constraint: Indices
    ahead: Indices

    def slacks(self, state: Array, reference: Array) -> Array:
        """Return the slack (r,) of each row in its own unit; negative where it is broken."""
        return np.asarray(self.bounds - self.state_rows @ state - self.reference_rows @ reference)


def _columns(rows: AdmissibleSet) -> tuple[Array, Array, Array, Indices, Indices]:
    return rows.state_rows, rows.reference_rows, rows.bounds, rows.constraint, rows.ahead


def _taken(rows: AdmissibleSet, which: Indices) -> AdmissibleSet:
    return AdmissibleSet(*(read_only(x[which]) for x in _columns(rows)))


@dataclass(frozen=True, slots=True, eq=False)
class AdmissibleSets:
    """The sets O_infinity,k of one period.

    Attributes
    ----------
    sets : tuple of AdmissibleSet, (p,)
    names : tuple of str, (m,)
        Names of the constraints.
    inside : (p, n + q) array
        A steady state and its reference inside each set.
    determined : bool
        Whether the recursion closed: the sets are invariant and hold all rows of O_infinity.
    steps : int
        Backward steps taken; rows at least ``steps - p`` steps ahead are in the sets.
    excess : float
        Certificate where not determined: share of its room at ``inside`` by which a row further
        ahead is exceeded at most; infinite if no bound is known. 0 where determined.
    """

    sets: tuple[AdmissibleSet, ...]
    names: tuple[str, ...]
    inside: Array
    determined: bool
    steps: int
    excess: float

    @property
    def period(self) -> int:
        """Number of steps of a period."""
        return len(self.sets)

    @property
    def horizon(self) -> int:
        """Largest number of steps ahead of a row."""
        return max(int(o.ahead.max(initial=STEADY)) for o in self.sets)

    def at(self, k: int) -> AdmissibleSet:
        """Return the set of step k, of any period."""
        return self.sets[k % self.period]

    def contains(self, k: int, state: object, reference: object, tolerance: float = 0.0) -> bool:
        """Tell whether (state, reference) belongs to the set of step k, to a tolerance."""
        o = self.at(k)
        x = as_shaped("state", state, (o.state_rows.shape[1],))
        v = as_shaped("reference", reference, (o.reference_rows.shape[1],))
        return bool((o.slacks(x, v) >= -tolerance).all())


def admissible_sets(
    loop: PeriodicLoop,
    constraints: PeriodicConstraints,
    options: SetOptions | None = None,
    progress: Progress | None = None,
) -> AdmissibleSets:
    """Return the sets O_infinity,k, k = 0..p-1, without redundant rows.

    Parameters
    ----------
    loop : PeriodicLoop
    constraints : PeriodicConstraints
    options : SetOptions, optional
    progress : callable, optional
        Called after each backward step with the steps done, the most there can be, and the number
        of rows of the set just found.

    Raises
    ------
    EmptySetError
        If the sets are empty, with the constraints that cannot be kept together.
    ShapeError
        If loop and constraints do not fit.
    """
    loop = require_kind("loop", loop, PeriodicLoop)
    constraints = require_kind("constraints", constraints, PeriodicConstraints)
    constraints.require_fit(loop)
    options = SetOptions() if options is None else options
    steady = steady_references(loop, constraints, options.steady_share, options.tolerance)
    recursion = _Recursion(loop, constraints, steady, options.tolerance)
    most = loop.period + options.most_steps
    found: dict[int, AdmissibleSet] = {}
    determined, excess = False, float("inf")
    for count, k, rows in recursion:
        if progress is not None:
            progress(count, most, len(rows.bounds))
        before = found.get(k)
        found[k] = rows
        if before is not None and recursion.is_closed(k, before, rows):
            found[k], determined, excess = before, True, 0.0
        elif before is not None and count == most:
            excess = recursion.excess(k, before, rows)
        if determined or count == most:
            break
    sets = tuple(found[k] for k in range(loop.period))
    return AdmissibleSets(sets, constraints.names, recursion.inside, determined, count, excess)


class _Recursion:
    """Backward steps round the period, without end."""

    def __init__(
        self,
        loop: PeriodicLoop,
        constraints: PeriodicConstraints,
        steady: SteadyReferences,
        tolerance: float,
    ) -> None:
        self._loop, self._constraints, self._tolerance = loop, constraints, tolerance
        self._steady = AdmissibleSet(
            np.zeros((len(steady.bounds), loop.n_states)),
            steady.rows,
            steady.bounds,
            steady.constraint,
            np.full(len(steady.bounds), STEADY),
        )
        states = loop.steady_maps() @ steady.inside
        self.inside = read_only(np.hstack([states, np.tile(steady.inside, (loop.period, 1))]))

    def __iter__(self) -> Iterator[tuple[int, int, AdmissibleSet]]:
        """Yield (number of the backward step, k, set of step k)."""
        rows = self._steady
        for count in itertools.count(1):
            k = -count % self._loop.period
            rows = self._before(k, rows)
            rows = _taken(rows, needed_rows(_polar(rows, self.inside[k]), self._tolerance))
            yield count, k, rows

    def is_closed(self, k: int, before: AdmissibleSet, rows: AdmissibleSet) -> bool:
        """Tell whether the set of one period before already keeps every row of the new one."""
        polar = _polar(before, self.inside[k])
        return all(is_implied(row, polar, self._tolerance) for row in self._new(k, before, rows))

    def excess(self, k: int, before: AdmissibleSet, rows: AdmissibleSet) -> float:
        """Return by how much the new rows can be exceeded in the set of one period before."""
        polar = _polar(before, self.inside[k])
        return max(farthest(row, polar) - 1.0 for row in self._new(k, before, rows))

    def _new(self, k: int, before: AdmissibleSet, rows: AdmissibleSet) -> Array:
        """Return the polar rows that were not there before, those furthest ahead first."""
        old, new = (_polar(x, self.inside[k]) for x in (before, rows))
        size = np.abs(new).max(axis=1, initial=0.0)
        apart = cKDTree(old).query(new, p=np.inf)[0]
        fresh = np.flatnonzero(apart > 1e-3 * self._tolerance * size)
        return np.asarray(new[fresh[np.argsort(-rows.ahead[fresh], kind="stable")]])

    def _before(self, k: int, later: AdmissibleSet) -> AdmissibleSet:
        """Return the steady-state rows, those of step k, and those of step k + 1 led back."""
        a, b, c = self._loop.state_map[k], self._loop.reference_map[k], self._constraints
        now = np.flatnonzero(np.isfinite(c.bounds[k]))
        later = _taken(later, np.flatnonzero(later.ahead != STEADY))
        present = AdmissibleSet(
            c.state_rows[k, now], c.reference_rows[k, now], c.bounds[k, now], now, 0 * now
        )
        led_back = AdmissibleSet(
            later.state_rows @ a,
            later.state_rows @ b + later.reference_rows,
            later.bounds,
            later.constraint,
            later.ahead + 1,
        )
        parts = (_columns(x) for x in (self._steady, present, led_back))
        return AdmissibleSet(*(np.concatenate(x) for x in zip(*parts, strict=True)))


def _polar(rows: AdmissibleSet, inside: Array) -> Array:
    """Return the rows (r, n + q) about a point inside, each divided by its room there."""
    stacked = np.hstack([rows.state_rows, rows.reference_rows])
    return np.asarray(stacked / (rows.bounds - stacked @ inside)[:, None])
