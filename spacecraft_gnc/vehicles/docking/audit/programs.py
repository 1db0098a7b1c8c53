"""Optimality conditions of the program that the governor solves at each step."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.evidence import Progress
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.audit.admissible import NAMES, STEADY, Responses, Rows
from spacecraft_gnc.vehicles.docking.audit.law import model_error
from spacecraft_gnc.vehicles.docking.audit.told import Told
from spacecraft_gnc.vehicles.docking.decision import Answer
from spacecraft_gnc.vehicles.docking.signals import GOVERNOR_STATUS, REFERENCE, STATE

MEMBER: Final = "reference admissible: response simulated"
_FIRST_ORDER: Final = "program of the governor: stationarity"
_COMPLEMENT: Final = "program of the governor: rows with a multiplier are met"
_SIGN: Final = "program of the governor: multipliers not negative"
_SLACK: Final = "slack and the constraint named"
_HELD: Final = "reference held: no admissible one (LP)"
_RESIDUAL: Final = "residual told"
_MISSED: Final = 1e-6
"""By how much a row may be missed, in its unit or as a share of its room when docked; share of the
pull toward the wish that may be left over."""
_CERTAIN: Final = 1e-8
_CUTS: Final = 40


class Programs:
    """The programs of the steps at which the way to the target goes on."""

    def __init__(self, told: Told, responses: Responses, ledger: Ledger) -> None:
        self.told, self.responses, self.ledger = told, responses, ledger
        g = told.evidence.scenario.governor
        self.missed = _MISSED + 10.0 * model_error(told.evidence.scenario)
        self.weight = np.repeat([1.0, g.rotation_weight], 3)
        self.status, self.slack = told.field("status"), told.field("slack")
        self.residual, self.ahead = told.field("residual"), told.field("constraint_ahead")
        self.named, self.active = told.text("constraint"), told.text("active")
        self.multipliers = _padded(told.field("multipliers"))
        self.active_ahead = _padded(told.field("active_ahead"))

    def audit(self, progress: Progress | None) -> None:
        """Check each of them."""
        at = np.flatnonzero(self.told.docking)
        for count, i in enumerate(at.tolist()):
            step = int(self.told.steps[i])
            rows, x, v = self.responses.at(step), self.told.states[i], self.told.reference[i]
            if not np.isfinite(x).all():
                self._fail(MEMBER, step, f"{STATE}.measured_attitude")
                continue
            slacks = rows.slacks(x, v)
            self._slack(i, step, rows, slacks)
            if self.status[i] == Answer.OPTIMAL:
                self._optimal(i, step, rows, slacks)
            else:
                self._held(i, step, rows)
            if progress is not None:
                progress(count + 1, len(at))
        if not at.size:
            self.ledger.skip(MEMBER, "no step was on the way to the target")

    def _fail(self, check: str, step: int, where: str) -> None:
        self.ledger.fail(check, "", step, where)

    def _bound(self, check: str, step: int, where: str, off: Any, limit: float) -> None:
        at = np.array([step])
        self.ledger.bound(check, at, where, np.reshape(np.abs(off), (1, -1)), limit)

    def _slack(self, i: int, step: int, rows: Rows, slacks: Array) -> None:
        """Compare smallest slack and the constraint that has it."""
        where = f"{GOVERNOR_STATUS}.slack"
        least = float(slacks.min())
        limit = self.missed * max(1.0, abs(least))
        self._bound(_SLACK, step, where, self.slack[i] - least, limit)
        chosen = self._those(rows, self.named[i], int(self.ahead[i]))
        off = float(slacks[chosen].min()) - least if chosen.any() else math.inf
        self._bound(_SLACK, step, f"{GOVERNOR_STATUS}.constraint", off, limit)

    @staticmethod
    def _those(rows: Rows, name: str, ahead: int) -> NDArray[np.bool_]:
        """Return which rows are of a constraint so many steps ahead."""
        index = NAMES.index(name) if name in NAMES else len(NAMES)
        return np.asarray((rows.constraint == index) & (rows.ahead == ahead))

    def _optimal(self, i: int, step: int, rows: Rows, slacks: Array) -> None:
        """Check membership and the first-order conditions; the program is convex."""
        missed = max(0.0, -float((slacks * rows.bound).min()))  # [N], [N m], [m]
        self._bound(MEMBER, step, REFERENCE.name, missed, self.missed)
        told = self.residual[i]
        where = f"{GOVERNOR_STATUS}.residual"
        self._bound(
            _RESIDUAL, step, where, 0.0 if 0.0 <= told <= _MISSED else math.inf, self.missed
        )
        names = [name for name in self.active[i].split("; ") if name]
        multipliers = self.multipliers[i][: len(names)]
        ahead = self.active_ahead[i][: len(names)]
        where = f"{GOVERNOR_STATUS}.multipliers"
        known = np.isfinite(self.multipliers[i]).sum() == len(names) == np.isfinite(ahead).sum()
        if not known or not np.isfinite(multipliers).all():
            self._fail(_SIGN, step, where)
            return
        self._bound(_SIGN, step, where, np.minimum(multipliers, 0.0).min(initial=0.0), 0.0)
        self._stationary(i, step, rows, slacks, [*zip(names, ahead, multipliers, strict=True)])

    def _stationary(
        self, i: int, step: int, rows: Rows, slacks: Array, active: list[tuple[str, Any, Any]]
    ) -> None:
        """Check M (v - w) + H' lambda = 0, and that the rows of H are met."""
        off = self.weight * (self.told.reference[i] - self.told.wish[i])
        size = max(1.0, float(np.abs(off).max()))
        steady: dict[str, float] = {}
        for name, ahead, multiplier in active:
            chosen = np.flatnonzero(self._those(rows, name, int(ahead)))
            slack = slacks[chosen].min(initial=math.inf)
            self._bound(_COMPLEMENT, step, f"{GOVERNOR_STATUS}.active", slack, self.missed)
            if ahead == STEADY:
                steady[name] = steady.get(name, 0.0) + multiplier
            elif chosen.size:
                pull = rows.reference[chosen[0]] * multiplier
                off, size = off + pull, max(size, float(np.abs(pull).max()))
        off = self._with_steady(off, rows, slacks, steady)
        where = f"{GOVERNOR_STATUS}.multipliers"
        self._bound(_FIRST_ORDER, step, where, off / size, self.missed)

    def _with_steady(
        self, off: Array, rows: Rows, slacks: Array, steady: dict[str, float]
    ) -> Array:
        """Add the pull of rows in steady state, of which the phase is not told: those that fit."""
        if not steady:
            return off
        from scipy.optimize import nnls

        columns, shares = [], []
        for which, name in enumerate(steady):
            chosen = np.flatnonzero(self._those(rows, name, STEADY) & (slacks < self.missed))
            columns.append(rows.reference[chosen])
            shares.append(np.tile(np.eye(len(steady))[which], (len(chosen), 1)))
        pulls = np.concatenate(columns)
        if not len(pulls):
            return off
        total = np.array([*steady.values()])
        heavy = 1e3 * max(1.0, float(np.abs(pulls).max()))
        system = np.vstack([pulls.T, heavy * np.concatenate(shares).T])
        found = nnls(system, np.concatenate([-off, heavy * total]))[0]
        return np.append(off + pulls.T @ found, np.concatenate(shares).T @ found - total)

    def _held(self, i: int, step: int, rows: Rows) -> None:
        """Check that no reference is admissible, and that the last one is held."""
        last = self.told.reference[i - 1] if i and self.told.steps[i - 1] == step - 1 else None
        if last is not None:
            kept = self.told.reference[i] == last
            where = REFERENCE.name
            self.ledger.require("reference held = the last one", "the same", np.array([step]),
                                where, kept.all(keepdims=True))  # fmt: skip
        if self.status[i] == Answer.NOT_SOLVED:
            self.ledger.check(_HELD, "", "some steps: the solver gave up")
            return
        if self.status[i] != Answer.INFEASIBLE:
            self._fail(_HELD, step, f"{GOVERNOR_STATUS}.status")
            return
        room = least_miss(rows, self.told.states[i])
        where = f"{GOVERNOR_STATUS}.status"
        kept = np.array([room > -_CERTAIN])
        self.ledger.require(_HELD, "least miss not negative", np.array([step]), where, kept)


def least_miss(rows: Rows, x: Array) -> float:
    """Return the least t at which a reference misses every row by t of its room at most.

    By linear programs with the rows that matter, added where they are missed the most.
    """
    from scipy.optimize import linprog

    room = (rows.bound - rows.state @ x) / rows.bound
    scaled = rows.reference / rows.bound[:, None]
    chosen = np.unique(np.append(np.argsort(room)[:50], np.flatnonzero(rows.ahead == STEADY)))
    found = -math.inf
    for _ in range(_CUTS):
        answer = linprog(
            np.append(np.zeros(6), 1.0),
            A_ub=np.column_stack([scaled[chosen], -np.ones(len(chosen))]),
            b_ub=room[chosen],
            bounds=[(None, None)] * 6 + [(-1.0, None)],
            method="highs",
        )
        if answer.status != 0:
            return math.nan
        v, found = answer.x[:6], float(answer.x[6])
        missed = scaled @ v - room
        if found > _CERTAIN or missed.max() <= found + 0.1 * _CERTAIN:
            return found
        chosen = np.union1d(chosen, np.argsort(-missed)[:50])
    return found


def _padded(values: Array) -> Array:
    """Return sequences (m, longest), also where none has an element."""
    return values.reshape(len(values), -1)
