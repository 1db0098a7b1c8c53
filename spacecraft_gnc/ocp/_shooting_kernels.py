"""Kernels of indirect single shooting on the conditions (31)-(45) of Gupta 2015; see `shooting`.

Arrays of one horizon: R (N+1,3,3), Pi (N+1,3), u (N,3) torques, lam (N,6) = (lam1, lam2), and the
stages' work W of `_stage_kernels`, the reference ``track`` of `_track_kernels`.
"""

from __future__ import annotations

import math

from spacecraft_gnc._inner_kernels import inner_kernel
from spacecraft_gnc._kernels import kernel
from spacecraft_gnc.dynamics._lgvi_kernels import (
    body_inertia,
    body_nonstandard_inertia,
    relative_quaternion,
    rotate_back,
    rotate_rows,
)
from spacecraft_gnc.lie._mat3_kernels import (
    add,
    dot,
    hat_mat,
    inverse,
    load3,
    load9,
    load9_flat,
    mat_scale,
    mat_t_mat,
    mat_t_vec,
    mat_vec,
    scale,
    store3,
    store9,
    sub,
    trace_minus,
    transpose,
    vee_antisymmetric,
)
from spacecraft_gnc.ocp._certificate_kernels import largest_row, rounding_of
from spacecraft_gnc.ocp._data_kernels import S_P2, S_Q2, H, data9
from spacecraft_gnc.ocp._newton_kernels import (
    BACKTRACKING,
    CHORD,
    CONTRACTION,
    CONVERGED,
    DAMPED,
    LINE_SEARCH_FAILED,
    MAX_ITERATIONS,
    NOT_FINITE,
    SINGULAR,
    SUFFICIENT_DECREASE,
    UNSOLVABLE_STEP,
)
from spacecraft_gnc.ocp._stage_kernels import (
    A_AT,
    M_AT,
    P_AT,
    SIGMA_AT,
    attitude_gradient,
    attitude_hessian,
    control,
    control_sensitivity,
    costate_curvature,
)
from spacecraft_gnc.ocp._sweep_kernels import store_stage
from spacecraft_gnc.ocp._track_kernels import (
    TERMINAL_AT,
    end_momentum,
    stage_momentum,
    stage_weighed,
)

SMALLEST_STEP = 2.0**-24


@kernel
def propagate_horizon(body, data, zones, track, R, Pi, u, lam, W):
    """Run (31)-(34), (36), (38) forward from row 0; returns a status and the residual (44)."""
    N = u.shape[0]
    h = data[H]
    Jd = body_nonstandard_inertia(body)
    S2 = data9(data, S_Q2)
    R_k, Pi_k = load9(R, 0), load3(Pi, 0)
    l1, l2 = load3(lam, 0), load3(lam, 0, 3)
    zero = (0.0, 0.0, 0.0)
    for k in range(N):
        q0, q, ok = relative_quaternion(body, h, Pi_k)
        if not ok:
            return UNSOLVABLE_STEP, zero, zero
        p = rotate_back(q0, q, Pi_k)
        store_stage(h, Jd, W, k, q0, q, p)
        if k > 0:
            F, M = load9_flat(W, k), load9_flat(W, k, M_AT)
            l1 = mat_t_vec(F, add(l1, attitude_gradient(h, stage_weighed(track, k), zones, R_k)[0]))
            C_inverse, det = inverse(transpose(load9_flat(W, k, A_AT)))  # C = F - M^T hat(p) = A^T
            if det == 0.0:
                return SINGULAR, zero, zero
            off = sub(Pi_k, stage_momentum(track, k))
            rhs = sub(add(l2, scale(h, mat_vec(S2, off))), mat_t_vec(M, l1))
            l2 = mat_vec(C_inverse, rhs)
            store3(lam, k, l1)
            store3(lam, k, l2, 3)
        u_k, sigma = control(data, track, l2, W, k)
        W[k, SIGMA_AT] = sigma
        store3(u, k, u_k)
        R_k = rotate_rows(q0, q, R_k)
        Pi_k = add(p, scale(h, u_k))
        store9(R, k + 1, R_k)
        store3(Pi, k + 1, Pi_k)
    E1 = sub(l1, vee_antisymmetric(mat_t_mat(R_k, data9(track, TERMINAL_AT))))
    E2 = add(l2, mat_vec(data9(data, S_P2), sub(Pi_k, end_momentum(track))))
    return CONVERGED, E1, E2


@kernel
def lever(problem):
    """Step over mean inertia: what turns lam1 into the units of lam2."""
    J = body_inertia(problem[0])
    return 3.0 * problem[1][H] / (J[0] + J[4] + J[8])


@kernel
def shooting_jacobian(body, data, zones, track, R, Pi, u, lam, W, T, E, estimated):
    """Derivative of the residual (44) to (lam1_0, lam2_0) by (39)-(45) into E (6,6).

    T (6, 12) carries, for each unknown, (eta, delta Pi, delta lam1, delta lam2) along the horizon.
    ``estimated``: with (40) of Bagherzadeh et al. for delta u.
    """
    N = u.shape[0]
    h = data[H]
    Jd = body_nonstandard_inertia(body)
    S2 = data9(data, S_Q2)
    for j in range(6):
        for i in range(12):
            T[j, i] = 0.0
        T[j, 6 + j] = 1.0
    hU = mat_scale(h, control_sensitivity(data, W, 0, estimated))
    for j in range(6):
        store3(T, j, mat_vec(hU, load3(T, j, 9)), 3)
    for k in range(1, N):
        F, M = load9_flat(W, k), load9_flat(W, k, M_AT)
        p = load3(W, k, P_AT)
        l1, l2 = load3(lam, k), load3(lam, k, 3)
        A = load9_flat(W, k, A_AT)
        C_inverse, _ = inverse(transpose(A))
        G = attitude_hessian(h, stage_weighed(track, k), zones, load9(R, k))
        D = hat_mat(l1, M)
        Z = costate_curvature(h, S2, Jd, F, M, A, l1, l2, p)
        hU = mat_scale(h, control_sensitivity(data, W, k, estimated))
        for j in range(6):
            eta, d_Pi = load3(T, j), load3(T, j, 3)
            d_l1, d_l2 = load3(T, j, 6), load3(T, j, 9)
            d_l1 = add(mat_t_vec(F, add(d_l1, mat_vec(G, eta))), mat_vec(D, d_Pi))
            d_l2 = mat_vec(C_inverse, add(sub(d_l2, mat_t_vec(M, d_l1)), mat_vec(Z, d_Pi)))
            eta = add(mat_t_vec(F, eta), mat_vec(M, d_Pi))
            d_Pi = add(mat_vec(A, d_Pi), mat_vec(hU, d_l2))
            store3(T, j, eta)
            store3(T, j, d_Pi, 3)
            store3(T, j, d_l1, 6)
            store3(T, j, d_l2, 9)
    bend = mat_scale(0.5, trace_minus(mat_t_mat(load9(R, N), data9(track, TERMINAL_AT))))
    SP = data9(data, S_P2)
    for j in range(6):
        e1 = add(load3(T, j, 6), mat_vec(bend, load3(T, j)))
        e2 = add(load3(T, j, 9), mat_vec(SP, load3(T, j, 3)))
        E[0, j], E[1, j], E[2, j] = e1
        E[3, j], E[4, j], E[5, j] = e2


@inner_kernel
def solve_linear(A, b):
    """Gaussian elimination with partial pivoting in place; b becomes the solution."""
    n = b.shape[0]
    for i in range(n):
        pivot = i
        for r in range(i + 1, n):
            if abs(A[r, i]) > abs(A[pivot, i]):
                pivot = r
        if A[pivot, i] == 0.0 or not math.isfinite(A[pivot, i]):
            return False
        if pivot != i:
            for c in range(i, n):
                A[i, c], A[pivot, c] = A[pivot, c], A[i, c]
            b[i], b[pivot] = b[pivot], b[i]
        inverse_pivot = 1.0 / A[i, i]
        for r in range(i + 1, n):
            factor = A[r, i] * inverse_pivot
            for c in range(i + 1, n):
                A[r, c] -= factor * A[i, c]
            b[r] -= factor * b[i]
    for i in range(n - 1, -1, -1):
        total = b[i]
        for c in range(i + 1, n):
            total -= A[i, c] * b[c]
        b[i] = total / A[i, i]
    return True


@inner_kernel
def _norm(problem, E1, E2):
    E1 = scale(lever(problem), E1)
    return math.sqrt(dot(E1, E1) + dot(E2, E2))


@inner_kernel
def _shoot(problem, horizon):
    """Propagate; returns status, E1, E2 and the residual norm (infinite without one)."""
    body, data, zones, track = problem
    R, Pi, u, lam, W = horizon
    status, E1, E2 = propagate_horizon(body, data, zones, track, R, Pi, u, lam, W)
    return status, E1, E2, _norm(problem, E1, E2) if status == CONVERGED else math.inf


@inner_kernel
def _direction(problem, T, E, E1, E2):
    """Solve E d = (E1, E2) with the Jacobian in E, which stays; returns d1, d2 and success.

    lam1 and its conditions are counted in the units of lam2: pivots are compared.
    """
    A, b, c = T[:, :6], T[0, 6:], lever(problem)
    for i in range(6):
        for j in range(6):
            A[i, j] = E[i, j] * (c if i < 3 else 1.0) / (c if j < 3 else 1.0)
    b[0], b[1], b[2] = scale(c, E1)
    b[3], b[4], b[5] = E2
    done = solve_linear(A, b)
    return scale(1.0 / c, (b[0], b[1], b[2])), (b[3], b[4], b[5]), done


@inner_kernel
def _move(lam, x1, x2, gamma, d1, d2):
    store3(lam, 0, sub(x1, scale(gamma, d1)))
    store3(lam, 0, sub(x2, scale(gamma, d2)), 3)


@inner_kernel
def _step(problem, horizon, T, E, E1, E2, norm, rule, damping, good_jacobian):
    """Change the multipliers of row 0 by (43); returns status, E1, E2, residual.

    full and damped: whatever it does; backtracking: until the residual falls; a kept Jacobian
    (``good_jacobian`` false): once, and LINE_SEARCH_FAILED where it does not contract.
    """
    lam = horizon[3]
    d1, d2, done = _direction(problem, T, E, E1, E2)
    if not done:
        return SINGULAR, E1, E2, norm
    x1, x2 = load3(lam, 0), load3(lam, 0, 3)
    gamma = damping if rule == DAMPED else 1.0
    while gamma >= SMALLEST_STEP:
        _move(lam, x1, x2, gamma, d1, d2)
        status, e1, e2, new_norm = _shoot(problem, horizon)
        searching = rule in (BACKTRACKING, CHORD)
        bound = (1.0 - SUFFICIENT_DECREASE * gamma) if good_jacobian else CONTRACTION
        if not searching or (status == CONVERGED and new_norm <= bound * norm):
            return status, e1, e2, new_norm
        if not good_jacobian:
            break
        gamma *= 0.5
    _move(lam, x1, x2, 0.0, d1, d2)  # leave the last point behind, consistent with its residual
    _shoot(problem, horizon)
    return LINE_SEARCH_FAILED, E1, E2, norm


@inner_kernel
def newton_shooting(problem, horizon, T, E, kept, rule, damping, estimated, tolerance, max_steps):
    """Newton on (44) from row 0 of lam; returns status, steps, residual norm.

    ``kept`` (2,): whether E (6, 6) holds the Jacobian of an earlier point, for the chord.
    """
    body, data, zones, track = problem
    R, Pi, u, lam, W = horizon
    status, E1, E2, norm = _shoot(problem, horizon)
    last_norm = math.inf
    for steps in range(max_steps + 1):
        rounded = norm > CONTRACTION * last_norm and norm <= rounding_of(data, track, Pi)
        if rounded and status in (CONVERGED, LINE_SEARCH_FAILED):
            return CONVERGED, steps, norm
        if status != CONVERGED:
            return status, steps, norm
        if norm <= tolerance * largest_row(lam, 3):
            return CONVERGED, steps, norm
        last_norm = norm
        if not math.isfinite(norm):
            return NOT_FINITE, steps, norm
        if steps == max_steps:
            break
        if rule == CHORD and kept[0] == 1:
            status, E1, E2, norm = _step(problem, horizon, T, E, E1, E2, norm, rule, damping, False)
            if status == CONVERGED:
                continue
        shooting_jacobian(body, data, zones, track, R, Pi, u, lam, W, T, E, estimated)
        kept[0] = 1
        status, E1, E2, norm = _step(problem, horizon, T, E, E1, E2, norm, rule, damping, True)
    return MAX_ITERATIONS, max_steps, norm
