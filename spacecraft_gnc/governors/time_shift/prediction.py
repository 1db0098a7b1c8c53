"""Prediction of a formation: each craft under each of its shifts, and which combinations keep all.

With its shift held, the error e = x - x_d of a craft obeys e+ = (A + B K) e, so that its positions,
its delta-v and its cost at every step ahead are fixed maps of the error now. A constraint concerns
one craft or two; p predictions for each craft and p^2 tests for each pair decide about all p^n
combinations. A lost craft drifts, whatever is commanded: it only has to be kept away from.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import fractional_matrix_power

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors.time_shift import _prediction_kernels as kernels
from spacecraft_gnc.governors.time_shift import margins
from spacecraft_gnc.governors.time_shift.margins import Margin
from spacecraft_gnc.governors.time_shift.problem import (
    Integers,
    TimeShiftProblem,
    shift_distance,
)
from spacecraft_gnc.types import Array, read_only

Mask = NDArray[np.bool_]
_ROOT: Final = 1e-9  # of its size, by which a substep's map may miss the step's


class Prediction(NamedTuple):
    """Prediction from one state; craft first, then its shifts."""

    step: int
    able: Mask
    """(n, p) shifts under which the craft keeps its delta-v; of a lost craft only its last one."""
    pairs: Mask
    """(n, n, p, p) shifts that keep the constraints of a pair i < j."""
    cost: Array
    """(n, p) Omega of each craft; 0 for a lost one."""
    positions: Array
    """(n, p, 3, r) [m]"""
    delta_v: Array
    """(n, p) square of the largest delta-v [m^2/s^2]; 0 for a lost craft."""
    delta_v_ahead: Integers
    """(n, p) steps until then."""
    lost: Mask
    """(n,)"""
    states: Array
    """(n, 6) predicted from."""


class Extremes(NamedTuple):
    """Extremes of all pairs, (n, n, p, p) each, i < j, with the instants at which they are met."""

    nearest: Array
    """Square of the least distance [m^2]."""
    near_at: Integers
    cosine: Array
    """Least cosine of the angle; 2 where it is not asked for."""
    wide_at: Integers


class Predictor:
    """What predictions of one problem share.

    Parameters
    ----------
    problem : TimeShiftProblem
    """

    def __init__(self, problem: TimeShiftProblem) -> None:
        self.problem = problem
        p, m, horizon = problem.samples, problem.substeps, problem.horizon
        within = _within_a_step(problem)
        errors = _powers(problem.loop_map, horizon + 1)
        kicked = np.eye(6) + np.vstack([np.zeros((3, 6)), problem.gain])
        rows = [(w @ (e if j == 0 else kicked @ e))[:3] for e in errors for j, w in within]
        self.rows = _inner_last(rows[: horizon * m + 1])
        drifts = [(w @ d)[:3] for d in _powers(problem.state_map, horizon + 1) for _, w in within]
        self.drifts = _inner_last(drifts[: horizon * m + 1])
        self.pushes = _inner_last([problem.gain @ e for e in errors[:horizon]])
        stage = problem.state_weight + problem.gain.T @ problem.control_weight @ problem.gain
        self.cost = read_only(sum((e.T @ stage @ e for e in errors[:horizon]), np.zeros((6, 6))))
        path = np.concatenate([problem.natural[:, None] @ w.T for _, w in within], axis=1)
        around = path.reshape(p * m, 6)[:, :3]
        columns = np.arange(p * m + horizon * m) % (p * m)
        self.path = read_only(np.ascontiguousarray(around[columns].T))
        self.apart = read_only(problem.shift_weight * shift_distance(p) ** 2)
        limit = math.cos(problem.max_angle)
        self.cosine = kernels.NO_ANGLE if problem.max_angle == math.pi else limit * abs(limit)

    def predict(self, step: int, states: Array, shifts: Integers, lost: Mask) -> Prediction:
        """Predict from the states (n, 6).

        ``shifts`` (n,) are the last ones, of which a lost craft (``lost``, (n,)) keeps its own.
        """
        problem = self.problem
        n, p = problem.n_craft, problem.samples
        delta_v, ahead, cost = np.zeros((n, p)), np.zeros((n, p), dtype=np.int64), np.zeros((n, p))
        positions = np.zeros((n, p, 3, self.rows.shape[2]))
        for i in range(n):
            if lost[i]:
                kernels.spread(self.drifts, states[i], positions[i, shifts[i]])
            else:
                kernels.predict_craft(
                    step, states[i], problem.phases[i], problem.substeps, problem.natural,
                    self.path, self.pushes, self.rows, self.cost, delta_v[i], ahead[i], cost[i],
                    positions[i],
                )  # fmt: skip
        able = delta_v <= problem.max_delta_v**2
        able[lost] = np.arange(p) == shifts[lost, None]
        pairs = np.zeros((n, n, p, p), dtype=np.bool_)
        kernels.pair_masks(
            step, problem.phases, problem.substeps, problem.natural, self.path, positions, able,
            lost, problem.min_separation**2, self.cosine, pairs,
        )  # fmt: skip
        return Prediction(step, able, pairs, cost, positions, delta_v, ahead, lost.copy(), states)

    def drift(self, state: Array, steps: int) -> Array:
        """Return the positions (3, steps m + 1) of a craft that drifts from a state (6,)."""
        ahead, parts = self.problem.horizon, []
        over = np.linalg.matrix_power(self.problem.state_map, ahead)
        for _ in range(steps // ahead + 1):
            parts.append(np.einsum("cjq,j->cq", self.drifts, state)[:, :-1])
            state = over @ state
        path = np.concatenate(parts, axis=1)[:, : steps * self.problem.substeps + 1]
        return np.ascontiguousarray(path)

    def extremes(self, prediction: Prediction) -> Extremes:
        """Return the extremes of all pairs under all shifts, admissible or not."""
        n, p = prediction.able.shape
        shape = (n, n, p, p)
        found = Extremes(
            np.full(shape, np.inf), np.zeros(shape, dtype=np.int64),
            np.full(shape, 2.0), np.zeros(shape, dtype=np.int64),
        )  # fmt: skip
        kernels.pair_extremes(
            prediction.step, self.problem.phases, self.problem.substeps, self.problem.natural,
            self.path, prediction.positions, *found,
        )  # fmt: skip
        self._forgive(prediction.lost, found)
        return found

    def kept_until(self, prediction: Prediction) -> Integers:
        """Return the instants (n, n, p, p) at which each pair i < j first fails, r for never.

        Of shifts under which both keep their delta-v; of others 0.
        """
        problem, (n, p) = self.problem, prediction.able.shape
        until = np.zeros((n, n, p, p), dtype=np.int64)
        until[np.ix_(prediction.lost, prediction.lost)] = self.rows.shape[2]
        kernels.pair_failures(
            prediction.step, problem.phases, problem.substeps, self.path, prediction.positions,
            prediction.able, prediction.lost, problem.min_separation**2, self.cosine, until,
        )  # fmt: skip
        return until

    def margins(self, prediction: Prediction, shifts: Integers) -> tuple[Margin, ...]:
        """Return the margins of all constraints along the prediction of one combination."""
        problem, lost = self.problem, prediction.lost
        n = problem.n_craft
        found = [
            margins.of_delta_v(
                problem, i, float(prediction.delta_v[i, a]), int(prediction.delta_v_ahead[i, a])
            )
            for i, a in enumerate(shifts)
            if not lost[i]
        ]
        columns = (prediction.step + problem.phases + shifts) % problem.samples * problem.substeps
        for i in range(n):
            for j in range(i + 1, n):
                if lost[i] and lost[j]:
                    continue
                nearest, near_at, cosine, wide_at = kernels.extremes(
                    prediction.positions[i, shifts[i]], prediction.positions[j, shifts[j]],
                    self.path, columns[i], columns[j],
                )  # fmt: skip
                found.append(margins.of_separation(problem, (i, j), nearest, near_at))
                if not (lost[i] or lost[j]):
                    found.append(margins.of_angle(problem, (i, j), cosine, wide_at))
        return tuple(found)

    def _forgive(self, lost: Mask, found: Extremes) -> None:
        """Remove what is not asked of pairs with a lost craft."""
        for i in np.flatnonzero(lost):
            found.cosine[i, :] = found.cosine[:, i] = 2.0
            found.nearest[i, lost] = np.inf


def _within_a_step(problem: TimeShiftProblem) -> list[tuple[int, Array]]:
    """Return (j, the map (6, 6) over j substeps), j = 0 to substeps - 1."""
    m, whole = problem.substeps, np.asarray(problem.state_map)
    if m == 1:
        return [(0, np.eye(6))]
    part = np.real(fractional_matrix_power(whole, 1.0 / m))
    miss = float(np.abs(np.linalg.matrix_power(part, m) - whole).max() / np.abs(whole).max())
    if not miss <= _ROOT:
        raise ParameterError(
            f"substeps: received {m} for a state map without a root (its power misses it by "
            f"{miss:.3g}); required a map exp(F h) with h below half a period; give 1"
        )
    return list(enumerate(_powers(part, m)))


def _powers(matrix: Array, count: int) -> list[Array]:
    """Return the powers 0 to count - 1."""
    found = [np.eye(len(matrix))]
    for _ in range(count - 1):
        found.append(matrix @ found[-1])
    return found


def _inner_last(rows: list[Array]) -> Array:
    """Return rows (3, 6) as an array (3, 6, r), contiguous along the last axis."""
    return read_only(np.ascontiguousarray(np.stack(rows, axis=-1)))
