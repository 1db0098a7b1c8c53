"""The problem in CasADi, in the states that suit direct methods best; for several peers.

State (q, Pi): vector part of the attitude's unit quaternion and the angular momentum. For scalar
weights |Q^(1/2) (R - I)|_F^2 / 2 = 4 Q q.q, so the whole cost is a sum of squares of states and
controls. The implicit step 2 q0 J q + 2 q x (J q) = h Pi of the integrator reads, with g = q / q0,
J g + g x J g = (1 + g.g) h Pi / 2: a polynomial, solved by unrolled Newton steps.
"""

from __future__ import annotations

import casadi as ca
from common import Problem

NEWTON_STEPS = 2  # unrolled; the third changes nothing beyond 1e-15 along Case I


def relative_rodrigues(problem: Problem, momentum: ca.SX) -> ca.SX:
    """Return g of the relative rotation F of one step."""
    inertia = ca.DM(problem.inertia)
    b = 0.5 * problem.time_step * momentum
    g = ca.inv(inertia) @ b
    for _ in range(NEWTON_STEPS):
        Jg = inertia @ g
        residual = Jg + ca.cross(g, Jg) - (1 + ca.dot(g, g)) * b
        slope = inertia + ca.skew(g) @ inertia - ca.skew(Jg) - 2 * b @ g.T
        g = g - _inverse(slope) @ residual
    return g


def step(problem: Problem, state: ca.SX, torque: ca.SX) -> ca.SX:
    """Return the state after one step of the integrator: R F, F^T Pi + h u."""
    q, momentum = state[:3], state[3:]
    inertia = ca.DM(problem.inertia)
    g = relative_rodrigues(problem, momentum)
    square = 1 + ca.dot(g, g)
    scalar = ca.sqrt(1 - ca.dot(q, q))
    turned = (q + scalar * g + ca.cross(q, g)) / ca.sqrt(square)
    # F^T Pi reverses the sign of g: h F^T Pi / 2 = (J g - g x J g) / (1 + g.g).
    rotated = momentum - 4 / (problem.time_step * square) * ca.cross(g, inertia @ g)
    return ca.vertcat(turned, rotated + problem.time_step * torque)


def stage_cost(problem: Problem, state: ca.SX, torque: ca.SX) -> ca.SX:
    """Return (28) of one stage, without the penalty."""
    q, momentum = state[:3], state[3:]
    states = 4 * problem.stage_attitude * ca.dot(q, q)
    states += problem.stage_momentum * ca.dot(momentum, momentum)
    return problem.time_step * (states + problem.stage_torque * ca.dot(torque, torque))


def terminal_cost(problem: Problem, state: ca.SX) -> ca.SX:
    """Return (27)."""
    q, momentum = state[:3], state[3:]
    attitude = 4 * problem.terminal_attitude * ca.dot(q, q)
    return attitude + problem.terminal_momentum * ca.dot(momentum, momentum)


def penalty(problem: Problem, torque: ca.SX) -> ca.SX:
    """Return the penalty of the torque limit in one stage."""
    excess = ca.fmax(0, ca.dot(torque, torque) - problem.max_torque**2)
    return problem.time_step * problem.torque_penalty * excess**2


def _inverse(m: ca.SX) -> ca.SX:
    """Adjugate over determinant, far smaller than the general symbolic inverse."""
    a, b, c = m[0, :].T, m[1, :].T, m[2, :].T
    columns = ca.horzcat(ca.cross(b, c), ca.cross(c, a), ca.cross(a, b))
    return columns / ca.dot(a, ca.cross(b, c))
