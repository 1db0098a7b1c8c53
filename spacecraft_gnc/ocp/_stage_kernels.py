"""Kernels of one stage of the horizon: control law, dynamics, costate and cost terms of Gupta 2015.

Letters follow the paper (`docs/notation.md`). The multipliers lam1, lam2 are half the true ones,
as the paper's pairing makes them. ``data`` is packed by `problem.AttitudeOcp`: see the offsets.
"""

from __future__ import annotations

import math

from spacecraft_gnc._kernels import kernel
from spacecraft_gnc.lie._mat3_kernels import (
    add,
    cross,
    dot,
    hat,
    hat_mat,
    inverse,
    load3,
    load9,
    mat_add,
    mat_mat,
    mat_scale,
    mat_sub,
    mat_t_mat,
    mat_t_vec,
    mat_vec,
    outer,
    scale,
    store9,
    sub,
    trace_minus,
    transpose,
    vee_antisymmetric,
)

# Offsets into ``data``; S = (tr(Q) I - Q)/2 turns |Q^(1/2) hat(a)|_F^2 / 2 into a . S a.
H, ALPHA, MU0 = 0, 1, 2
Q1, P1, S_Q2, S_P2, V_Q3, D_Q3 = 3, 12, 21, 30, 39, 48
DATA_SIZE = 51
# Offsets into a row of the work array W: F first, then M, p = F^T Pi, sigma.
WORK, M_AT, P_AT, SIGMA_AT = 22, 9, 18, 21
# Columns of a row of ``zones``: body axis v, inertial axis d, cosine, sign (+1 exclusion), weight.
ZONE_SIZE = 9


@kernel
def data9(data, i):
    """Nine consecutive numbers of ``data``."""
    return (
        data[i], data[i + 1], data[i + 2], data[i + 3], data[i + 4],
        data[i + 5], data[i + 6], data[i + 7], data[i + 8],
    )  # fmt: skip


@kernel
def quadratic(S, x):
    """Value x . S x."""
    return dot(x, mat_vec(S, x))


@kernel
def control(data, lam2):
    """Solve (38), (S3 + sigma I) u = lam2 with sigma = 2 mu0 max(0, |u|^2 - alpha); (u, sigma)."""
    V = data9(data, V_Q3)
    d0, d1, d2 = data[D_Q3], data[D_Q3 + 1], data[D_Q3 + 2]
    alpha, mu0 = data[ALPHA], data[MU0]
    y = mat_t_vec(V, lam2)
    z = (y[0] / d0, y[1] / d1, y[2] / d2)
    if alpha <= 0.0 or dot(z, z) <= alpha or not math.isfinite(dot(y, y)):
        return mat_vec(V, z), 0.0
    # Secular equation 1/|u(sigma)| = 1/sqrt(alpha + sigma/(2 mu0)): nearly linear, no cancellation.
    d_max = max(d0, d1, d2)
    sigma = max(0.0, math.sqrt(dot(y, y) / alpha) - d_max)
    for _ in range(50):
        z = (y[0] / (d0 + sigma), y[1] / (d1 + sigma), y[2] / (d2 + sigma))
        norm = math.sqrt(dot(z, z))
        slope = z[0] * z[0] / (d0 + sigma) + z[1] * z[1] / (d1 + sigma) + z[2] * z[2] / (d2 + sigma)
        bound = alpha + sigma / (2.0 * mu0)
        root = math.sqrt(bound)
        value = 1.0 / root - 1.0 / norm
        change = value / (slope / (norm * norm * norm) + 0.25 / (mu0 * bound * root))
        sigma = max(0.0, sigma + change)
        if abs(change) <= 1e-9 * (d_max + sigma):
            break
    z = (y[0] / (d0 + sigma), y[1] / (d1 + sigma), y[2] / (d2 + sigma))
    return mat_vec(V, z), sigma


@kernel
def control_sensitivity(data, u, sigma):
    """Matrix U of delta u = U delta lam2: inverse of S3 + sigma I (+ 4 mu0 u u^T if active)."""
    V = data9(data, V_Q3)
    w0 = 1.0 / (data[D_Q3] + sigma)
    w1 = 1.0 / (data[D_Q3 + 1] + sigma)
    w2 = 1.0 / (data[D_Q3 + 2] + sigma)
    VD = (
        V[0] * w0, V[1] * w1, V[2] * w2,
        V[3] * w0, V[4] * w1, V[5] * w2,
        V[6] * w0, V[7] * w1, V[8] * w2,
    )  # fmt: skip
    U = mat_mat(VD, transpose(V))
    if sigma > 0.0:
        Wu = mat_vec(U, u)
        U = mat_sub(U, mat_scale(1.0 / (0.25 / data[MU0] + dot(u, Wu)), outer(Wu, Wu)))
    return U


@kernel
def attitude_gradient(h, B_Q1, zones, R):
    """Gradient g_R of the stage cost and zone penalties at R, so that (34) is F^T (lam1 + g_R)."""
    g = scale(-h, vee_antisymmetric(mat_t_mat(R, B_Q1)))
    for i in range(zones.shape[0]):
        v = (zones[i, 0], zones[i, 1], zones[i, 2])
        a = mat_t_vec(R, (zones[i, 3], zones[i, 4], zones[i, 5]))
        excess = zones[i, 7] * (dot(v, a) - zones[i, 6])
        if excess > 0.0:
            g = add(g, scale(h * zones[i, 8] * excess * zones[i, 7], cross(v, a)))
    return g


@kernel
def attitude_hessian(h, B_Q1, zones, R):
    """Matrix G_R with delta g_R = G_R eta for R exp(hat(eta))."""
    G = mat_scale(0.5 * h, trace_minus(mat_t_mat(R, B_Q1)))
    for i in range(zones.shape[0]):
        v = (zones[i, 0], zones[i, 1], zones[i, 2])
        a = mat_t_vec(R, (zones[i, 3], zones[i, 4], zones[i, 5]))
        sign = zones[i, 7]
        excess = sign * (dot(v, a) - zones[i, 6])
        if excess > 0.0:
            n = cross(v, a)
            bend = mat_scale(sign * excess, mat_mat(hat(v), hat(a)))
            G = mat_add(G, mat_scale(h * zones[i, 8], mat_add(outer(n, n), bend)))
    return G


@kernel
def zone_cost(h, zones, R):
    """Sum of the zone penalties h mu max(0, H_i)^2 at R."""
    total = 0.0
    for i in range(zones.shape[0]):
        v = (zones[i, 0], zones[i, 1], zones[i, 2])
        a = mat_t_vec(R, (zones[i, 3], zones[i, 4], zones[i, 5]))
        excess = zones[i, 7] * (dot(v, a) - zones[i, 6])
        if excess > 0.0:
            total += h * zones[i, 8] * excess * excess
    return total


@kernel
def costate_curvature(h, S2, Jd, F, M, A, lam1, lam2, p):
    """Matrix Z with delta lam2 = C^-1 (delta lam2_prev - M^T delta lam1 + Z delta Pi), C = A^T.

    It collects delta g_Pi, and the changes of F, M and p in (36) at fixed multipliers.
    """
    w = sub(lam1, cross(p, lam2))
    z = mat_t_vec(F, scale(1.0 / h, mat_t_vec(M, w)))  # F^T y, y = G^-T F w = M^T w / h
    FtJd = mat_t_mat(F, Jd)
    tau = scale(2.0, vee_antisymmetric(FtJd))
    K = mat_sub(mat_mat(FtJd, hat(z)), mat_add(hat(w), outer(z, tau)))
    bent = mat_add(mat_mat(K, M), hat_mat(lam2, A))
    Z = mat_sub(mat_mat(F, hat_mat(lam2, M)), mat_t_mat(M, bent))
    return mat_add(mat_scale(h, S2), Z)


@kernel
def momentum_map(h, Jd, F):
    """Fact 2: M = h F^T (tr(F Jd) I - F Jd)^-1, so that F^T delta F = hat(M delta Pi); (M, det)."""
    G_inverse, det = inverse(trace_minus(mat_mat(F, Jd)))
    return mat_scale(h, mat_t_mat(F, G_inverse)), det


@kernel
def set_track(data, R_ref, track):
    """Fill ``track`` (2,3,3) with Q1 R_ref and P1 R_ref: (27), (28) measured from R_ref."""
    store9(track, 0, mat_mat(data9(data, Q1), R_ref))
    store9(track, 1, mat_mat(data9(data, P1), R_ref))


@kernel
def attitude_cost(Q, B, R):
    """|Q^(1/2) (R - R_ref)|_F^2 / 2 = tr(Q) - <Q R_ref, R> with B = Q R_ref."""
    total = Q[0] + Q[4] + Q[8]
    for i in range(9):
        total -= B[i] * R[i]
    return total


@kernel
def horizon_cost(data, zones, track, R, Pi, u, W):
    """Cost (27) + (28) + penalties h mu max(0, H)^2 of a propagated horizon."""
    N = u.shape[0]
    h, alpha, mu0 = data[H], data[ALPHA], data[MU0]
    S2, V, Q = data9(data, S_Q2), data9(data, V_Q3), data9(data, Q1)
    B = load9(track, 0)
    total = 0.0
    for k in range(N):
        R_k, u_k = load9(R, k), load3(u, k)
        y = mat_t_vec(V, u_k)
        effort = 0.0
        for i in range(3):
            effort += data[D_Q3 + i] * y[i] * y[i]
        total += h * (attitude_cost(Q, B, R_k) + quadratic(S2, load3(Pi, k)) + effort)
        total += zone_cost(h, zones, R_k)
        if alpha > 0.0:
            # A solve knows sigma = 2 mu0 H0 without cancellation; a bare rollout has sigma < 0.
            sigma = W[k, SIGMA_AT]
            H0 = sigma / (2.0 * mu0) if sigma >= 0.0 else max(0.0, dot(u_k, u_k) - alpha)
            total += h * mu0 * H0 * H0
    total += attitude_cost(data9(data, P1), load9(track, 1), load9(R, N))
    return total + quadratic(data9(data, S_P2), load3(Pi, N))
