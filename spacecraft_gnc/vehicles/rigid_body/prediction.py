"""Prediction of a closed loop from its gains at the target, without a solver.

At rest at the target no limit acts, and one step of the loop is linear: x+ = (A - B K) x for
x = (eta, Pi). K is the gain of the law (8)-(10) of Kalabic et al. 2014, or the first gain of the
horizon of Gupta et al. 2015, (27)-(28), by the Riccati recursion; `ocp.linearize` at the target
gives the same gains. The way there is flown about a fixed axis with the torque scaled down to its
limit: gyroscopic torques, zones and a governor are left out, and a plan that brakes ahead of the
limit is quicker.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.types import Array, Matrix3
from spacecraft_gnc.vehicles.rigid_body.chosen import reads_all
from spacecraft_gnc.vehicles.rigid_body.controllers.feedback import FeedbackParameters
from spacecraft_gnc.vehicles.rigid_body.parameters.ocp import PenalizedParameters
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario

MOST_STEPS: Final = 20_000
"""Of the flight with a limited torque, and samples of the linear one: some tenths of a second."""
MARGINAL: Final = 1e-9
"""A spectral radius above 1 minus this counts as 1: an axis without feedback has 1 twice."""
LINEAR: Final = 0.1
"""[rad] of attitude error under which the motion is linear."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Prediction:
    """What the gains tell."""

    spectral_radius: float
    """Of one step of the loop at the target; 1 and more: it does not settle."""
    settling_time: float
    """[s] until the attitude error stays below ``reference_governor.slew_tolerance_deg``; infinite:
    never."""
    most_excess: float
    """Share of ``max_torque`` by which the penalty lets the first torque exceed it at the most; 0
    without a limit. A solve tells how much of it is used."""


def predict(scenario: Scenario) -> Prediction | None:
    """Return the prediction; None where the gains of the method are not known or no numbers."""
    method = scenario.method
    is_law = reads_all(method, FeedbackParameters)
    has_horizon = reads_all(method, PenalizedParameters)
    if not (is_law or has_horizon):
        return None
    penalized = has_horizon and not method.hard_limits
    with np.errstate(all="ignore"):
        try:
            loop = _Loop.feedback(scenario) if is_law else _Loop.horizon(scenario)
        except np.linalg.LinAlgError:  # of numbers beyond double precision
            return None
        return Prediction(
            spectral_radius=loop.radius,
            settling_time=loop.settling_time(math.radians(scenario.governor.slew_tolerance_deg)),
            most_excess=loop.most_excess(scenario) if penalized else 0.0,
        )


class _Loop:
    """The loop in units in which its matrices are of one size: rad, and rad/s for Pi."""

    def __init__(
        self, scenario: Scenario, gain: Array, actuators: Array, pull: Array | None = None
    ) -> None:
        plant, self.period = scenario.plant, scenario.period
        self.limit = scenario.controller.max_torque or math.inf
        self.gain = gain
        self.pull = gain if pull is None else pull
        rate = np.linalg.inv(plant.inertia)
        step, n = plant.time_step, scenario.substeps
        self.drift = np.eye(6)
        self.drift[:3, 3:] = n * step * rate
        self.push = np.vstack(
            [0.5 * n * (n - 1) * step**2 * rate @ actuators, n * step * actuators]
        )
        self.step = self.drift - self.push @ gain
        self.radius = float(np.abs(np.linalg.eigvals(self.step)).max())
        target = lie.exp(scenario.governor.target_rotation_vector)
        start = lie.exp(plant.initial_rotation_vector)
        self.start = np.concatenate([lie.log(target.T @ start), plant.initial_momentum])

    @classmethod
    def feedback(cls, scenario: Scenario) -> _Loop:
        """Return the loop of T = -K Pi - e, e = (tr(A) I - A) eta."""
        c = scenario.controller
        gain = c.feedback_attitude_gain
        stiffness = np.trace(gain) * np.eye(3) - gain
        return cls(scenario, np.hstack([stiffness, c.feedback_momentum_gain]), np.eye(3))

    @classmethod
    def horizon(cls, scenario: Scenario) -> _Loop:
        """Return the loop of the first control of each horizon."""
        c = scenario.controller
        actuators, effort = _controls(scenario)
        h, w = c.time_step, c.weights
        drift = np.eye(6)
        drift[:3, 3:] = h * np.linalg.inv(c.inertia)
        push = np.vstack([np.zeros_like(actuators), h * actuators])
        stage = h * _block(_half(w.stage_attitude), _half(w.stage_momentum))
        ahead = _block(_half(w.terminal_attitude), _half(w.terminal_momentum))
        gain: Array = np.zeros((actuators.shape[1], 6))
        pull, free = gain, ahead
        for _ in range(c.horizon):
            gain = _solve(h * effort + push.T @ ahead @ push, push.T @ ahead @ drift)
            ahead = stage + drift.T @ ahead @ (drift - push @ gain)
            ahead = 0.5 * (ahead + ahead.T)
            pull = _solve(h * effort, push.T @ free @ drift)
            free = stage + drift.T @ free @ drift
        return cls(scenario, gain, actuators, pull)

    def settling_time(self, tolerance: float) -> float:
        """Return the time [s] after which the attitude error stays below ``tolerance`` [rad]."""
        if not self.radius < 1.0 - MARGINAL:
            return math.inf
        x, steps = self.start, 0
        while steps < MOST_STEPS:
            u, saturated = self._control(x)
            if not saturated and np.linalg.norm(x[:3]) <= LINEAR:
                break
            x, steps = self.drift @ x + self.push @ u, steps + 1
        return self.period * (steps + self._linear_steps(x, tolerance))

    def most_excess(self, scenario: Scenario) -> float:
        """Return s / U - 1 of the s with (S + 2 mu (s^2 - U^2)) s = |B^T lambda2|.

        The multiplier is that of the motion without torque, which limited ones change little.
        """
        c, limit = scenario.controller, self.limit
        demand = float(np.linalg.norm(self.pull @ self._bent(self.start)))
        if not demand > limit:
            return 0.0
        largest = float(np.linalg.eigvalsh(_controls(scenario)[1])[-1])
        stiffness = 2.0 * c.torque_penalty * limit**2 / largest
        return _excess(demand / limit, stiffness)

    def _linear_steps(self, x: Array, tolerance: float) -> int:
        """Return the steps after which the linear loop stays below ``tolerance``."""
        size = max(float(np.linalg.norm(x[:3])), tolerance)
        decay = -math.log(max(self.radius, 1e-300))
        last = math.ceil(3.0 * (math.log(size / tolerance) + 10.0) / decay) + 10
        stride = max(1, last // MOST_STEPS)
        power = np.linalg.matrix_power(self.step, stride)
        steps = found = 0
        while steps <= last:
            if np.linalg.norm(x[:3]) >= tolerance:
                found = steps + stride
            x, steps = power @ x, steps + stride
        return found

    def _control(self, x: Array) -> tuple[Array, bool]:
        u = -self.gain @ self._bent(x)
        size = float(np.linalg.norm(u))
        return (u * (self.limit / size), True) if size > self.limit else (u, False)

    @staticmethod
    def _bent(x: Array) -> Array:
        """Return the state with sin(angle) for the angle, as the gradient of the cost has it."""
        angle = float(np.linalg.norm(x[:3]))
        share = max(0.0, float(np.sinc(angle / math.pi)))
        return np.concatenate([share * x[:3], x[3:]])


def _excess(demand: float, stiffness: float) -> float:
    """Return t >= 0 with stiffness ((1 + t)^2 - 1) (1 + t) + 1 + t = demand, by Newton's method.

    The left side is convex and grows, so that the iterates fall from a t that is too large.
    """
    t = min(demand - 1.0, (demand / stiffness) ** (1.0 / 3.0) if stiffness > 0.0 else math.inf)
    for _ in range(200):
        value = stiffness * t * (2.0 + t) * (1.0 + t) + 1.0 + t - demand
        change = value / (stiffness * (2.0 + 6.0 * t + 3.0 * t * t) + 1.0)
        if not change > 1e-12 * t:
            break
        t -= change
    return max(t, 0.0) if math.isfinite(t) else math.inf


def _controls(scenario: Scenario) -> tuple[Array, Array]:
    """Return the actuator matrix B (3, m) and S (m, m), their cost being h u . S u."""
    c = scenario.controller
    actuators = np.asarray(c.actuators) if c.actuators.size else np.eye(3)
    weight, m = c.weights.stage_torque, actuators.shape[1]
    return actuators, _half(weight) if m == 3 else float(weight[0, 0]) * np.eye(m)


def _solve(matrix: Array, right: Array) -> Array:
    return np.asarray(np.linalg.solve(matrix, right), dtype=np.float64)


def _half(weight: Matrix3) -> Matrix3:
    """Return (tr(Q) I - Q) / 2: the cost is h x . S x."""
    return np.asarray(0.5 * (np.trace(weight) * np.eye(3) - weight))


def _block(first: Matrix3, second: Matrix3) -> Array:
    block = np.zeros((6, 6))
    block[:3, :3], block[3:, 3:] = first, second
    return block
