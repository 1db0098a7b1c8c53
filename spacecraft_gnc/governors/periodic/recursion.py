"""Maximal output admissible sets O_infinity,k of a periodic loop, computed off-line.

O_k holds the pairs (x, v) from which, with v held, every constraint is kept from step k on. One
backward step leads to it from the next one, O_k = {C_k x + D_k v <= c_k} and {(A_k x + B_k v, v) in
O_{k+1}}, and redundant rows are removed after each. The recursion starts from the steady-state
rows, tightened, and goes round the period until a set comes out as it was one period before: from
then on it repeats, so that the sets are invariant. docs/periodic_governor.md has theory and
figures. Source: report of AFRL, section 3.2.2; Gilbert and Tan, IEEE TAC 36(9), 1991.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.arguments import as_count, as_real, require_kind
from spacecraft_gnc.governors.periodic.problem import PeriodicConstraints, PeriodicLoop
from spacecraft_gnc.governors.periodic.redundancy import farthest, is_implied, needed_rows
from spacecraft_gnc.governors.periodic.sets import (
    STEADY,
    AdmissibleSets,
    Indices,
    Members,
    assembled,
    inside_points,
    led_back,
)
from spacecraft_gnc.governors.periodic.steady import SteadyReferences, steady_references
from spacecraft_gnc.types import Array, read_only

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


class FoundMembers(NamedTuple):
    """What the recursion finds: the members of each set, and how it ended."""

    members: tuple[Members, ...]
    determined: bool
    steps: int
    excess: float

    def sets(
        self, loop: PeriodicLoop, constraints: PeriodicConstraints, steady: SteadyReferences
    ) -> AdmissibleSets:
        """Return the sets with these members."""
        return AdmissibleSets(
            assembled(loop, constraints, steady, self.members),
            constraints.names,
            read_only(inside_points(loop, steady)),
            *self[1:],
        )


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
    return found_members(loop, constraints, steady, options, progress).sets(
        loop, constraints, steady
    )


def found_members(
    loop: PeriodicLoop,
    constraints: PeriodicConstraints,
    steady: SteadyReferences,
    options: SetOptions,
    progress: Progress | None = None,
) -> FoundMembers:
    """Return the members of the sets."""
    recursion = _Recursion(loop, constraints, steady, options.tolerance)
    most = loop.period + options.most_steps
    found: dict[int, _Rows] = {}
    determined, excess = False, float("inf")
    rows = recursion.nothing
    for count in range(1, most + 1):
        k = -count % loop.period
        before = found.get(k)
        rows = recursion.step(k, rows, before)
        if progress is not None:
            progress(count, most, len(rows.bounds))
        found[k] = rows
        if before is not None and recursion.is_closed(k, before, rows):
            found[k], determined, excess = before, True, 0.0
        elif before is not None and count == most:
            excess = recursion.excess(k, before, rows)
        if determined:
            break
    members = tuple(found[k].members() for k in range(loop.period))
    return FoundMembers(members, determined, count, excess)


class _Rows(NamedTuple):
    """Rows on (x, v) in the recursion."""

    stacked: Array
    bounds: Array
    source: Indices
    ahead: Indices
    rays: Array
    """From the point inside, each meeting its row first."""

    def taken(self, which: Indices | NDArray[np.bool_]) -> _Rows:
        """Return some of the rows."""
        return _Rows(
            self.stacked[which],
            self.bounds[which],
            self.source[which],
            self.ahead[which],
            self.rays[which],
        )

    def members(self) -> Members:
        """Return what the rows are of, in order."""
        order = np.lexsort((self.source, self.ahead))
        return Members(self.source[order], self.ahead[order])


class _Recursion:
    """Backward steps round the period."""

    def __init__(
        self,
        loop: PeriodicLoop,
        constraints: PeriodicConstraints,
        steady: SteadyReferences,
        tolerance: float,
    ) -> None:
        self._loop, self._constraints, self._tolerance = loop, constraints, tolerance
        count, n, q = len(steady.bounds), loop.n_states, loop.n_references
        self._steady = _Rows(
            np.hstack([np.zeros((count, n)), steady.rows]),
            steady.bounds,
            np.arange(count),
            np.full(count, STEADY),
            np.empty((count, n + q)),
        )
        self._inside = inside_points(loop, steady)

    @property
    def nothing(self) -> _Rows:
        """No rows: what is known of the step after the last one."""
        return self._steady.taken(np.empty(0, dtype=np.int64))

    def step(self, k: int, later: _Rows, before: _Rows | None) -> _Rows:
        """Return the set of step k from that of step k + 1; ``before``: of one period before."""
        rows = self._before(k, later)
        rays = rows.rays if before is None else np.vstack([rows.rays, before.rays])
        kept = needed_rows(self._polar(k, rows), self._tolerance, rays)
        at = kept.indices
        return _Rows(rows.stacked[at], rows.bounds[at], rows.source[at], rows.ahead[at], kept.rays)

    def is_closed(self, k: int, before: _Rows, rows: _Rows) -> bool:
        """Tell whether the set of one period before already keeps every row of the new one."""
        polar = self._polar(k, before)
        return all(is_implied(row, polar, self._tolerance) for row in self._new(k, before, rows))

    def excess(self, k: int, before: _Rows, rows: _Rows) -> float:
        """Return by how much the new rows can be exceeded in the set of one period before."""
        polar = self._polar(k, before)
        return max(farthest(row, polar) - 1.0 for row in self._new(k, before, rows))

    def _new(self, k: int, before: _Rows, rows: _Rows) -> Array:
        """Return the polar rows that were not there before, those furthest ahead first."""
        old = set(zip(before.source.tolist(), before.ahead.tolist(), strict=True))
        new = zip(rows.source.tolist(), rows.ahead.tolist(), strict=True)
        fresh = np.flatnonzero([row not in old for row in new])
        return self._polar(k, rows)[fresh[np.argsort(-rows.ahead[fresh], kind="stable")]]

    def _before(self, k: int, later: _Rows) -> _Rows:
        """Return the steady-state rows, those of step k, and those of step k + 1 led back."""
        a, b, c = self._loop.state_map[k], self._loop.reference_map[k], self._constraints
        now = np.flatnonzero(np.isfinite(c.bounds[k]))
        present = np.hstack([c.state_rows[k, now], c.reference_rows[k, now]])
        rays = np.vstack([self._led_back_rays(a, b, later.rays), later.rays])
        later = later.taken(later.ahead != STEADY)
        return _Rows(
            np.vstack([self._steady.stacked, present, led_back(later.stacked, a, b)]),
            np.concatenate([self._steady.bounds, c.bounds[k, now], later.bounds]),
            np.concatenate([self._steady.source, now, later.source]),
            np.concatenate([self._steady.ahead, 0 * now, later.ahead + 1]),
            rays,
        )

    @staticmethod
    def _led_back_rays(a: Array, b: Array, rays: Array) -> Array:
        """Return rays (s, n + q) of step k + 1 as rays of step k."""
        n = len(a)
        states = np.linalg.lstsq(a, (rays[:, :n] - rays[:, n:] @ b.T).T, rcond=None)[0].T
        return np.hstack([states, rays[:, n:]])

    def _polar(self, k: int, rows: _Rows) -> Array:
        """Return the rows (r, n + q) about a point inside, each divided by its room there."""
        rooms = rows.bounds - rows.stacked @ self._inside[k]
        return np.asarray(rows.stacked / rooms[:, None])
