"""What a decision of the periodic governor tells, and how well it solves its program."""

from __future__ import annotations

from typing import Final

import numpy as np

from spacecraft_gnc.governors.periodic import AdmissibleSet, PeriodicDecision
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.decision import Active, Answer

_ANSWERS: Final = {
    "optimal": Answer.OPTIMAL,
    "infeasible": Answer.INFEASIBLE,
    "not solved": Answer.NOT_SOLVED,
}


def answer_of(decision: PeriodicDecision) -> Answer:
    """Return how the program of a step ended."""
    return _ANSWERS[decision.status]


def active_of(decision: PeriodicDecision) -> tuple[Active, ...]:
    """Return the constraints that keep the reference from the wish, largest multiplier first."""
    return tuple(Active(a.name, a.row, a.ahead, a.multiplier) for a in decision.active)


def kkt_residual(
    rows: AdmissibleSet, weight: Array, state: Array, wish: Array, decision: PeriodicDecision
) -> float:
    """Return the largest violation of the optimality conditions of the program of a step.

    min 1/2 (v - w)' M (v - w) subject to H v <= b: stationarity M (v - w) + H' lambda = 0, as a
    share of the largest of its terms (at least 1); rows broken or not met by an active multiplier,
    as a share of the size of the row's terms (at least 1); and negative multipliers likewise.

    Parameters
    ----------
    rows : AdmissibleSet
        Of the step.
    weight : (6,) array
        Diagonal of M.
    state : (12,) array
    wish : (6,) array
        w.
    decision : PeriodicDecision
        With status "optimal".
    """
    v = decision.reference
    index = [a.row for a in decision.active]
    multipliers = np.array([a.multiplier for a in decision.active])
    pulls = rows.reference_rows[index] * multipliers[:, None]
    pull = weight * (v - wish)
    size = max(1.0, float(np.abs(pull).max()), float(np.abs(pulls).max(initial=0.0)))
    stationarity = np.abs(pull + pulls.sum(axis=0)).max() / size
    terms = np.abs(rows.bounds) + np.abs(rows.state_rows) @ np.abs(state)
    slacks = rows.slacks(state, v) / np.maximum(1.0, terms)
    broken = max(0.0, -float(slacks.min(initial=0.0)))
    unmet = np.abs(slacks[index]).max(initial=0.0)
    negative = max(0.0, -float(multipliers.min(initial=0.0))) / size
    return float(max(stationarity, broken, unmet, negative))
