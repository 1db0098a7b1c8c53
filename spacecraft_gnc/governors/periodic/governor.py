"""Periodic reference governor: the admissible reference nearest to the one wished for, each step.

If (x_k, v) is in O_k, then (x_{k+1}, v) is in O_{k+1}: the last admissible reference stays one, so
that on the modeled loop the program always has a solution. Where a disturbance leaves none, the
last admissible reference is held; the steady state it leads to keeps every constraint.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.arrays import as_finite, as_shaped
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors.periodic import qp
from spacecraft_gnc.governors.periodic.sets import STEADY, AdmissibleSet, AdmissibleSets
from spacecraft_gnc.types import Array

_NO_EFFECT: Final = 1e-9  # share of its room that a unit of (weighted) reference takes from a row
_KEPT: Final = 1e-7  # share of its room by which a row may be missed by rounding
_PRESSING: Final = 1e-9  # of the largest multiplier, at least which one is shown as active

STATUS_NAMES: Final = {
    qp.OPTIMAL: "optimal",
    qp.INFEASIBLE: "infeasible",
    qp.NOT_SOLVED: "not solved",
}


class ActiveRow(NamedTuple):
    """A row that keeps the reference from the one wished for."""

    name: str
    """Name of the constraint."""
    ahead: int
    """In how many steps it would be met; -1 in steady state."""
    multiplier: float
    """Of the program (12)-(13), with the factor 1/2, in 1 / unit of the row."""
    row: int
    """Index in the set of the step."""


@dataclass(frozen=True, slots=True)
class PeriodicDecision:
    """Answer of the governor at one step.

    Attributes
    ----------
    reference : (q,) array
        The nearest admissible reference; where ``held``, the last admissible one.
    held : bool
        Whether the program had no usable solution.
    status : str
        "optimal", "infeasible" or "not solved".
    slack : float
        Smallest slack of a row of O_k, as a share of the row's room at the steady state inside;
        negative where (state, reference) is outside.
    constraint : str
        Name of the constraint with that slack; empty if there is none.
    constraint_ahead : int
        In how many steps it is met; -1 in steady state.
    active : tuple of ActiveRow
        Rows with a multiplier, largest first.
    iterations : int
        Of the solver; 0 where the wish itself is admissible.
    """

    reference: Array
    held: bool
    status: str
    slack: float
    constraint: str
    constraint_ahead: int
    active: tuple[ActiveRow, ...]
    iterations: int


class _Prepared(NamedTuple):
    """A set, with what the program of its step needs of it."""

    rows: AdmissibleSet
    rooms: Array
    """(r,) at the steady state inside."""
    free: NDArray[np.int64]
    """(s,) indices of the rows on which the reference has an effect."""
    references: Array
    """(s, q) their reference rows"""
    scaled: Array
    lengths: Array


class PeriodicGovernor:
    """Reference governor on the sets O_infinity,k.

    Parameters
    ----------
    sets : AdmissibleSets
    weight : (q, q) or (q,) array
        Positive definite weight of the distance between references, or its diagonal.
    reference : (q,) array, optional
        A reference that is admissible at the start, held if the first program has no solution.

    Raises
    ------
    ParameterError
        If the weight is not positive definite.
    ShapeError
        If it does not fit.
    """

    def __init__(
        self, sets: AdmissibleSets, weight: object, reference: object | None = None
    ) -> None:
        self.sets = sets
        self._q = sets.at(0).reference_rows.shape[1]
        self._weight = qp.Weight(weight)
        if len(self._weight.root) != self._q:
            raise ParameterError(
                f"weight: received one of {len(self._weight.root)} references; required "
                f"{self._q}; give one number for each"
            )
        self._last = None if reference is None else self._as_reference("reference", reference)
        self._prepared = [self._prepare(k) for k in range(sets.period)]

    @property
    def reference(self) -> Array | None:
        """The last admissible reference (q,); None before the first step."""
        return self._last

    def reset(self, reference: object | None = None) -> None:
        """Forget the last reference, or replace it by an admissible one."""
        self._last = None if reference is None else self._as_reference("reference", reference)

    def decide(self, k: int, state: object, wish: object) -> PeriodicDecision:
        """Return the admissible reference nearest to ``wish`` (q,) for the state (n,) of step k.

        Raises
        ------
        ParameterError
            If there is none and no last one to hold, with the constraints that cannot be kept; or
            if a number is not finite.
        """
        p = self._prepared[k % self.sets.period]
        n = p.rows.state_rows.shape[1]
        x = as_finite("state", state, (n,), f"{n} finite numbers")
        w = self._as_reference("wish", wish)
        ahead = p.rows.bounds - p.rows.state_rows @ x
        rooms = ahead[p.free] - p.references @ w
        found = qp.nearest_of_scaled(self._weight, w, p.scaled, p.lengths, rooms)
        if found.status == qp.OPTIMAL:
            slacks = (ahead - p.rows.reference_rows @ found.reference) / p.rooms
            if slacks.min(initial=np.inf) >= -_KEPT:
                self._last = found.reference
                return self._decision(p, found.reference, slacks, found, held=False)
            found = found._replace(status=qp.INFEASIBLE)  # by a row that no reference changes
        if self._last is None:
            raise self._refusal(k, p, ahead)
        slacks = (ahead - p.rows.reference_rows @ self._last) / p.rooms
        return self._decision(p, self._last, slacks, found, held=True)

    def _decision(
        self, p: _Prepared, v: Array, slacks: Array, found: qp.Nearest, *, held: bool
    ) -> PeriodicDecision:
        names, rows = self.sets.names, p.rows
        active: tuple[ActiveRow, ...] = ()
        if not held:
            order = np.argsort(-found.multipliers, kind="stable")
            least = _PRESSING * found.multipliers.max(initial=0.0)
            order = order[found.multipliers[order] > least]
            active = tuple(
                ActiveRow(names[rows.constraint[i]], int(rows.ahead[i]), float(lam), int(i))
                for i, lam in zip(p.free[order], found.multipliers[order], strict=True)
            )
        worst = int(slacks.argmin()) if len(slacks) else -1
        return PeriodicDecision(
            v.copy(),
            held,
            STATUS_NAMES[found.status],
            float(slacks[worst]) if len(slacks) else np.inf,
            names[rows.constraint[worst]] if len(slacks) else "",
            int(rows.ahead[worst]) if len(slacks) else STEADY,
            active,
            int(found.iterations),
        )

    def _refusal(self, k: int, p: _Prepared, ahead: Array) -> ParameterError:
        """Explain which constraints cannot be kept from a state: those of the least miss."""
        from scipy.optimize import linprog  # loaded where it is needed

        least = linprog(
            np.append(np.zeros(self._q), 1.0),
            A_ub=np.column_stack([p.rows.reference_rows / p.rooms[:, None], -np.ones(len(ahead))]),
            b_ub=ahead / p.rooms,
            bounds=(None, None),
            method="highs",
        )
        pressing = np.flatnonzero(least.ineqlin.marginals < -1e-9)
        told = sorted({(int(p.rows.ahead[i]), int(p.rows.constraint[i])) for i in pressing})
        listed = ", ".join(f"{self.sets.names[i]!r} {_when(j)}" for j, i in told[:3])
        return ParameterError(
            f"state: received one of step {k} from which no reference keeps every constraint; "
            f"missed at the best by {100.0 * least.fun:.3g} % of the room: {listed}; required a "
            "state inside the admissible set; start nearer, slower, or with wider bounds"
        )

    def _as_reference(self, name: str, value: object) -> Array:
        return as_finite(name, value, (self._q,), f"{self._q} finite numbers")

    def _prepare(self, k: int) -> _Prepared:
        rows = self.sets.at(k)
        n = rows.state_rows.shape[1]
        inside = as_shaped("inside", self.sets.inside[k], (n + self._q,))
        rooms = rows.slacks(inside[:n], inside[n:])
        scaled, lengths = self._weight.scaled(rows.reference_rows)
        free = np.flatnonzero(lengths > _NO_EFFECT * rooms)
        references = np.ascontiguousarray(rows.reference_rows[free])
        scaled = np.ascontiguousarray(scaled[free])
        return _Prepared(rows, rooms, free, references, scaled, lengths[free])


def _when(ahead: int) -> str:
    """Return in words in how many steps a row is met."""
    return {STEADY: "in steady state", 0: "at once", 1: "in 1 step"}.get(ahead, f"in {ahead} steps")
