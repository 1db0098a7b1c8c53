"""Second derivatives of the cost of plans, stage by stage, and a Newton step by them.

The costates change by delta lambda_k = -V_k delta x_{k+1}: V is swept backward through (39), with
the answer U of each torque to lambda2. Source: Bagherzadeh et al. (2023), (26)-(33).
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.audit import logarithm
from spacecraft_gnc.vehicles.rigid_body.audit.conditions import Stages, attitude_curvature
from spacecraft_gnc.vehicles.rigid_body.audit.matrices import (
    hats,
    times,
    trace_minus,
    transposed,
    vee,
)
from spacecraft_gnc.vehicles.rigid_body.audit.problem import Problem, nonstandard

STATE_ROUNDING: Final = 1e3 * 2.0**-52  # [rad], and relative to the largest momentum of a plan


class Factors(NamedTuple):
    """The linearized conditions of plans (m), each (m, N, 3, 3)."""

    U: Array
    """Answer of the torque to lambda2."""
    S_inverse: Array
    """(I + h V22 U)^-1."""
    K1: Array
    K2: Array
    """S^-1 (V A)_2: answer of lambda2 to (eta, delta Pi)."""
    L1: Array
    L2: Array
    """h V_{:,2} U."""


def factors_of(problem: Problem, s: Stages, lam: Array, sigma: Array, share: Array) -> Factors:
    """Sweep V backward."""
    h, eye, N = problem.ocp.time_step, np.eye(3), s.u.shape[1]
    V11, V12, V21, V22 = _end(problem, s, share)
    found = Factors(*(np.empty(s.F.shape) for _ in Factors._fields))
    for k in range(N - 1, -1, -1):
        U = _answer(problem, s.u[:, k], sigma[:, k])
        F, M, A = s.F[:, k], s.M[:, k], s.A[:, k]
        L1, L2 = h * V12 @ U, h * V22 @ U
        with np.errstate(all="ignore"):
            S_inverse = _inverse(eye + L2)
        Y11, Y12 = V11 @ transposed(F), V11 @ M + V12 @ A
        Y21, Y22 = V21 @ transposed(F), V21 @ M + V22 @ A
        K1, K2 = S_inverse @ Y21, S_inverse @ Y22
        for array, value in zip(found, (U, S_inverse, K1, K2, L1, L2), strict=True):
            array[:, k] = value
        if k > 0:
            X11, X12 = Y11 - L1 @ K1, Y12 - L1 @ K2
            X21, X22 = Y21 - L2 @ K1, Y22 - L2 @ K2
            l1, l2 = lam[:, k, :3], lam[:, k, 3:]
            V11 = F @ X11 + attitude_curvature(problem, s.R[:, k], s.track.attitudes[:, k])
            V12 = F @ (X12 + hats(l1) @ M)
            V21 = transposed(M) @ X11 + transposed(A) @ X21
            V22 = (
                transposed(M) @ X12 + transposed(A) @ X22 + _stage_curvature(problem, s, k, l1, l2)
            )
    return found


def smallest_pivot(problem: Problem, found: Factors) -> Array:
    """Return the (m,) smallest eigenvalues of the pivots of the torques' second derivative.

    A pivot has all later stages optimal; the Hessian is definite exactly where all are positive.
    """
    Q = 0.5 / problem.ocp.time_step * found.U @ found.S_inverse
    values = np.linalg.eigvalsh(np.nan_to_num(0.5 * (Q + transposed(Q)), posinf=0.0, neginf=0.0))
    lowest, highest = values[..., 0], values[..., 2]
    S = found.S_inverse  # gives the sign: an inverse near zero, as of no actuator, has either
    minors = 0.5 * (np.trace(S, axis1=-2, axis2=-1) ** 2 - np.sum(S * transposed(S), axis=(-2, -1)))
    definite = (np.linalg.det(S) > 0.0) & (np.trace(S, axis1=-2, axis2=-1) > 0.0) & (minors > 0.0)
    with np.errstate(divide="ignore"):
        pivots = np.where((lowest > 0.0) | definite, 1.0 / highest, -np.abs(1.0 / lowest))
    return np.asarray(pivots.min(axis=1))


def correction(problem: Problem, s: Stages, found: Factors, left: Array) -> Array:
    """Return the (m,) largest changes of a lambda2 by one Newton step from the plan.

    But for what a change of the state by `STATE_ROUNDING` makes, component by component.
    """
    h, m, N = problem.ocp.time_step, *left.shape[:2]
    step, v1, v2 = np.empty(left.shape), np.zeros((m, 3)), np.zeros((m, 3))
    for k in range(N - 1, -1, -1):
        y = times(found.S_inverse[:, k], left[:, k] - v2)
        step[:, k] = y
        w1, w2 = v1 + times(found.L1[:, k], y), v2 + times(found.L2[:, k], y)
        v1 = times(s.F[:, k], w1)
        v2 = times(transposed(s.M[:, k]), w1) + times(transposed(s.A[:, k]), w2)
    eta, d_Pi, largest = np.zeros((m, 3)), np.zeros((m, 3)), np.zeros(m)
    fastest = np.linalg.norm(s.Pi, axis=2).max(axis=1)
    for k in range(N):
        y = step[:, k] - times(found.K1[:, k], eta) - times(found.K2[:, k], d_Pi)
        rounding = np.abs(found.K1[:, k]).sum(axis=2)
        rounding += fastest[:, None] * np.abs(found.K2[:, k]).sum(axis=2)
        largest = np.fmax(largest, (np.abs(y) - STATE_ROUNDING * rounding).max(axis=1))
        du = times(found.U[:, k], y)
        eta = times(transposed(s.F[:, k]), eta) + times(s.M[:, k], d_Pi)
        d_Pi = times(s.A[:, k], d_Pi) + h * du
    return largest


def _answer(problem: Problem, u: Array, sigma: Array) -> Array:
    """Return U = B (W + sigma I + 4 mu0 u u^T where the limit acts)^-1 B^T, (m, 3, 3)."""
    B, m = problem.ocp.torque_map, u.shape[1]
    inverse: Array = np.asarray(
        np.linalg.inv(problem.control + sigma[:, None, None] * np.eye(m)), dtype=np.float64
    )
    turned = times(inverse, u)
    acts = np.zeros(len(u))
    if problem.limit > 0.0:
        size = 0.25 / problem.penalty + np.sum(u * turned, axis=1)
        acts = np.divide(1.0, size, out=acts, where=sigma > 0.0)
    inverse = inverse - acts[:, None, None] * turned[:, :, None] * turned[:, None, :]
    return np.asarray(B @ inverse @ B.T)


def _end(problem: Problem, s: Stages, share: Array) -> tuple[Array, Array, Array, Array]:
    """Return the blocks of V at the end of plans."""
    R_ref = s.track.attitudes[:, -1]
    if problem.end is None:
        V11 = 0.5 * trace_minus(transposed(s.R[:, -1]) @ problem.end_attitude @ R_ref)
        zero = np.zeros(V11.shape)
        return V11, zero, zero, np.broadcast_to(problem.end_momentum, V11.shape)
    Z = logarithm.continuous(transposed(R_ref)[:, None] @ s.R)
    L, P = logarithm.derivative(Z), share[:, None, None] * problem.end
    y = times(P[:, :3, :3], Z) + times(P[:, :3, 3:], s.Pi[:, -1])
    V11 = (transposed(L) @ P[:, :3, :3] + logarithm.curvature(Z, y)) @ L
    return 0.5 * V11, 0.5 * transposed(L) @ P[:, :3, 3:], 0.5 * P[:, 3:, :3] @ L, 0.5 * P[:, 3:, 3:]


def _stage_curvature(problem: Problem, s: Stages, k: int, l1: Array, l2: Array) -> Array:
    """Return Z with delta lambda2 = A^-T (delta lambda2_prev - M^T delta lambda1 + Z delta Pi).

    It collects the cost of the momentum and of the rate, and the changes of F, M and p in (36).
    """
    h, F, M, A, p = problem.ocp.time_step, s.F[:, k], s.M[:, k], s.A[:, k], s.p[:, k]
    pushed = l1 - vee(problem.rate @ F)
    w = pushed - np.cross(p, l2)
    z = times(transposed(F), times(transposed(M), w)) / h
    FtJd = transposed(F) @ nonstandard(problem)
    K = FtJd @ hats(z) - hats(w) - z[:, :, None] * (2.0 * vee(FtJd))[:, None, :]
    bent = K @ M + hats(l2) @ A
    rated = 0.5 * transposed(M) @ trace_minus(transposed(F) @ problem.rate) @ M
    return np.asarray(h * problem.momentum + F @ hats(l2) @ M - transposed(M) @ bent + rated)


def _inverse(S: Array) -> Array:
    """Return the inverses of (m, 3, 3) matrices; of a singular one, infinities."""
    adjugate = np.stack(
        [np.cross(S[:, :, 1], S[:, :, 2]), np.cross(S[:, :, 2], S[:, :, 0]),
         np.cross(S[:, :, 0], S[:, :, 1])], axis=1,
    )  # fmt: skip
    return np.asarray(adjugate / np.linalg.det(S)[:, None, None])
