"""Choice among the combinations of shifts: the cheapest admissible one, or the least violating.

J = W + Omega, W = shift_weight sum over pairs of (circular distance of their shifts)^2, and Omega
the sum over craft and steps of the horizon of e . Q e + dv . R dv.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from spacecraft_gnc.governors.time_shift import _choice_kernels as kernels
from spacecraft_gnc.governors.time_shift.prediction import Mask, Prediction, Predictor
from spacecraft_gnc.governors.time_shift.problem import Integers


class Choice(NamedTuple):
    """A combination of shifts."""

    shifts: Integers
    """(n,)"""
    n_admissible: int
    """Combinations that keep every constraint."""


def cheapest(predictor: Predictor, prediction: Prediction) -> Choice | None:
    """Return the admissible combination of least J; None if none is admissible."""
    shifts = np.zeros(predictor.problem.n_craft, dtype=np.int64)
    best, count = kernels.cheapest(
        prediction.able, prediction.pairs, predictor.apart, ~prediction.lost, prediction.cost,
        math.inf, shifts,
    )  # fmt: skip
    return Choice(shifts, int(count)) if math.isfinite(best) else None


def cheaper(
    predictor: Predictor, prediction: Prediction, shifts: Integers, cost: float
) -> Integers | None:
    """Return the combination (n,) of least J, admissible or not; None if it is ``shifts``.

    ``cost`` is J of ``shifts`` (n,).
    """
    found = np.zeros(predictor.problem.n_craft, dtype=np.int64)
    best, _ = kernels.cheapest(
        _selectable(prediction), np.ones_like(prediction.pairs), predictor.apart,
        ~prediction.lost, prediction.cost, cost, found,
    )  # fmt: skip
    return None if best >= cost or np.array_equal(found, shifts) else found


def least_violating(predictor: Predictor, prediction: Prediction) -> Choice:
    """Return the combination whose largest excess, as a share of its limit, is least."""
    problem = predictor.problem
    found = predictor.extremes(prediction)
    single = np.sqrt(prediction.delta_v) / problem.max_delta_v - 1.0
    double = np.full(found.nearest.shape, -1.0)
    if problem.min_separation > 0.0:
        double = np.maximum(double, 1.0 - np.sqrt(found.nearest) / problem.min_separation)
    if problem.max_angle < math.pi:
        angle = np.arccos(np.clip(found.cosine, -1.0, 1.0))
        double = np.maximum(double, angle / problem.max_angle - 1.0)
    shifts = np.zeros(problem.n_craft, dtype=np.int64)
    # A kept limit is as good as another: of those, the cheapest.
    kernels.least_violating(
        np.maximum(single, 0.0), np.maximum(double, 0.0), predictor.apart, ~prediction.lost,
        prediction.cost, _selectable(prediction), shifts,
    )  # fmt: skip
    return Choice(shifts, 0)


def longest_kept(predictor: Predictor, prediction: Prediction) -> Choice | None:
    """Return the combination that keeps every constraint the longest, of equals the cheapest.

    None if that is less than half a period: too late for the next steps to find a way round.
    """
    problem = predictor.problem
    shifts = np.zeros(problem.n_craft, dtype=np.int64)
    if not prediction.able.any(axis=1).all():
        return None
    until = predictor.kept_until(prediction)
    longest = int(until.max(initial=0))
    early = kernels.least_violating(
        np.zeros_like(prediction.cost), (longest - until).astype(np.float64), predictor.apart,
        ~prediction.lost, prediction.cost, prediction.able, shifts,
    )  # fmt: skip
    kept = (longest - int(early)) / problem.substeps
    return Choice(shifts, 0) if kept >= problem.samples // 2 else None


def nearest(
    predictor: Predictor,
    prediction: Prediction,
    distances: Integers,
    most: int,
    last: Integers,
    *,
    is_whole: bool,
) -> Choice | None:
    """Return the admissible combination of least distance; ``last`` if none is ``most`` away.

    ``distances`` (c,) and ``is_whole`` are those of `Passages`. None if ``last``
    would have to be returned, and is not admissible.
    """
    shifts = np.zeros(predictor.problem.n_craft, dtype=np.int64)
    found, count = kernels.nearest(
        prediction.able, prediction.pairs, predictor.apart, ~prediction.lost, prediction.cost,
        predictor.problem.phases, distances, is_whole, most, shifts,
    )  # fmt: skip
    if found >= 0:
        return Choice(shifts, int(count))
    return Choice(last, int(count)) if is_admissible(prediction, last) else None


def cost_of(predictor: Predictor, prediction: Prediction, shifts: Integers) -> tuple[float, float]:
    """Return (W, Omega) of a combination."""
    W, Omega = kernels.cost_of(shifts, predictor.apart, ~prediction.lost, prediction.cost)
    return float(W), float(Omega)


def is_admissible(prediction: Prediction, shifts: Integers) -> bool:
    """Tell whether a combination keeps every constraint."""
    n = len(shifts)
    return all(prediction.able[i, shifts[i]] for i in range(n)) and all(
        prediction.pairs[i, j, shifts[i], shifts[j]] for i in range(n) for j in range(i + 1, n)
    )


def _selectable(prediction: Prediction) -> Mask:
    """Return the shifts (n, p) that can be chosen at all: those of a lost craft cannot."""
    return np.where(prediction.lost[:, None], prediction.able, np.True_)
