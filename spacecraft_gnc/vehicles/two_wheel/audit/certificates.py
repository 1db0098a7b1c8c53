"""First- and second-order conditions of recorded plans of two wheels."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from spacecraft_gnc.types import Array, Matrix3
from spacecraft_gnc.vehicles.two_wheel.audit.wheel_problem import STEP, WheelProblem

_AT_BOUND: Final = 1e-3
"""Distance from a bound, over its size, at which it may act."""
_STRONG: Final = 1e-7
"""Multiplier, over the largest one, with which it does."""
_DIFFERENCE: Final = 1e-4
"""Step of the differences of gradients [rad/s^2]."""


class FirstOrder(NamedTuple):
    """First-order conditions of a plan."""

    residual: float
    """Largest derivative of the Lagrangian, or product of a multiplier and the distance from its
    bound, over 1 + the sizes of what adds up to it."""
    prices: Array
    """Multipliers of the end."""
    acting: Array
    """(p, 2 N) derivatives of what acts: the end, and the bounds with a multiplier."""


@dataclass(frozen=True, slots=True, eq=False)
class Planned:
    """A recorded plan, and what it was made for."""

    problem: WheelProblem
    model: str
    soft: bool
    first: Matrix3
    """(3, 3) error at the start, in the prediction frame."""
    drift: Array
    """(N+1, 3) in the prediction frame [rad/s]."""
    start: Array
    """(2,) wheel speeds [rad/s]."""
    accelerations: Array
    """(N, 2) [rad/s^2]."""

    @property
    def bounded(self) -> tuple[Array, Array]:
        """Distances (2, 4 N - 2) from upper and lower bounds, over their size; derivatives by u.

        The derivatives (4 N - 2, 2 N) are those of what is bounded: speeds, then accelerations.
        """
        p, u = self.problem, self.accelerations
        n = len(u)
        by_u = np.kron(np.tril(np.ones((n, n))), p.period * np.eye(2))[:-2]
        values = np.concatenate([p.speeds(self.start, u[None])[0, 1:-1].ravel(), u.ravel()])
        limits = np.repeat([p.max_speed, p.max_acceleration or math.inf], [2 * n - 2, 2 * n])
        share = values / limits
        return np.array([1.0 - share, 1.0 + share]), np.vstack([by_u, np.eye(2 * n)])

    def derivatives(self, u: Array) -> tuple[Array, Array]:
        """Return the gradient (2 N,) of the cost by accelerations, and that of the end (p, 2 N)."""
        size = u.size
        gradients, ends = self._derivatives(u.reshape(1, size))
        return gradients[0], ends[0]

    def _derivatives(self, rows: Array) -> tuple[Array, Array]:
        """Return the same (b, 2 N), (b, p, 2 N) of many plans (b, 2 N)."""
        b, size = rows.shape
        steps: Any = rows[:, None, :] + 1j * STEP * np.eye(size)
        u = steps.reshape(b * size, -1, 2)
        speeds = self.problem.speeds(self.start, u)
        errors = self.problem.errors(self.model, self.first, self.drift, speeds)
        cost = self.problem.cost(errors, speeds, u, self.soft).imag / STEP
        end = speeds[:, -1] if self.soft else np.hstack([errors[:, -1], speeds[:, -1]])
        return cost.reshape(b, size), (end.imag / STEP).reshape(b, size, -1).transpose(0, 2, 1)

    def certify(self) -> FirstOrder:
        """Return how far the first-order conditions are kept.

        The multipliers are those that come nearest to it, not negative for the bounds.
        """
        gradient, end = self.derivatives(self.accelerations)
        room, by_u = self.bounded
        upper, lower = room < _AT_BOUND
        bounds = np.vstack([by_u[upper], -by_u[lower]])
        normals = np.vstack([end, bounds])
        least = np.concatenate([np.full(len(end), -math.inf), np.zeros(len(bounds))])
        found = lsq_linear(normals.T, -gradient, bounds=(least, math.inf), method="bvls").x
        off = gradient + normals.T @ found
        prices = found[len(end) :]
        strong = prices > _STRONG * max(1.0, float(prices.max(initial=0.0)))
        slack = prices * np.concatenate([room[0, upper], room[1, lower]])
        size = max(float(np.abs(off).max()), float(slack.max(initial=0.0)))
        size /= 1.0 + float(np.max(np.abs(gradient) + np.abs(normals.T) @ np.abs(found)))
        return FirstOrder(size, found[: len(end)], np.vstack([end, bounds[strong]]))

    def curvature(self, found: FirstOrder) -> float:
        """Return the least eigenvalue of the Lagrangian's Hessian where nothing acts."""
        free = _null_space(found.acting)
        if not len(free):
            return math.inf
        rows = self.accelerations.ravel() + _DIFFERENCE * np.vstack([free, -free])
        gradients, ends = self._derivatives(rows)
        slopes = gradients + np.einsum("p,bpn->bn", found.prices, ends)
        m = len(free)
        hessian = (slopes[:m] - slopes[m:]) @ free.T / (2.0 * _DIFFERENCE)
        return float(np.linalg.eigvalsh(0.5 * (hessian + hessian.T))[0])


def _null_space(rows: Array) -> NDArray[np.float64]:
    """Return an orthonormal basis (m, n) of what rows (p, n) leave."""
    scaled = rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-300)
    _, sizes, right = np.linalg.svd(scaled)
    return np.asarray(right[int(np.count_nonzero(sizes > 1e-10)) :])
