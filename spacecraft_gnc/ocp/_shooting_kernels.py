"""Kernels of indirect single shooting on the conditions (31)-(45) of Gupta 2015; see `shooting`.

Arrays of one horizon: R (N+1,3,3), Pi (N+1,3), u (N,3), lam (N,6) = (lam1, lam2), W (N, WORK) with
F (9), M (9), p = F^T Pi (3), sigma (1) of each stage. ``track`` (2,3,3) holds Q1 R_ref, P1 R_ref.
"""

from __future__ import annotations

import math

from spacecraft_gnc._kernels import kernel
from spacecraft_gnc.dynamics._lgvi_kernels import (
    body_nonstandard_inertia,
    relative_quaternion,
    rotate_back,
    rotate_rows,
    rotation_of,
)
from spacecraft_gnc.lie._mat3_kernels import (
    add,
    dot,
    hat_mat,
    inverse,
    load3,
    load9,
    load9_flat,
    load9_rows,
    mat_add,
    mat_scale,
    mat_t_mat,
    mat_t_vec,
    mat_vec,
    scale,
    store3,
    store9,
    store9_flat,
    sub,
    trace_minus,
    transpose,
    vee_antisymmetric,
)
from spacecraft_gnc.ocp._stage_kernels import (
    M_AT,
    P_AT,
    S_P2,
    S_Q2,
    SIGMA_AT,
    H,
    attitude_gradient,
    attitude_hessian,
    control,
    control_sensitivity,
    costate_curvature,
    data9,
    horizon_cost,
    momentum_map,
    set_track,
)

# Statuses, equal to ocp.Status.
CONVERGED, MAX_ITERATIONS, LINE_SEARCH_FAILED, UNSOLVABLE_STEP, NOT_FINITE, SINGULAR = range(6)
BAD_STATE, BAD_REFERENCE = -1, -2
ROTATION_ERROR_SQUARED = 1e-12  # square of types.ROTATION_TOLERANCE
SUFFICIENT_DECREASE = 1e-4
SMALLEST_STEP = 2.0**-24


@kernel
def propagate_horizon(body, data, zones, track, R, Pi, u, lam, W):
    """Run (31)-(34), (36), (38) forward from row 0; returns a status and the residual (44)."""
    N = u.shape[0]
    h = data[H]
    Jd = body_nonstandard_inertia(body)
    S2 = data9(data, S_Q2)
    B = load9(track, 0)
    R_k, Pi_k = load9(R, 0), load3(Pi, 0)
    l1, l2 = load3(lam, 0), load3(lam, 0, 3)
    zero = (0.0, 0.0, 0.0)
    for k in range(N):
        q0, q, ok = relative_quaternion(body, h, Pi_k)
        if not ok:
            return UNSOLVABLE_STEP, zero, zero
        p = rotate_back(q0, q, Pi_k)
        if k > 0:
            F = rotation_of(q0, q)
            M, det = momentum_map(h, Jd, F)
            l1 = mat_t_vec(F, add(l1, attitude_gradient(h, B, zones, R_k)))
            # C = F - M^T hat(p) = (F^T + hat(p) M)^T
            C_inverse, det_C = inverse(mat_add(F, transpose(hat_mat(p, M))))
            if det == 0.0 or det_C == 0.0:
                return SINGULAR, zero, zero
            rhs = sub(add(l2, scale(h, mat_vec(S2, Pi_k))), mat_t_vec(M, l1))
            l2 = mat_vec(C_inverse, rhs)
            store3(lam, k, l1)
            store3(lam, k, l2, 3)
            store9_flat(W, k, F)
            store9_flat(W, k, M, M_AT)
            store3(W, k, p, P_AT)
        u_k, sigma = control(data, l2)
        W[k, SIGMA_AT] = sigma
        store3(u, k, u_k)
        R_k = rotate_rows(q0, q, R_k)
        Pi_k = add(p, scale(h, u_k))
        store9(R, k + 1, R_k)
        store3(Pi, k + 1, Pi_k)
    E1 = sub(l1, vee_antisymmetric(mat_t_mat(R_k, load9(track, 1))))
    E2 = add(l2, mat_vec(data9(data, S_P2), Pi_k))
    return CONVERGED, E1, E2


@kernel
def shooting_jacobian(body, data, zones, track, R, Pi, u, lam, W, T, E):
    """Derivative of the residual (44) to (lam1_0, lam2_0) by (39)-(45) into E (6,6).

    T (6, 12) carries, for each unknown, (eta, delta Pi, delta lam1, delta lam2) along the horizon.
    """
    N = u.shape[0]
    h = data[H]
    Jd = body_nonstandard_inertia(body)
    S2 = data9(data, S_Q2)
    for j in range(6):
        for i in range(12):
            T[j, i] = 0.0
        T[j, 6 + j] = 1.0
    hU = mat_scale(h, control_sensitivity(data, load3(u, 0), W[0, SIGMA_AT]))
    for j in range(6):
        store3(T, j, mat_vec(hU, load3(T, j, 9)), 3)
    for k in range(1, N):
        F, M = load9_flat(W, k), load9_flat(W, k, M_AT)
        p = load3(W, k, P_AT)
        l1, l2 = load3(lam, k), load3(lam, k, 3)
        A = mat_add(transpose(F), hat_mat(p, M))
        C_inverse, _ = inverse(transpose(A))
        G = attitude_hessian(h, load9(track, 0), zones, load9(R, k))
        D = hat_mat(l1, M)
        Z = costate_curvature(h, S2, Jd, F, M, A, l1, l2, p)
        hU = mat_scale(h, control_sensitivity(data, load3(u, k), W[k, SIGMA_AT]))
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
    bend = mat_scale(0.5, trace_minus(mat_t_mat(load9(R, N), load9(track, 1))))
    SP = data9(data, S_P2)
    for j in range(6):
        e1 = add(load3(T, j, 6), mat_vec(bend, load3(T, j)))
        e2 = add(load3(T, j, 9), mat_vec(SP, load3(T, j, 3)))
        E[0, j], E[1, j], E[2, j] = e1
        E[3, j], E[4, j], E[5, j] = e2


@kernel
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


@kernel
def _norm(E1, E2):
    return math.sqrt(dot(E1, E1) + dot(E2, E2))


@kernel
def _newton(body, data, zones, track, R, Pi, u, lam, W, scratch, tolerance, max_steps):
    """Newton with backtracking on the residual, (43); status, steps, residual norm."""
    T, E, b = scratch[0], scratch[1], scratch[2, 0, :6]
    status, E1, E2 = propagate_horizon(body, data, zones, track, R, Pi, u, lam, W)
    if status != CONVERGED:
        return status, 0, math.inf
    residual = _norm(E1, E2)
    for steps in range(max_steps + 1):
        if residual <= tolerance:
            return CONVERGED, steps, residual
        if not math.isfinite(residual):
            return NOT_FINITE, steps, residual
        if steps == max_steps:
            break
        shooting_jacobian(body, data, zones, track, R, Pi, u, lam, W, T, E)
        b[0], b[1], b[2] = E1
        b[3], b[4], b[5] = E2
        if not solve_linear(E[:, :6], b):
            return SINGULAR, steps, residual
        x1, x2 = load3(lam, 0), load3(lam, 0, 3)
        gamma = 1.0
        while True:
            store3(lam, 0, sub(x1, scale(gamma, (b[0], b[1], b[2]))))
            store3(lam, 0, sub(x2, scale(gamma, (b[3], b[4], b[5]))), 3)
            status, E1, E2 = propagate_horizon(body, data, zones, track, R, Pi, u, lam, W)
            norm = _norm(E1, E2)
            if status == CONVERGED and norm <= (1.0 - SUFFICIENT_DECREASE * gamma) * residual:
                break
            gamma *= 0.5
            if gamma < SMALLEST_STEP:  # leave the last point behind, consistent with its residual
                store3(lam, 0, x1)
                store3(lam, 0, x2, 3)
                propagate_horizon(body, data, zones, track, R, Pi, u, lam, W)
                return LINE_SEARCH_FAILED, steps, residual
        residual = norm
    return MAX_ITERATIONS, max_steps, residual


@kernel
def _is_rotation(R):
    """Whether |R^T R - I|_F^2 is small and det R > 0; false for NaN."""
    S = mat_t_mat(R, R)
    error = 0.0
    for i in range(9):
        e = S[i] - (1.0 if i % 4 == 0 else 0.0)
        error += e * e
    return error <= ROTATION_ERROR_SQUARED and inverse(R)[1] > 0.0


@kernel
def solve_shooting(
    body, data, zones, inputs, R, Pi, u, lam, W, track, scratch, tolerance, max_steps
):
    """Solve from ``inputs`` (9, 3), rows R, Pi, R_ref, lam1, lam2; fills the horizon's arrays.

    ``scratch`` (3, 6, 12) is work space. Returns status (negative: input refused), Newton steps,
    residual norm, cost and the largest |u|^2.
    """
    R_0, Pi_0, R_ref = load9_rows(inputs, 0), load3(inputs, 3), load9_rows(inputs, 4)
    if not _is_rotation(R_0) or not math.isfinite(dot(Pi_0, Pi_0)):
        return BAD_STATE, 0, math.nan, math.nan, math.nan
    if not _is_rotation(R_ref):
        return BAD_REFERENCE, 0, math.nan, math.nan, math.nan
    set_track(data, R_ref, track)
    store9(R, 0, R_0)
    store3(Pi, 0, Pi_0)
    store3(lam, 0, load3(inputs, 7))
    store3(lam, 0, load3(inputs, 8), 3)
    status, steps, residual = _newton(
        body, data, zones, track, R, Pi, u, lam, W, scratch, tolerance, max_steps
    )
    if not math.isfinite(residual):
        return status, steps, residual, math.nan, math.nan
    largest = 0.0
    for k in range(u.shape[0]):
        u_k = load3(u, k)
        largest = max(largest, dot(u_k, u_k))
    return status, steps, residual, horizon_cost(data, zones, track, R, Pi, u, W), largest
