"""Linear law and closed loop of a scenario, made again from the audit's own equations.

The model is linearized by imaginary steps about the docked state, which the wrench U0(t) holds; the
periodic Riccati equation is doubled over a period, the equation of the whole period solved by
SciPy, and its solution led back through the steps.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial, reduce
from typing import Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.audit.equations import (
    ATTITUDE,
    OFFSET,
    RATE,
    VELOCITY,
    Equations,
    rotations,
    small_vectors,
)
from spacecraft_gnc.vehicles.docking.scenario import Scenario

STEP: Final = 1e-20
HELD: Final = np.zeros((12, 6))
"""E: the linear state at rest at a reference."""
HELD[:3, :3] = HELD[6:9, 3:] = np.eye(3)
_PHASES: Final = 25  # linearized together: their states fit into a cache
_TURN: Final = 0.05  # [rad] of the chief in a step of the integrator
_ROUNDS: Final = 2  # over the period, after which the Riccati equation has forgotten its end


@dataclass(frozen=True, slots=True, eq=False)
class Loop:
    """Model x+ = A x + B (U - U0), law U = U0 + Gamma v - K (x - E v); period p of steps."""

    A: Array
    """(p, 12, 12)"""
    B: Array
    """(p, 12, 6)"""
    U0: Array
    """(p, 6)"""
    Gamma: Array
    """(p, 6, 6)"""
    K: Array
    """(p, 6, 12)"""

    @property
    def period(self) -> int:
        """Number of control steps p."""
        return len(self.A)

    @property
    def through(self) -> Array:
        """Gamma + K E (p, 6, 6)."""
        return np.asarray(self.Gamma + self.K @ HELD)

    @property
    def closed(self) -> tuple[Array, Array]:
        """Maps (p, 12, 12), (p, 12, 6) of x and v to the next x."""
        return self.A - self.B @ self.K, self.B @ self.through

    def wrenches(self, steps: Any, x: Array, v: Array) -> Array:
        """Return U (m, 6) of steps for states (m, 12) and references (m, 6)."""
        k = steps % self.period
        held = self.U0[k] + np.einsum("nij,nj->ni", self.through[k], v)
        return np.asarray(held - np.einsum("nij,nj->ni", self.K[k], x))


class Model(NamedTuple):
    """A, B, U0 and Gamma, as in `Loop`."""

    A: Array
    B: Array
    U0: Array
    Gamma: Array

    @property
    def mean(self) -> Model:
        """The model without its periodicity, p = 1."""
        return Model(*(part.mean(axis=0, keepdims=True) for part in self))


def believed_model(scenario: Scenario) -> Model:
    """Return the periodic model of what the laws of a scenario believe; gravity is linear."""
    c, p = scenario.controller, scenario.plant
    inertia = c.inertia if np.size(c.inertia) else p.inertia
    base = Equations.of(p, c.mass or p.mass, inertia)
    parts = {name: getattr(base, name) for name in base.__slots__}
    return linearized(Equations(**{**parts, "two_body": False}), scenario.period)


def model_error(scenario: Scenario) -> float:
    """Return the share that a linear model may miss which is integrated by a fourth-order method.

    It is (h W)^4 with integrator step h and inertial rate W of the chief: 1e-11 for one rotation in
    1000 s.
    """
    p = scenario.plant
    rate = p.chief_spin_rate + p.mean_motion
    return float((rate * scenario.period / scenario.substeps) ** 4)


def loop_of(scenario: Scenario, model: Model) -> Loop:
    """Return the loop of a model with the weights of a scenario."""
    w = scenario.controller.weights
    Q = np.repeat([w.port_offset, w.port_velocity, w.attitude, w.angular_velocity], 3)
    R = np.repeat([w.force, w.moment], 3)
    return Loop(*model, gains(model.A, model.B, np.diag(Q), np.diag(R)))


def linearized(equations: Equations, period: float) -> Model:
    """Return the model about the docked state, one for each step of a rotation of the chief."""
    rate = float(np.linalg.norm(equations.spin))
    p = max(1, round(2.0 * math.pi / (rate * period))) if rate else 1
    times = np.asarray(period * np.arange(p), dtype=np.float64)
    parts = [
        _linearized(equations, period, times[first : first + _PHASES])
        for first in range(0, p, _PHASES)
    ]
    return Model(*(np.concatenate(part) for part in zip(*parts, strict=True)))


def _linearized(equations: Equations, period: float, times: Array) -> Model:
    """Return the model at some times (p,)."""
    p = len(times)
    small = 1j * STEP * np.repeat(np.eye(18), p, axis=0)  # direction by direction
    v = 1j * STEP * np.repeat(np.eye(6), p, axis=0)

    def held(s: float) -> Any:
        docked = equations.holding(times + s, np.zeros((p, 6)))
        return np.tile(docked, (18, 1)) + small[:, 12:]

    # The integrator does not see errors of the derivatives: its steps are kept short.
    rate = float(np.linalg.norm(equations.spin)) + equations.mean_motion
    count = max(1, math.ceil(rate * period / _TURN))
    end, h = _rows(small[:, :12]), period / count
    for i in range(count):
        from_then = partial(_later, held, i * h)
        end = equations.advanced(np.tile(times + i * h, 18), end, from_then, h)
    found = _coordinates(end).imag.reshape(18, p, 12).transpose(1, 2, 0) / STEP
    gamma = equations.mean_holding(np.tile(times, 6), v, period).imag / STEP
    return Model(
        found[:, :, :12],
        found[:, :, 12:],
        equations.mean_holding(times, np.zeros((p, 6)), period),
        gamma.reshape(6, p, 6).transpose(1, 2, 0),
    )


def _later(function: Callable[[float], Any], start: float, s: float) -> Any:
    return function(start + s)


def gains(A: Array, B: Array, Q: Array, R: Array) -> Array:
    """Return the gains (p, 6, 12) of the periodic Riccati equation."""
    from scipy.linalg import solve_discrete_are

    effort = [b @ np.linalg.solve(R, b.T) for b in B]
    whole = reduce(_after, ((a, g, Q) for a, g in zip(A, effort, strict=True)))
    values, vectors = np.linalg.eigh(whole[1])
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    P = solve_discrete_are(whole[0], root, whole[2], np.eye(len(Q)))
    found = np.empty((len(A), B.shape[2], A.shape[2]))
    for _ in range(_ROUNDS):
        for k in range(len(A) - 1, -1, -1):
            a, b = A[k], B[k]
            found[k] = np.linalg.solve(R + b.T @ P @ b, b.T @ P @ a)
            left = a - b @ found[k]
            P = Q + found[k].T @ R @ found[k] + left.T @ P @ left
    return found


def _after(
    first: tuple[Array, Array, Array], second: tuple[Array, Array, Array]
) -> tuple[Array, Array, Array]:
    """Return (A, G, H) of two steps, one after the other: a doubling of the Riccati equation."""
    (a1, g1, h1), (a2, g2, h2) = first, second
    one = np.eye(len(a1))
    through = np.linalg.solve(one + g1 @ h2, np.hstack([a1, g1]))
    n = len(one)
    forward, pushed = through[:, :n], through[:, n:]
    return a2 @ forward, g2 + a2 @ pushed @ a2.T, h1 + a1.T @ h2 @ forward


def _rows(x: Any) -> Any:
    """Return rows (n, 18) of linear states (n, 12)."""
    rows = np.zeros((len(x), 18), dtype=x.dtype)
    rows[:, OFFSET], rows[:, VELOCITY], rows[:, RATE] = x[:, :3], x[:, 3:6], x[:, 9:]
    rows[:, ATTITUDE] = rotations(x[:, 6:9]).reshape(-1, 9)
    return rows


def _coordinates(rows: Any) -> Any:
    """Return linear states (n, 12) of rows (n, 18) with attitudes of a few degrees."""
    turned = small_vectors(rows[:, ATTITUDE].reshape(-1, 3, 3))
    return np.concatenate([rows[:, OFFSET], rows[:, VELOCITY], turned, rows[:, RATE]], axis=1)


def linear_states(rows: Array) -> Array:
    """Return linear states (n, 12) of recorded rows (n, 18), attitudes of less than half a turn."""
    from scipy.spatial.transform import Rotation

    R = rows[:, ATTITUDE].reshape(-1, 3, 3)
    turned = np.full((len(R), 3), np.nan)
    known = np.isfinite(R).all(axis=(1, 2)) & (np.linalg.det(np.nan_to_num(R)) > 0.0)
    if known.any():
        turned[known] = Rotation.from_matrix(R[known]).as_rotvec()
    return np.concatenate([rows[:, OFFSET], rows[:, VELOCITY], turned, rows[:, RATE]], axis=1)
