"""Kernels of one stage of the horizon: control law, dynamics, costate and cost terms of Gupta 2015.

Letters follow the paper (`docs/notation.md`). The multipliers lam1, lam2 are half the true ones,
as the paper's pairing makes them. ``data`` is laid out in `_data_kernels`.
"""

from __future__ import annotations

import math

from spacecraft_gnc._inner_kernels import inlined_inner_kernel, inner_kernel
from spacecraft_gnc._kernels import inlined_kernel, kernel
from spacecraft_gnc.lie._mat3_kernels import (
    add,
    cross,
    dot,
    hat,
    hat_mat,
    inverse,
    load3,
    load9,
    load9_flat,
    mat_add,
    mat_mat,
    mat_scale,
    mat_sub,
    mat_t_mat,
    mat_t_vec,
    outer,
    scale,
    sub,
    trace_minus,
    vee_antisymmetric,
)
from spacecraft_gnc.ocp._data_kernels import (
    ALPHA,
    D_U,
    LOG_FORM,
    M_U,
    MU0,
    S_Q2,
    H,
    data9,
    quadratic,
)
from spacecraft_gnc.ocp._terminal_kernels import (
    rate_cost,
    rate_gradient,
    rate_hessian,
    stage_attitude_cost,
    terminal_cost,
)
from spacecraft_gnc.ocp._track_kernels import (
    control_reference,
    stage_momentum,
    stage_reference,
)

# Offsets into a row of the work array W: F, M, A = F^T + hat(p) M, p = F^T Pi, sigma, then z.
M_AT, A_AT, P_AT, SIGMA_AT, Z_AT = 9, 18, 27, 30, 31
# Columns of a row of ``zones``: body axis v, inertial axis d, cosine, sign (+1 exclusion), weight.
ZONE_SIZE = 9
# From far below, where the limit is soft, sigma at least triples in a step.
SECULAR_STEPS = 100
_MULTIPLIER, _LOW_63 = 0x1E3779B97F4A7C15, 2**63 - 1  # odd; the mask keeps a hash an int64


def work_size(m: int) -> int:
    """Columns of W for m controls."""
    return Z_AT + m


@inner_kernel
def _secular(data, W, k, sigma):
    """Find sigma >= 0 with |z|^2 = alpha + sigma / (2 mu0), z_i = y_i / (d_i + sigma), y in W.

    Newton on 1/|z| = 1/sqrt(alpha + sigma/(2 mu0)): nearly linear, and free of cancellation. The
    difference of its sides is convex and falls in sigma, so that Newton converges from anywhere; at
    a step of 1e-9 of the shorter length over which a side bends, the next one is below rounding.
    """
    alpha, mu0 = data[ALPHA], data[MU0]
    m = int(data[M_U])
    for _ in range(SECULAR_STEPS):
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
        # d is sorted; either side bends over a length of its own.
        if abs(change) <= 1e-9 * min(data[D_U] + sigma, 2.0 * mu0 * alpha + sigma):
            break
    return sigma


@inlined_kernel
def control(data, track, lam2, W, k):
    """Solve (38), (S3 + sigma I) u = B^T lam2 + S3 u_ref, sigma = 2 mu0 max(0, |u|^2 - alpha).

    The linear equation is tried first, as Bagherzadeh et al. (41) do. Leaves z = V^T u in row k of
    W; returns the torque B u and sigma.
    """
    m = int(data[M_U])
    alpha = data[ALPHA]
    yy, zz, d_max = 0.0, 0.0, 0.0
    for i in range(m):
        d, g = data[D_U + i], D_U + m + 3 * i
        y = data[g] * lam2[0] + data[g + 1] * lam2[1] + data[g + 2] * lam2[2]
        y -= d * (0.0 - control_reference(track, m, i))  # a sum with +0 would turn -0 into +0
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


@inlined_kernel
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
def hashed(pattern, number):
    """Append a number, or another hash, to a hash of 63 bits; the same compiled and interpreted.

    Two given sequences share a hash with a probability of about 1e-19. The hash is mixed before
    the number comes in, so that a hash that is appended to itself does not cancel.
    """
    pattern = (pattern * _MULTIPLIER) & _LOW_63
    pattern = ((pattern ^ (pattern >> 32) ^ number) * _MULTIPLIER) & _LOW_63
    return pattern ^ (pattern >> 32)


@inlined_inner_kernel
def attitude_gradient(h, B_Q1, zones, R):
    """Gradient g_R of the stage cost and zone penalties at R, so that (34) is F^T (lam1 + g_R).

    Returns g_R and a hash of the zones whose penalty acts, zero for none.
    """
    g = scale(-h, vee_antisymmetric(mat_t_mat(R, B_Q1)))
    active = 0
    for i in range(zones.shape[0]):
        v = (zones[i, 0], zones[i, 1], zones[i, 2])
        a = mat_t_vec(R, (zones[i, 3], zones[i, 4], zones[i, 5]))
        excess = zones[i, 7] * (dot(v, a) - zones[i, 6])
        if excess > 0.0:
            g = add(g, scale(h * zones[i, 8] * excess * zones[i, 7], cross(v, a)))
            active = hashed(active, i + 1)
    return g, active


@inlined_inner_kernel
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


@inner_kernel
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


@inlined_inner_kernel
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


@inlined_inner_kernel
def stage_curvature(data, Jd, W, k, lam1, lam2):
    """`costate_curvature` of stage k, with what a cost of the rate adds in the log form."""
    h, S2 = data[H], data9(data, S_Q2)
    F, M = load9_flat(W, k), load9_flat(W, k, M_AT)
    A, p = load9_flat(W, k, A_AT), load3(W, k, P_AT)
    rated = data[LOG_FORM] > 0.0
    pushed = sub(lam1, rate_gradient(data, F)) if rated else lam1
    Z = costate_curvature(h, S2, Jd, F, M, A, pushed, lam2, p)  # one call, so that it is inlined
    return mat_add(Z, mat_t_mat(M, mat_mat(rate_hessian(data, F), M))) if rated else Z


@inlined_inner_kernel
def momentum_map(h, Jd, F):
    """Fact 2: M = h F^T (tr(F Jd) I - F Jd)^-1, so that F^T delta F = hat(M delta Pi); (M, det)."""
    G_inverse, det = inverse(trace_minus(mat_mat(F, Jd)))
    return mat_scale(h, mat_t_mat(F, G_inverse)), det


@inlined_inner_kernel
def squared_control(W, k):
    """Squared norm |u_k|^2 = |z_k|^2 of the controls of stage k."""
    zz = 0.0
    for i in range(Z_AT, W.shape[1]):
        zz += W[k, i] * W[k, i]
    return zz


@inner_kernel
def stage_cost(data, zones, track, R_k, Pi_k, W, k):
    """Cost of stage k, (27) and penalties h mu max(0, H)^2, with z and sigma from row k of W."""
    h, alpha, mu0 = data[H], data[ALPHA], data[MU0]
    m = int(data[M_U])
    effort, zz = 0.0, 0.0
    for i in range(m):
        z = W[k, Z_AT + i]
        zz += z * z
        z -= control_reference(track, m, i)
        effort += data[D_U + i] * z * z
    state = stage_attitude_cost(data, stage_reference(track, k), R_k)
    state += quadratic(data9(data, S_Q2), sub(Pi_k, stage_momentum(track, k)))
    total = h * (state + effort) + zone_cost(h, zones, R_k)
    if data[LOG_FORM] > 0.0:
        total += rate_cost(data, load9_flat(W, k))
    if alpha > 0.0:
        # A solve knows sigma = 2 mu0 H0 without cancellation; a bare rollout has sigma < 0.
        sigma = W[k, SIGMA_AT]
        H0 = sigma / (2.0 * mu0) if sigma >= 0.0 else max(0.0, zz - alpha)
        if H0 > 0.0:  # under a hard limit mu0 is infinite
            total += h * mu0 * H0 * H0
    return total


@kernel
def horizon_cost(data, zones, track, R, Pi, W):
    """Cost (27) + (28) + penalties of a propagated horizon."""
    N = W.shape[0]
    total = terminal_cost(data, track, R, Pi)
    for k in range(N):
        total += stage_cost(data, zones, track, load9(R, k), load3(Pi, k), W, k)
    return total
