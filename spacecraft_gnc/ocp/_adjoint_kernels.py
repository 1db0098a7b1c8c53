"""Kernels on a given control sequence: rollout, gradient by the adjoint, reduced Hessian.

The same stage quantities as in `_shooting_kernels`, but with the costates swept backward.
"""

from __future__ import annotations

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
    load3,
    load9,
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
    store9,
    store9_flat,
    sub,
    trace_minus,
    transpose,
    vee_antisymmetric,
)
from spacecraft_gnc.ocp._stage_kernels import (
    ALPHA,
    D_Q3,
    M_AT,
    MU0,
    P_AT,
    S_P2,
    S_Q2,
    SIGMA_AT,
    V_Q3,
    H,
    attitude_gradient,
    attitude_hessian,
    costate_curvature,
    data9,
    momentum_map,
)


@kernel
def rollout(body, data, R, Pi, u, W):
    """Propagate row 0 under u (N,3) and fill the stages of W; returns the number of steps made."""
    h = data[H]
    Jd = body_nonstandard_inertia(body)
    R_k, Pi_k = load9(R, 0), load3(Pi, 0)
    for k in range(u.shape[0]):
        q0, q, ok = relative_quaternion(body, h, Pi_k)
        if not ok:
            return k
        p = rotate_back(q0, q, Pi_k)
        F = rotation_of(q0, q)
        store9_flat(W, k, F)
        store9_flat(W, k, momentum_map(h, Jd, F)[0], M_AT)
        store3(W, k, p, P_AT)
        W[k, SIGMA_AT] = -1.0
        R_k = rotate_rows(q0, q, R_k)
        Pi_k = add(p, scale(h, load3(u, k)))
        store9(R, k + 1, R_k)
        store3(Pi, k + 1, Pi_k)
    return u.shape[0]


@kernel
def control_weight(data):
    """Matrix S3 = (tr(Q3) I - Q3)/2 from its eigenvectors."""
    V = data9(data, V_Q3)
    d0, d1, d2 = data[D_Q3], data[D_Q3 + 1], data[D_Q3 + 2]
    VD = (
        V[0] * d0, V[1] * d1, V[2] * d2,
        V[3] * d0, V[4] * d1, V[5] * d2,
        V[6] * d0, V[7] * d1, V[8] * d2,
    )  # fmt: skip
    return mat_mat(VD, transpose(V))


@kernel
def adjoint_gradient(data, zones, track, R, Pi, u, lam, W, gradient):
    """Sweep (34)-(37) backward into lam (N,6); gradient (N,3) of the cost by (38)."""
    N = u.shape[0]
    h, alpha, mu0 = data[H], data[ALPHA], data[MU0]
    S2, S3 = data9(data, S_Q2), control_weight(data)
    B = load9(track, 0)
    l1 = vee_antisymmetric(mat_t_mat(load9(R, N), load9(track, 1)))
    l2 = scale(-1.0, mat_vec(data9(data, S_P2), load3(Pi, N)))
    for k in range(N - 1, -1, -1):
        store3(lam, k, l1)
        store3(lam, k, l2, 3)
        u_k = load3(u, k)
        excess = max(0.0, dot(u_k, u_k) - alpha) if alpha > 0.0 else 0.0
        pull = add(mat_vec(S3, u_k), scale(2.0 * mu0 * excess, u_k))
        store3(gradient, k, scale(2.0 * h, sub(pull, l2)))
        if k > 0:
            F, M, p = load9_flat(W, k), load9_flat(W, k, M_AT), load3(W, k, P_AT)
            C = mat_add(F, transpose(hat_mat(p, M)))
            swept = add(mat_vec(C, l2), mat_t_vec(M, l1))
            l2 = sub(swept, scale(h, mat_vec(S2, load3(Pi, k))))
            l1 = sub(mat_vec(F, l1), attitude_gradient(h, B, zones, load9(R, k)))


@kernel
def reduced_hessian(body, data, zones, track, R, Pi, u, lam, W, states, hessian):
    """Second derivative (3N, 3N) of the cost to the controls at a rollout with its costates.

    ``states`` (N+1, 6) is work space for (eta, delta Pi) of one column.
    """
    N = u.shape[0]
    h, alpha, mu0 = data[H], data[ALPHA], data[MU0]
    Jd = body_nonstandard_inertia(body)
    S2, S3, SP = data9(data, S_Q2), control_weight(data), data9(data, S_P2)
    bend = mat_scale(-0.5, trace_minus(mat_t_mat(load9(R, N), load9(track, 1))))
    B = load9(track, 0)
    zero = (0.0, 0.0, 0.0)
    for column in range(3 * N):
        k0, i0 = column // 3, column % 3
        unit = (1.0 if i0 == 0 else 0.0, 1.0 if i0 == 1 else 0.0, 1.0 if i0 == 2 else 0.0)
        eta, d_Pi = zero, scale(h, unit)
        for k in range(k0 + 1, N + 1):
            store3(states, k, eta)
            store3(states, k, d_Pi, 3)
            if k < N:
                F, M, p = load9_flat(W, k), load9_flat(W, k, M_AT), load3(W, k, P_AT)
                eta = add(mat_t_vec(F, eta), mat_vec(M, d_Pi))
                d_Pi = mat_vec(mat_add(transpose(F), hat_mat(p, M)), d_Pi)
        d_l1 = mat_vec(bend, load3(states, N))
        d_l2 = scale(-1.0, mat_vec(SP, load3(states, N, 3)))
        for k in range(N - 1, k0 - 1, -1):
            row = scale(-2.0 * h, d_l2)
            for i in range(3):
                hessian[3 * k + i, column] = row[i]
            if k > k0:
                F, M, p = load9_flat(W, k), load9_flat(W, k, M_AT), load3(W, k, P_AT)
                l1, l2 = load3(lam, k), load3(lam, k, 3)
                A = mat_add(transpose(F), hat_mat(p, M))
                G = attitude_hessian(h, B, zones, load9(R, k))
                Z = costate_curvature(h, S2, Jd, F, M, A, l1, l2, p)
                eta, d_Pi = load3(states, k), load3(states, k, 3)
                swept = add(mat_t_vec(A, d_l2), mat_t_vec(M, d_l1))
                turned = sub(d_l1, mat_vec(hat_mat(l1, M), d_Pi))
                d_l2 = sub(swept, mat_vec(Z, d_Pi))
                d_l1 = sub(mat_vec(F, turned), mat_vec(G, eta))
        u_k = load3(u, k0)
        sigma = W[k0, SIGMA_AT]
        if sigma < 0.0:
            sigma = 2.0 * mu0 * max(0.0, dot(u_k, u_k) - alpha) if alpha > 0.0 else 0.0
        D = S3
        if sigma > 0.0:
            D = mat_add(D, mat_scale(4.0 * mu0, outer(u_k, u_k)))
        for i in range(3):
            hessian[3 * k0 + i, column] += 2.0 * h * (D[3 * i + i0] + (sigma if i == i0 else 0.0))
    # The part above the block diagonal was not swept: mirror it.
    for r in range(3 * N):
        for c in range(3 * N):
            if c // 3 > r // 3:
                hessian[r, c] = hessian[c, r]
