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
    sub,
    trace_minus,
    vee_antisymmetric,
)

# Offsets into ``data``; S = (tr(Q) I - Q)/2 turns |Q^(1/2) hat(a)|_F^2 / 2 into a . S a. The m
# controls are counted in the eigenvectors V of their weight S3 = V diag(d) V^T: z = V^T u, and
# torque = G^T z with the rows of G = V^T B^T. From D_U on stand d (m), then G (m x 3).
H, ALPHA, MU0 = 0, 1, 2
Q1, P1, S_Q2, S_P2, M_U, D_U = 3, 12, 21, 30, 39, 40
# Offsets into a row of the work array W: F, M, A = F^T + hat(p) M, p = F^T Pi, sigma, then z.
M_AT, A_AT, P_AT, SIGMA_AT, Z_AT = 9, 18, 27, 30, 31
# Columns of a row of ``zones``: body axis v, inertial axis d, cosine, sign (+1 exclusion), weight.
ZONE_SIZE = 9


def work_size(m: int) -> int:
    """Columns of W for m controls."""
    return Z_AT + m


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
def _secular(data, W, k, sigma):
    """Find sigma >= 0 with |z|^2 = alpha + sigma / (2 mu0), z_i = y_i / (d_i + sigma), y in W.

    Newton on 1/|z| = 1/sqrt(alpha + sigma/(2 mu0)): nearly linear, and free of cancellation.
    """
    alpha, mu0 = data[ALPHA], data[MU0]
    m = int(data[M_U])
    for _ in range(50):
        zz, bend = 0.0, 0.0
        for i in range(m):
            d = data[D_U + i] + sigma
            z = W[k, Z_AT + i] / d
            zz += z * z
            bend += z * z / d
        norm = math.sqrt(zz)
        bound = alpha + sigma / (2.0 * mu0)
        root = math.sqrt(bound)
        change = (1.0 / root - 1.0 / norm) / (bend / (zz * norm) + 0.25 / (mu0 * bound * root))
        sigma = max(0.0, sigma + change)
        if abs(change) <= 1e-9 * (1.0 + sigma):
            break
    return sigma


@kernel
def control(data, lam2, W, k):
    """Solve (38), (S3 + sigma I) u = B^T lam2 with sigma = 2 mu0 max(0, |u|^2 - alpha).

    The linear equation is tried first, as Bagherzadeh et al. (41) do. Leaves z = V^T u in row k of
    W; returns the torque B u and sigma.
    """
    m = int(data[M_U])
    alpha = data[ALPHA]
    yy, zz, d_max = 0.0, 0.0, 0.0
    for i in range(m):
        d, g = data[D_U + i], D_U + m + 3 * i
        y = data[g] * lam2[0] + data[g + 1] * lam2[1] + data[g + 2] * lam2[2]
        W[k, Z_AT + i] = y
        yy += y * y
        zz += (y / d) * (y / d)
        d_max = max(d_max, d)
    sigma = 0.0
    if alpha > 0.0 and zz > alpha and math.isfinite(yy):
        sigma = _secular(data, W, k, max(0.0, math.sqrt(yy / alpha) - d_max))
    tau = (0.0, 0.0, 0.0)
    for i in range(m):
        z, g = W[k, Z_AT + i] / (data[D_U + i] + sigma), D_U + m + 3 * i
        W[k, Z_AT + i] = z
        tau = add(tau, scale(z, (data[g], data[g + 1], data[g + 2])))
    return tau, sigma


@kernel
def control_sensitivity(data, W, k, estimated):
    """Matrix U of delta torque = U delta lam2 = B (S3 + sigma I + 4 mu0 u u^T if active)^-1 B^T.

    Source: Bagherzadeh et al. (33), corrected (see `shooting`); ``estimated``: its (40), without
    what the limit adds.
    """
    m = int(data[M_U])
    sigma = 0.0 if estimated else W[k, SIGMA_AT]
    U = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    turned, size = (0.0, 0.0, 0.0), 0.25 / data[MU0]
    for i in range(m):
        g, w = D_U + m + 3 * i, 1.0 / (data[D_U + i] + sigma)
        row = (data[g], data[g + 1], data[g + 2])
        U = mat_add(U, outer(scale(w, row), row))
        if sigma > 0.0:
            z = W[k, Z_AT + i]
            turned = add(turned, scale(w * z, row))
            size += w * z * z
    if sigma > 0.0:
        U = mat_sub(U, outer(scale(1.0 / size, turned), turned))
    return U


@kernel
def attitude_gradient(h, B_Q1, zones, R):
    """Gradient g_R of the stage cost and zone penalties at R, so that (34) is F^T (lam1 + g_R).

    Returns g_R and the number of zones whose penalty acts.
    """
    g = scale(-h, vee_antisymmetric(mat_t_mat(R, B_Q1)))
    active = 0
    for i in range(zones.shape[0]):
        v = (zones[i, 0], zones[i, 1], zones[i, 2])
        a = mat_t_vec(R, (zones[i, 3], zones[i, 4], zones[i, 5]))
        excess = zones[i, 7] * (dot(v, a) - zones[i, 6])
        if excess > 0.0:
            g = add(g, scale(h * zones[i, 8] * excess * zones[i, 7], cross(v, a)))
            active += 1
    return g, active


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
    """Fill ``track`` (27,) with Q1 R_ref, P1 R_ref and R_ref: (27), (28) measured from R_ref."""
    stage, terminal = mat_mat(data9(data, Q1), R_ref), mat_mat(data9(data, P1), R_ref)
    for i in range(9):
        track[i], track[9 + i], track[18 + i] = stage[i], terminal[i], R_ref[i]


@kernel
def attitude_cost(Q, R_ref, R):
    """|Q^(1/2) (R - R_ref)|_F^2 / 2, by the difference: accurate however close the two are."""
    D = mat_sub(R, R_ref)
    QD = mat_mat(Q, D)
    total = 0.0
    for i in range(9):
        total += D[i] * QD[i]
    return 0.5 * total


@kernel
def squared_control(W, k):
    """Squared norm |u_k|^2 = |z_k|^2 of the controls of stage k."""
    zz = 0.0
    for i in range(Z_AT, W.shape[1]):
        zz += W[k, i] * W[k, i]
    return zz


@kernel
def stage_cost(data, zones, R_ref, R_k, Pi_k, W, k):
    """Cost of stage k, (27) and penalties h mu max(0, H)^2, with z and sigma from row k of W."""
    h, alpha, mu0 = data[H], data[ALPHA], data[MU0]
    m = int(data[M_U])
    effort, zz = 0.0, 0.0
    for i in range(m):
        z = W[k, Z_AT + i]
        zz += z * z
        effort += data[D_U + i] * z * z
    state = attitude_cost(data9(data, Q1), R_ref, R_k) + quadratic(data9(data, S_Q2), Pi_k)
    total = h * (state + effort) + zone_cost(h, zones, R_k)
    if alpha > 0.0:
        # A solve knows sigma = 2 mu0 H0 without cancellation; a bare rollout has sigma < 0.
        sigma = W[k, SIGMA_AT]
        H0 = sigma / (2.0 * mu0) if sigma >= 0.0 else max(0.0, zz - alpha)
        total += h * mu0 * H0 * H0
    return total


@kernel
def terminal_cost(data, track, R_N, Pi_N):
    """Terminal cost (28)."""
    attitude = attitude_cost(data9(data, P1), data9(track, 18), R_N)
    return attitude + quadratic(data9(data, S_P2), Pi_N)


@kernel
def horizon_cost(data, zones, track, R, Pi, W):
    """Cost (27) + (28) + penalties of a propagated horizon."""
    N = W.shape[0]
    R_ref = data9(track, 18)
    total = terminal_cost(data, track, load9(R, N), load3(Pi, N))
    for k in range(N):
        total += stage_cost(data, zones, R_ref, load9(R, k), load3(Pi, k), W, k)
    return total
