"""Conditions of optimality of a told transfer, from the numbers of its message alone.

Phogat et al., (5.6)-(5.8), derived once more from the step's equations

    h hat(Pi) = F Jd - Jd F^T,    R+ = R F,    Pi+ = F^T Pi + h u.

With F exp(hat(xi)) for a change dPi, the first one gives h F^T dPi = (tr(Jd F) I - Jd F) xi, so
that xi = B dPi and dPi+ = A dPi + h du, with A = F^T + hat(F^T Pi) B. To first order the end turns
by the sum of C dPi, C = (R_N^T R+) B, in its own frame. With gamma the price of Pi+, over h, and c
that of the end, the Lagrangian of sum |u|^2 / 2 is stationary where

    u + gamma + alpha = 0,
    h beta_k + A_k^T gamma_k - gamma_k-1 + h C_k^T c = 0,

alpha and beta being the multipliers of the bounds. The paper's zeta_0 is h^2 R_1^T R_N c. No step
is solved for: F is the turn between told attitudes. Nothing of the planner is used.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.audit.matrices import (
    hats,
    times,
    trace_minus,
    transposed,
    vee,
)

NEAR: Final = 1e-9
"""Distance from a bound, over the unit, at which it counts as reached."""


class Transfer(NamedTuple):
    """A told plan of N steps."""

    inertia: Array
    """(3, 3) [kg m^2]."""
    time_step: float
    """h [s]."""
    limits: Array
    """(4, 3) lower and upper torque, lower and upper momentum."""
    goal: Array
    """(3, 3) attitude at the end."""
    attitudes: Array
    """(N+1, 3, 3)."""
    momenta: Array
    """(N+1, 3) [N m s]."""
    torques: Array
    """(N, 3) [N m]."""
    co_momenta: Array
    """(N, 3) gamma [N m]."""
    zeta: Array
    """(3,) zeta_0 [kg m^2 N m]."""
    torque_multipliers: Array
    """(N, 3) alpha [N m]."""
    momentum_multipliers: Array
    """(N+1, 3) beta [N m/s]; none of the ends."""

    @property
    def nonstandard(self) -> Array:
        """(3, 3) Jd = tr(J) I / 2 - J."""
        return np.asarray(0.5 * np.trace(self.inertia) * np.eye(3) - self.inertia)

    @property
    def turns(self) -> Array:
        """(N, 3, 3) F of every step."""
        return transposed(self.attitudes[:-1]) @ self.attitudes[1:]

    @property
    def end_price(self) -> Array:
        """(3,) c, in the frame of the last attitude."""
        along = transposed(self.attitudes[-1]) @ self.attitudes[1]
        return np.asarray(along @ self.zeta / self.time_step**2)

    @property
    def units(self) -> tuple[float, float]:
        """Units of torque [N m] and momentum [N m s], as `docs/planner.md` has them."""
        time = len(self.torques) * self.time_step
        turned = transposed(self.attitudes[0]) @ self.goal
        angle = max(_angle(turned), 1e-2)
        moment = float(np.linalg.eigvalsh(self.inertia)[-1])
        change = float(np.linalg.norm(self.momenta[0]))  # to rest
        torque = max(6.0 * angle * moment / time**2, change / time)
        return torque, 0.25 * torque * time


class FirstOrder(NamedTuple):
    """Largest violations of the first-order conditions, over the units."""

    rotations: float
    """Of R^T R = I."""
    turns: float
    """Of the step's implicit equation, with the told attitudes and momenta."""
    branch: float
    """0 where every turn is the one of its momentum that is nearest to none, else 1."""
    momenta: float
    end_attitude: float
    """Angle to the goal [rad]."""
    end_momentum: float
    """Of rest at the end."""
    torques: float
    co_momenta: float
    bounds: float
    signs: float
    """Multipliers with the wrong sign, or of a bound that is not reached."""

    @property
    def residual(self) -> float:
        """The largest of them that a planner has to bring to zero."""
        return max(self[3:])


def first_order(plan: Transfer) -> FirstOrder:
    """Return by how much the first-order conditions are violated."""
    h, F, Jd, Pi = plan.time_step, plan.turns, plan.nonstandard, plan.momenta
    unit_u, unit_p = plan.units
    inner, (low_u, high_u, low, high) = Pi[1:-1], plan.limits
    beyond = max(_beyond(plan.torques, low_u, high_u) / unit_u, _beyond(inner, low, high) / unit_p)
    priced = np.vstack([np.zeros((1, 3)), plan.momentum_multipliers[1:-1], np.zeros((1, 3))])
    signs = max(
        _wrong(plan.torques, plan.torque_multipliers, low_u, high_u, NEAR * unit_u),
        h * _wrong(inner, priced[1:-1], low, high, NEAR * unit_p),
        h * _largest(plan.momentum_multipliers - priced),
    )
    equation = 2.0 * vee(F @ Jd) - h * Pi[:-1]
    positive = np.linalg.eigvalsh(_symmetric(trace_minus(Jd @ F)))[:, 0].min() > 0.0
    stationary = plan.torques + plan.co_momenta + plan.torque_multipliers
    moved = times(transposed(F), Pi[:-1]) + h * plan.torques
    return FirstOrder(
        rotations=_largest(transposed(plan.attitudes) @ plan.attitudes - np.eye(3)),
        turns=_largest(equation) / (h * unit_p),
        branch=0.0 if positive else 1.0,
        momenta=_largest(moved - Pi[1:]) / unit_p,
        end_attitude=_angle(transposed(plan.attitudes[-1]) @ plan.goal),
        end_momentum=_largest(Pi[-1]) / unit_p,
        torques=_largest(stationary) / unit_u,
        co_momenta=_largest(_co_momentum_gaps(plan)) / unit_u,
        bounds=max(0.0, beyond),
        signs=signs / unit_u,
    )


def linearization(plan: Transfer) -> tuple[Array, Array, Array]:
    """Return A, B and C (N, 3, 3) of the steps."""
    F = plan.turns
    A, B = _stage(plan, F, plan.momenta[:-1])
    return A, B, transposed(plan.attitudes[-1]) @ plan.attitudes[1:] @ B


def _stage(plan: Transfer, F: Array, Pi: Array) -> tuple[Array, Array]:
    """Return A and B; F and Pi may be complex, where Pi takes an imaginary step."""
    solved = np.linalg.solve(trace_minus(plan.nonstandard @ F), transposed(F))
    B = np.asarray(plan.time_step * solved)
    return np.asarray(transposed(F) + hats(times(transposed(F), Pi)) @ B), B


def _co_momentum_gaps(plan: Transfer) -> Array:
    """Return what the co-momenta's equation leaves (N-1, 3) [N m]."""
    h, gamma = plan.time_step, plan.co_momenta
    A, _, C = linearization(plan)
    flow = times(transposed(A), gamma) + h * times(transposed(C), plan.end_price)
    return np.asarray(h * plan.momentum_multipliers[1:-1] - gamma[:-1] + flow[1:])


def stage_gradients(plan: Transfer, F: Array, Pi: Array) -> Array:
    """Return (N, 3) derivatives by Pi of lambda . Pi+ + c . turn of the end, stage by stage."""
    A, B = _stage(plan, F, Pi)
    price = plan.co_momenta / plan.time_step
    pulled = times(transposed(plan.attitudes[1:]) @ plan.attitudes[-1], plan.end_price)
    return times(transposed(A), price) + times(transposed(B), pulled)


def _angle(turn: Array) -> float:
    """Return the angle of a rotation, exact near none, too."""
    sine, cosine = float(np.linalg.norm(vee(turn))), 0.5 * (float(np.trace(turn)) - 1.0)
    return float(np.arctan2(sine, cosine))


def _largest(values: Array) -> float:
    return float(np.abs(values).max(initial=0.0))


def _beyond(x: Array, low: Array, high: Array) -> float:
    return float(np.maximum(low - x, x - high).max(initial=0.0))


def _wrong(x: Array, z: Array, low: Array, high: Array, near: float) -> float:
    """Return the largest multiplier that (5.8) does not allow."""
    pulled = np.where(x - low > near, np.maximum(-z, 0.0), 0.0)
    pushed = np.where(high - x > near, np.maximum(z, 0.0), 0.0)
    return max(_largest(pulled), _largest(pushed))


def _symmetric(X: Array) -> Array:
    return np.asarray(0.5 * (X + transposed(X)))
