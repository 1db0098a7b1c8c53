"""Kernels of the backward sweep: Newton's equations of the whole horizon, solved stage by stage.

The unknowns are the multipliers lam2_k of all stages (``guess``, N x 3). `evaluate` makes controls
of them by (38), rolls out and sweeps (34)-(37) backward; the mismatch ``resid`` = lam2 - guess is
the gradient of the cost divided by -2 h U^-1, and zero exactly where the conditions hold.
`factorize` carries delta lam_k = -V_k delta x_{k+1} + v_k backward, with V the second derivative of
the cost to go; `substitute` solves for one right-hand side. `shooting` documents the method.

A row of ``fac`` holds U, S^-1, K = S^-1 (V A)_2 (3 x 6), L = h V_{:,2} U (6 x 3), and F, M, A where
it was linearized: everything `substitute` needs, so that a factorization can be kept.
"""

from __future__ import annotations

import math

from spacecraft_gnc._inner_kernels import inlined_inner_kernel, inner_kernel
from spacecraft_gnc._kernels import kernel
from spacecraft_gnc.dynamics._lgvi_kernels import (
    body_nonstandard_inertia,
    relative_quaternion,
    rotate_back,
    rotate_rows,
    rotation_of,
)
from spacecraft_gnc.lie._mat3_kernels import (
    EYE,
    add,
    cross,
    dot,
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
    mat_vec,
    scale,
    store3,
    store9,
    store9_flat,
    sub,
    transpose,
)
from spacecraft_gnc.ocp._data_kernels import LOG_FORM, S_Q2, H, data9
from spacecraft_gnc.ocp._stage_kernels import (
    A_AT,
    M_AT,
    P_AT,
    SIGMA_AT,
    attitude_gradient,
    attitude_hessian,
    control,
    control_sensitivity,
    hashed,
    momentum_map,
    stage_curvature,
)
from spacecraft_gnc.ocp._terminal_kernels import rate_gradient, terminal_costate, terminal_hessian
from spacecraft_gnc.ocp._track_kernels import stage_momentum, stage_weighed

SOLVED, UNSOLVABLE_STEP = 0, 3  # equal to ocp.Status
U_AT, SI_AT, K1_AT, K2_AT, L1_AT, L2_AT, F_AT, MF_AT, AF_AT, FACTOR_SIZE = range(0, 90, 9)


@inlined_inner_kernel
def store_stage(h, Jd, W, k, q0, q, p):
    """Store F, M, A = F^T + hat(p) M and p = F^T Pi of stage k in W."""
    F = rotation_of(q0, q)
    M, _ = momentum_map(h, Jd, F)
    store9_flat(W, k, F)
    store9_flat(W, k, M, M_AT)
    store9_flat(W, k, mat_add(transpose(F), hat_mat(p, M)), A_AT)
    store3(W, k, p, P_AT)


@inner_kernel
def sweep_costates(data, zones, track, R, Pi, lam, W):
    """Sweep (34)-(37) backward over a rollout into lam (N, 6).

    Returns a hash of the zones that act and their stages, zero for none.
    """
    N = W.shape[0]
    h, S2 = data[H], data9(data, S_Q2)
    l1, l2 = terminal_costate(data, track, R, Pi)
    rated = data[LOG_FORM] > 0.0
    pattern = 0
    for k in range(N - 1, -1, -1):
        store3(lam, k, l1)
        store3(lam, k, l2, 3)
        if k > 0:
            g, active = attitude_gradient(h, stage_weighed(track, k), zones, load9(R, k))
            if active != 0:
                pattern = hashed(hashed(pattern, k), active)
            M, A = load9_flat(W, k, M_AT), load9_flat(W, k, A_AT)
            pushed = sub(l1, rate_gradient(data, load9_flat(W, k))) if rated else l1
            swept = add(mat_t_vec(A, l2), mat_t_vec(M, pushed))
            off = sub(load3(Pi, k), stage_momentum(track, k))
            l2 = sub(swept, scale(h, mat_vec(S2, off)))
            l1 = sub(mat_vec(load9_flat(W, k), l1), g)
    return pattern


@inner_kernel
def sweep_residual(data, zones, track, guess, R, Pi, lam, resid, W):
    """Sweep the costates of a rollout; returns the pattern of zones and |lam2 - guess|."""
    pattern, total = sweep_costates(data, zones, track, R, Pi, lam, W), 0.0
    for k in range(guess.shape[0]):
        r = sub(load3(lam, k, 3), load3(guess, k))
        store3(resid, k, r)
        total += dot(r, r)
    return pattern, math.sqrt(total)


@inner_kernel
def begin(body, data, R, Pi, W):
    """Roll out what of the first stage no guess changes; returns whether the step exists."""
    h, Pi_0 = data[H], load3(Pi, 0)
    q0, q, ok = relative_quaternion(body, h, Pi_0)
    store_stage(h, body_nonstandard_inertia(body), W, 0, q0, q, rotate_back(q0, q, Pi_0))
    store9(R, 1, rotate_rows(q0, q, load9(R, 0)))
    return ok


@inner_kernel
def evaluate_begun(body, data, zones, track, guess, R, Pi, u, lam, resid, W):
    """`evaluate` where `begin`, or an evaluation of another guess, has left the first stage."""
    N = u.shape[0]
    h, Jd = data[H], body_nonstandard_inertia(body)
    R_k, Pi_k, p = load9(R, 1), load3(Pi, 0), load3(W, 0, P_AT)
    pattern = 0
    for k in range(N):
        if k > 0:
            q0, q, ok = relative_quaternion(body, h, Pi_k)
            if not ok:
                return UNSOLVABLE_STEP, math.inf, 0
            p = rotate_back(q0, q, Pi_k)
            store_stage(h, Jd, W, k, q0, q, p)
            R_k = rotate_rows(q0, q, R_k)
            store9(R, k + 1, R_k)
        u_k, sigma = control(data, track, load3(guess, k), W, k)
        W[k, SIGMA_AT] = sigma
        if sigma > 0.0:
            pattern = hashed(pattern, k + 1)
        store3(u, k, u_k)
        Pi_k = add(p, scale(h, u_k))
        store3(Pi, k + 1, Pi_k)
    active, norm = sweep_residual(data, zones, track, guess, R, Pi, lam, resid, W)
    return SOLVED, norm, hashed(pattern, active)


@kernel
def evaluate(body, data, zones, track, guess, R, Pi, u, lam, resid, W):
    """Fill one horizon from ``guess``; returns status, |resid|, pattern of active limits.

    The pattern is a hash of the stages at their torque limit, and of the zones that act on each.
    """
    if not begin(body, data, R, Pi, W):
        return UNSOLVABLE_STEP, math.inf, 0
    return evaluate_begun(body, data, zones, track, guess, R, Pi, u, lam, resid, W)


@inlined_inner_kernel
def _is_definite(S, det):
    """Whether the eigenvalues of S = I + h V22 U or its inverse, which are real, are all positive.

    By the signs of its characteristic polynomial: U may be singular to rounding, S is not.
    """
    minors = S[0] * S[4] - S[1] * S[3] + S[0] * S[8] - S[2] * S[6] + S[4] * S[8] - S[5] * S[7]
    return det > 0.0 and S[0] + S[4] + S[8] > 0.0 and minors > 0.0


@kernel
def factorize(body, data, zones, track, R, Pi, lam, W, fac, rho, estimated):
    """Linearize and sweep V backward; returns the last stage that is not definite, -1 for none.

    ``rho`` >= 0 is Levenberg's term: U becomes U (I + rho U)^-1.
    """
    h, Jd = data[H], body_nonstandard_inertia(body)
    N = W.shape[0]
    V11, V12, V21, V22 = terminal_hessian(data, track, R, Pi)
    indefinite = -1
    for k in range(N - 1, -1, -1):
        U = control_sensitivity(data, W, k, estimated)
        if rho > 0.0:
            U = mat_mat(U, inverse(mat_add(EYE, mat_scale(rho, U)))[0])
        L2 = mat_scale(h, mat_mat(V22, U))
        S = mat_add(EYE, L2)
        S_inverse, det = inverse(S)
        if indefinite < 0 and not _is_definite(S, det):
            indefinite = k
        F, M, A = load9_flat(W, k), load9_flat(W, k, M_AT), load9_flat(W, k, A_AT)
        Y21, Y22 = mat_mat(V21, transpose(F)), mat_add(mat_mat(V21, M), mat_mat(V22, A))
        K1, K2 = mat_mat(S_inverse, Y21), mat_mat(S_inverse, Y22)
        store9_flat(fac, k, U, U_AT)
        store9_flat(fac, k, S_inverse, SI_AT)
        store9_flat(fac, k, K1, K1_AT)
        store9_flat(fac, k, K2, K2_AT)
        store9_flat(fac, k, F, F_AT)
        store9_flat(fac, k, M, MF_AT)
        store9_flat(fac, k, A, AF_AT)
        if k > 0:
            L1 = mat_scale(h, mat_mat(V12, U))
            store9_flat(fac, k, L1, L1_AT)
            store9_flat(fac, k, L2, L2_AT)
            Y11, Y12 = mat_mat(V11, transpose(F)), mat_add(mat_mat(V11, M), mat_mat(V12, A))
            X11, X12 = mat_sub(Y11, mat_mat(L1, K1)), mat_sub(Y12, mat_mat(L1, K2))
            X21, X22 = mat_sub(Y21, mat_mat(L2, K1)), mat_sub(Y22, mat_mat(L2, K2))
            l1, l2 = load3(lam, k), load3(lam, k, 3)
            Z = stage_curvature(data, Jd, W, k, l1, l2)
            G = attitude_hessian(h, stage_weighed(track, k), zones, load9(R, k))
            V11 = mat_add(mat_mat(F, X11), G)
            V12 = mat_mat(F, mat_add(X12, hat_mat(l1, M)))
            V21 = mat_add(mat_t_mat(M, X11), mat_t_mat(A, X21))
            V22 = mat_add(mat_add(mat_t_mat(M, X12), mat_t_mat(A, X22)), Z)
    return indefinite


@inlined_inner_kernel
def advance_deviation(h, fac, k, eta, d_Pi, du):
    """Carry (eta, delta Pi) over stage k by (39)."""
    return (
        add(mat_t_vec(load9_flat(fac, k, F_AT), eta), mat_vec(load9_flat(fac, k, MF_AT), d_Pi)),
        add(mat_vec(load9_flat(fac, k, AF_AT), d_Pi), scale(h, du)),
    )


@kernel
def substitute(h, fac, resid, eta, d_Pi, rho, step):
    """Solve for ``step`` (N, 3), the change of the guess, given an initial deviation (eta, d_Pi).

    Returns the slope of the cost along it (for a zero deviation).
    """
    N = resid.shape[0]
    v1, v2 = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for k in range(N - 1, -1, -1):
        y = mat_vec(load9_flat(fac, k, SI_AT), sub(load3(resid, k), v2))
        store3(step, k, y)
        if k > 0:
            w1 = add(v1, mat_vec(load9_flat(fac, k, L1_AT), y))
            w2 = add(v2, mat_vec(load9_flat(fac, k, L2_AT), y))
            v1 = mat_vec(load9_flat(fac, k, F_AT), w1)
            M, A = load9_flat(fac, k, MF_AT), load9_flat(fac, k, AF_AT)
            v2 = add(mat_t_vec(M, w1), mat_t_vec(A, w2))
    slope = 0.0
    for k in range(N):
        K1, K2 = load9_flat(fac, k, K1_AT), load9_flat(fac, k, K2_AT)
        y = sub(load3(step, k), add(mat_vec(K1, eta), mat_vec(K2, d_Pi)))
        du = mat_vec(load9_flat(fac, k, U_AT), y)
        store3(step, k, sub(y, scale(rho, du)) if rho > 0.0 else y)
        slope -= 2.0 * h * dot(load3(resid, k), du)
        eta, d_Pi = advance_deviation(h, fac, k, eta, d_Pi, du)
    return slope


@inner_kernel
def extreme_eigenvalues(Q):
    """Smallest and largest eigenvalue of a symmetric matrix, by the trigonometric formula."""
    mean = (Q[0] + Q[4] + Q[8]) / 3.0
    D = mat_sub(Q, mat_scale(mean, EYE))
    square = D[0] * D[0] + D[4] * D[4] + D[8] * D[8]
    square += 2.0 * (D[1] * D[1] + D[2] * D[2] + D[5] * D[5])
    size = math.sqrt(square / 6.0)
    if not size > 0.0:
        return mean, mean
    cosine = 0.5 * inverse(mat_scale(1.0 / size, D))[1]
    third = math.acos(max(-1.0, min(1.0, cosine))) / 3.0
    lowest = mean + 2.0 * size * math.cos(third + 2.0 * math.pi / 3.0)
    return lowest, mean + 2.0 * size * math.cos(third)


@inlined_inner_kernel
def pivot_inverse(h, fac, k):
    """Inverse of stage k's pivot: the torques' second derivative with all later stages optimal."""
    Q = mat_scale(0.5 / h, mat_mat(load9_flat(fac, k, U_AT), load9_flat(fac, k, SI_AT)))
    return mat_scale(0.5, mat_add(Q, transpose(Q)))


@kernel
def smallest_pivot(h, fac):
    """Smallest eigenvalue of all pivots; positive exactly where the reduced Hessian is definite.

    The last stage, whose pivot is the smallest as a rule, comes first: the others then need a bound
    on their largest row only.
    """
    smallest = math.inf
    for k in range(fac.shape[0] - 1, -1, -1):
        Q = pivot_inverse(h, fac, k)
        row = max(
            abs(Q[0]) + abs(Q[1]) + abs(Q[2]),
            abs(Q[3]) + abs(Q[4]) + abs(Q[5]),
            abs(Q[6]) + abs(Q[7]) + abs(Q[8]),
        )
        if Q[0] > 0.0 and row * smallest <= 1.0 and _is_definite(Q, inverse(Q)[1]):
            continue
        lowest, highest = extreme_eigenvalues(Q)
        if not math.isfinite(lowest):
            return math.nan
        definite = lowest > 0.0
        if not definite:
            # S gives the sign: an inverse near zero, as of what no actuator moves, has either.
            S_inverse = load9_flat(fac, k, SI_AT)
            definite = _is_definite(S_inverse, inverse(S_inverse)[1])
        smallest = min(smallest, 1.0 / highest if definite else -abs(1.0 / lowest))
    return smallest


@kernel
def descent_at_saddle(h, fac, stage, step):
    """Fill ``step`` with a direction of negative curvature that starts at an indefinite stage.

    Later stages answer by their feedback; its sign makes the largest component of the torque
    positive. Returns the size of the torque.
    """
    Q = pivot_inverse(h, fac, stage)
    D = mat_sub(Q, mat_scale(extreme_eigenvalues(Q)[0], EYE))
    a, b, c = (D[0], D[1], D[2]), (D[3], D[4], D[5]), (D[6], D[7], D[8])
    n = cross(a, b)
    for other in (cross(b, c), cross(c, a)):
        if dot(other, other) > dot(n, n):
            n = other
    n = n if dot(n, n) > 0.0 else (1.0, 0.0, 0.0)
    eta, d_Pi, size = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0
    for k in range(step.shape[0]):
        y = (0.0, 0.0, 0.0)
        if k == stage:
            y = mat_vec(load9_flat(fac, k, SI_AT), n)
        elif k > stage:
            K1, K2 = load9_flat(fac, k, K1_AT), load9_flat(fac, k, K2_AT)
            y = scale(-1.0, add(mat_vec(K1, eta), mat_vec(K2, d_Pi)))
        du = mat_vec(load9_flat(fac, k, U_AT), y)
        if k == stage:
            largest = max(du[0], du[1], du[2])
            if -min(du[0], du[1], du[2]) > largest:
                y, du = scale(-1.0, y), scale(-1.0, du)
            size = math.sqrt(dot(du, du))
        store3(step, k, y)
        eta, d_Pi = advance_deviation(h, fac, k, eta, d_Pi, du)
    return size
