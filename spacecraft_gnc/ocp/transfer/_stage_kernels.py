"""Kernels of the stages of a transfer: motion, derivatives, curvature, first-order conditions.

A stage has the error eta (3) of the attitude, R exp(hat(eta)), that of the momentum, dPi (3), and
that of the torque, du (3):

    eta+ = F^T eta + B dPi,    dPi+ = A dPi + h du + gap,

with B = h F^T (tr(F Jd) I - F Jd)^-1 and A = F^T + hat(F^T Pi) B. ``lam`` (N, 3) and ``m`` (3) are
the multipliers of Pi_k+1 and, in the frame of the last attitude, of the attitude at the end.
docs/planner.md has the derivation.
"""

from __future__ import annotations

import math

from spacecraft_gnc._inner_kernels import inner_kernel
from spacecraft_gnc._kernels import kernel
from spacecraft_gnc.dynamics._lgvi_kernels import (
    body_nonstandard_inertia,
    polished,
    relative_quaternion,
    rotate_back,
    rotate_rows,
    rotation_of,
)
from spacecraft_gnc.lie._mat3_kernels import (
    add,
    cross,
    dot,
    hat,
    hat_mat,
    inverse,
    load3,
    load9_flat,
    mat_add,
    mat_mat,
    mat_scale,
    mat_t_mat,
    mat_t_vec,
    mat_vec,
    outer,
    scale,
    store3,
    store9_flat,
    sub,
    trace_minus,
    transpose,
)

PHI, B_AT, A_AT, HPP, HPE = 0, 9, 18, 27, 36  # columns of ``stage`` (N+1, 45)


@inner_kernel
def rotation_vector(E):
    """Rotation vector of E, exact up to half a turn."""
    x, y, z = 0.5 * (E[7] - E[5]), 0.5 * (E[2] - E[6]), 0.5 * (E[3] - E[1])
    sine = math.sqrt(x * x + y * y + z * z)
    if sine < 1e-8:
        return (x, y, z)
    factor = math.atan2(sine, 0.5 * (E[0] + E[4] + E[8] - 1.0)) / sine
    return (factor * x, factor * y, factor * z)


@kernel
def move(body, h, u, Pi, first, quaternions, gap):
    """Gaps F^T Pi_k + h u_k - Pi_k+1 and the rotation vector of the end; returns ok, it.

    ``first`` (9,): R_f^T R_i. Fills ``quaternions`` (N, 4) and ``gap`` (N, 3).
    """
    E = (
        first[0], first[1], first[2], first[3], first[4], first[5], first[6], first[7], first[8],
    )  # fmt: skip
    for k in range(u.shape[0]):
        p = load3(Pi, k)
        q0, q, ok = relative_quaternion(body, h, p)
        if not ok:
            return False, (0.0, 0.0, 0.0)
        quaternions[k, 0] = q0
        store3(quaternions, k, q, 1)
        E = polished(rotate_rows(q0, q, E))
        after = add(rotate_back(q0, q, p), scale(h, load3(u, k)))
        store3(gap, k, sub(after, load3(Pi, k + 1)))
    return True, rotation_vector(E)


@kernel
def linearize(body, h, Pi, quaternions, lam, m, exact, stage):
    """Derivatives Phi, B, A and, if ``exact``, curvatures Hpp and Hpe of all stages."""
    Jd = body_nonstandard_inertia(body)
    N = quaternions.shape[0]
    for k in range(N - 1, -1, -1):
        F = rotation_of(quaternions[k, 0], load3(quaternions, k, 1))
        Phi = transpose(F)
        FJd = mat_mat(F, Jd)
        Ti, _ = inverse(trace_minus(FJd))
        B = mat_scale(h, mat_mat(Phi, Ti))
        pi = mat_vec(Phi, load3(Pi, k))
        A = mat_add(Phi, hat_mat(pi, B))
        store9_flat(stage, k, Phi, PHI)
        store9_flat(stage, k, B, B_AT)
        store9_flat(stage, k, A, A_AT)
        if exact:
            la = load3(lam, k)
            v = scale(1.0 / h, mat_t_vec(B, add(m, cross(la, pi))))
            K = mat_mat(mat_mat(Jd, hat(v)), F)
            trace, lp = K[0] + K[4] + K[8], dot(la, pi)
            pl = outer(pi, la)
            d = trace + lp
            C = (
                K[0] + pl[0] - d, 0.5 * (K[1] + K[3] + pl[1] + pl[3]),
                0.5 * (K[2] + K[6] + pl[2] + pl[6]),
                0.5 * (K[1] + K[3] + pl[1] + pl[3]), K[4] + pl[4] - d,
                0.5 * (K[5] + K[7] + pl[5] + pl[7]),
                0.5 * (K[2] + K[6] + pl[2] + pl[6]), 0.5 * (K[5] + K[7] + pl[5] + pl[7]),
                K[8] + pl[8] - d,
            )  # fmt: skip
            Q = mat_t_mat(B, hat_mat(la, Phi))
            H = mat_add(mat_add(mat_t_mat(B, mat_mat(C, B)), Q), transpose(Q))
            store9_flat(stage, k, H, HPP)
            store9_flat(stage, k, mat_scale(0.5, mat_t_mat(B, hat_mat(m, Phi))), HPE)
        else:
            for j in range(HPP, HPE + 9):
                stage[k, j] = 0.0
        m = mat_vec(F, m)


@inner_kernel
def first_order(h, u, lam, m, zu, zp, stage, ru, rp):
    """Residuals of (3.13) into ``ru`` (N, 3) and of (4.11) into ``rp`` (N+1, 3), torque units.

    ``zu`` (N, 3), ``zp`` (N+1, 3): multipliers of the bounds, positive at upper ones. Returns the
    largest of each.
    """
    N = u.shape[0]
    worst_u, worst_p = 0.0, 0.0
    for k in range(N - 1, -1, -1):
        la = load3(lam, k)
        x = add(add(load3(u, k), scale(h, la)), load3(zu, k))
        store3(ru, k, x)
        worst_u = max(worst_u, abs(x[0]), abs(x[1]), abs(x[2]))
        if k > 0:
            A, B = load9_flat(stage, k, A_AT), load9_flat(stage, k, B_AT)
            y = sub(add(mat_t_vec(A, la), mat_t_vec(B, m)), load3(lam, k - 1))
            y = scale(h, add(y, load3(zp, k)))
            store3(rp, k, y)
            worst_p = max(worst_p, abs(y[0]), abs(y[1]), abs(y[2]))
        m = mat_t_vec(load9_flat(stage, k, PHI), m)
    return worst_u, worst_p
