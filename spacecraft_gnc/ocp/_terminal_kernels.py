"""Kernels of the terminal cost and its derivatives, in both forms; `terminal_set` documents them.

Gupta et al. 2015, (28): by R_N - R_ref. Kalabic et al. 2014, (26): x . P x / 2 with x = (Z, Pi) and
Z the logarithm of C = R_ref^T R_N, its angle continuous along the horizon. Costates are half the
true ones in both: lam = -1/2 the gradient to (eta, Pi) for R exp(hat(eta)).
"""

from __future__ import annotations

import math

from spacecraft_gnc._inner_kernels import inlined_inner_kernel, inner_kernel
from spacecraft_gnc._kernels import kernel
from spacecraft_gnc.lie._mat3_kernels import (
    EYE,
    add,
    cross,
    dot,
    hat,
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
    transpose,
    vee_antisymmetric,
)
from spacecraft_gnc.ocp._data_kernels import (
    LOG_FORM,
    P1,
    Q1,
    Q_RATE,
    S_P2,
    data9,
    log_weight,
    quadratic,
)
from spacecraft_gnc.ocp._track_kernels import END_AT, TERMINAL_AT, end_momentum

HALF_TURN = 1e-12  # |w| up to which an attitude counts as half a turn away: its side is rounding
SMALL_SQUARE = 0.05  # theta^2 below which the coefficients of the logarithm are summed as series


@inlined_inner_kernel
def attitude_cost(Q, R_ref, R):
    """|Q^(1/2) (R - R_ref)|_F^2 / 2, by the difference: accurate however close the two are."""
    D = mat_sub(R, R_ref)
    QD = mat_mat(Q, D)
    total = 0.0
    for i in range(9):
        total += D[i] * QD[i]
    return 0.5 * total


@inlined_inner_kernel
def stage_attitude_cost(data, R_ref, R):
    """Attitude part of the stage cost: of Q (R - R_ref), or tr(Q (I - R_ref^T R)) in log form."""
    Q = data9(data, Q1)
    if data[LOG_FORM] > 0.0:
        return attitude_cost(Q, transpose(R_ref), transpose(R))
    return attitude_cost(Q, R_ref, R)


@inlined_inner_kernel
def rate_cost(data, F):
    """tr(Q (I - F)) with Q = lambda Q2 / h^2."""
    return attitude_cost(data9(data, Q_RATE), EYE, F)


@inlined_inner_kernel
def rate_gradient(data, F):
    """Half the gradient of `rate_cost` to xi, for F exp(hat(xi))."""
    return vee_antisymmetric(mat_mat(data9(data, Q_RATE), F))


@inlined_inner_kernel
def rate_hessian(data, F):
    """Derivative of `rate_gradient` to xi."""
    return mat_scale(0.5, trace_minus(mat_t_mat(F, data9(data, Q_RATE))))


@inner_kernel
def _quaternion(C):
    """Unit quaternion (w, q) of a rotation, of either sign, by Shepperd's method."""
    trace = C[0] + C[4] + C[8]
    if trace >= max(C[0], C[4], C[8]):
        w, q = 1.0 + trace, (C[7] - C[5], C[2] - C[6], C[3] - C[1])
    elif C[0] >= max(C[4], C[8]):
        w, q = C[7] - C[5], (1.0 + 2.0 * C[0] - trace, C[1] + C[3], C[2] + C[6])
    elif C[4] >= C[8]:
        w, q = C[2] - C[6], (C[1] + C[3], 1.0 + 2.0 * C[4] - trace, C[5] + C[7])
    else:
        w, q = C[3] - C[1], (C[2] + C[6], C[5] + C[7], 1.0 + 2.0 * C[8] - trace)
    s = 1.0 / math.sqrt(w * w + dot(q, q))
    return s * w, scale(s, q)


@inner_kernel
def _principal(w, q):
    """Of a quaternion's two signs, the one with an angle below pi; at pi, `lie.log`'s branch."""
    if abs(w) > HALF_TURN:
        return (w, q) if w > 0.0 else (-w, scale(-1.0, q))
    return (w, q) if max(q[0], q[1], q[2]) >= -min(q[0], q[1], q[2]) else (-w, scale(-1.0, q))


@inner_kernel
def principal_log(C):
    """Rotation vector of C, of length up to pi."""
    w, q = _quaternion(C)
    w, q = _principal(w, q)
    return _rotation_vector(w, q)


@inner_kernel
def _rotation_vector(w, q):
    sine = math.sqrt(dot(q, q))
    return scale(2.0 * math.atan2(sine, w) / sine if sine > 0.0 else 2.0, q)


@kernel
def continuous_log(R_ref, R):
    """Rotation vector of R_ref^T R_N, from the principal one of R_0 on continuous along R."""
    w, q = _quaternion(mat_t_mat(R_ref, load9(R, 0)))
    w, q = _principal(w, q)
    for k in range(1, R.shape[0]):
        v, p = _quaternion(mat_t_mat(R_ref, load9(R, k)))
        w, q = (v, p) if v * w + dot(p, q) >= 0.0 else (-v, scale(-1.0, p))
    return _rotation_vector(w, q)


@inner_kernel
def _bend(t):
    """C = (1 - theta/2 cot(theta/2)) / theta^2 and (dc/dtheta)/theta at t = theta^2."""
    if t < SMALL_SQUARE:
        c = 1.0 / 12.0 + t * (1.0 / 720.0 + t * (1.0 / 30240.0 + t * (
            1.0 / 1209600.0 + t * (1.0 / 47900160.0 + t * 691.0 / 1307674368000.0))))  # fmt: skip
        slope = 2.0 * (1.0 / 720.0 + t * (2.0 / 30240.0 + t * (
            3.0 / 1209600.0 + t * (4.0 / 47900160.0 + t * 3455.0 / 1307674368000.0))))  # fmt: skip
        return c, slope
    theta = math.sqrt(t)
    half = 0.5 * theta
    cot, sine = math.cos(half) / math.sin(half), math.sin(half)
    c = (1.0 - half * cot) / t
    return c, (-2.0 / theta + 0.5 * cot + 0.25 * theta / (sine * sine)) / (t * theta)


@kernel
def log_derivative(Z):
    """Matrix L with delta Z = L eta: I + hat(Z)/2 + c hat(Z)^2."""
    c, _ = _bend(dot(Z, Z))
    H = hat(Z)
    return mat_add(EYE, mat_add(mat_scale(0.5, H), mat_scale(c, mat_mat(H, H))))


@kernel
def _log_curvature(Z, y):
    """Derivative to Z of L(Z)^T y at fixed y."""
    c, slope = _bend(dot(Z, Z))
    n = cross(Z, y)
    turned = mat_add(hat(n), mat_mat(hat(Z), hat(y)))
    D = mat_sub(mat_scale(0.5, hat(y)), mat_scale(c, turned))
    return mat_add(D, outer(scale(slope, cross(Z, n)), Z))


@inner_kernel
def terminal_costate(data, track, R, Pi):
    """Costates (lam1, lam2) at the end of a rollout R (N+1,3,3), Pi (N+1,3)."""
    N = R.shape[0] - 1
    R_N, Pi_N = load9(R, N), load3(Pi, N)
    if data[LOG_FORM] == 0.0:
        l1 = vee_antisymmetric(mat_t_mat(R_N, data9(track, TERMINAL_AT)))
        off = sub(Pi_N, end_momentum(track))
        return l1, scale(-1.0, mat_vec(data9(data, S_P2), off))
    Z = continuous_log(data9(track, END_AT), R)
    y = add(mat_vec(log_weight(data, 0, 0), Z), mat_vec(log_weight(data, 0, 3), Pi_N))
    l2 = add(mat_vec(log_weight(data, 3, 0), Z), mat_vec(log_weight(data, 3, 3), Pi_N))
    return scale(-0.5, mat_t_vec(log_derivative(Z), y)), scale(-0.5, l2)


@inner_kernel
def terminal_hessian(data, track, R, Pi):
    """Blocks V11, V12, V21, V22 with delta lam = -V (eta, delta Pi) at the end of a rollout."""
    N = R.shape[0] - 1
    zero = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if data[LOG_FORM] == 0.0:
        V11 = mat_scale(0.5, trace_minus(mat_t_mat(load9(R, N), data9(track, TERMINAL_AT))))
        return V11, zero, zero, data9(data, S_P2)
    Z, Pi_N = continuous_log(data9(track, END_AT), R), load3(Pi, N)
    P11, P12 = log_weight(data, 0, 0), log_weight(data, 0, 3)
    L = log_derivative(Z)
    y = add(mat_vec(P11, Z), mat_vec(P12, Pi_N))
    V11 = mat_mat(mat_add(mat_t_mat(L, P11), _log_curvature(Z, y)), L)
    V12, V21 = mat_t_mat(L, P12), mat_mat(log_weight(data, 3, 0), L)
    return (
        mat_scale(0.5, V11),
        mat_scale(0.5, V12),
        mat_scale(0.5, V21),
        mat_scale(0.5, log_weight(data, 3, 3)),
    )


@inner_kernel
def log_level(data, Z, Pi):
    """|(Z, Pi)|^2 in the weight of the log form."""
    cross_term = dot(Z, mat_vec(log_weight(data, 0, 3), Pi))
    attitude, momentum = quadratic(log_weight(data, 0, 0), Z), quadratic(log_weight(data, 3, 3), Pi)
    return attitude + 2.0 * cross_term + momentum


@inner_kernel
def terminal_cost(data, track, R, Pi):
    """Terminal cost at the end of a rollout."""
    N = R.shape[0] - 1
    if data[LOG_FORM] > 0.0:
        return 0.5 * log_level(data, continuous_log(data9(track, END_AT), R), load3(Pi, N))
    attitude = attitude_cost(data9(data, P1), data9(track, END_AT), load9(R, N))
    off = sub(load3(Pi, N), end_momentum(track))
    return attitude + quadratic(data9(data, S_P2), off)
