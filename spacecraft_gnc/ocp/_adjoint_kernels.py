"""Kernels on a given control sequence: rollout, gradient by the adjoint, reduced Hessian.

The same stage quantities as in `_sweep_kernels`. Controls are counted in the eigenvectors of their
weight, z = V^T u: see `_stage_kernels`.
"""

from __future__ import annotations

from spacecraft_gnc._inner_kernels import inner_kernel
from spacecraft_gnc._kernels import kernel
from spacecraft_gnc.dynamics._lgvi_kernels import (
    body_nonstandard_inertia,
    relative_quaternion,
    rotate_back,
    rotate_rows,
)
from spacecraft_gnc.lie._mat3_kernels import (
    add,
    dot,
    hat_mat,
    load3,
    load9,
    load9_flat,
    mat_t_vec,
    mat_vec,
    scale,
    store3,
    store9,
    sub,
)
from spacecraft_gnc.ocp._data_kernels import ALPHA, D_U, M_U, MU0, H
from spacecraft_gnc.ocp._stage_kernels import (
    A_AT,
    M_AT,
    SIGMA_AT,
    Z_AT,
    attitude_hessian,
    squared_control,
    stage_curvature,
)
from spacecraft_gnc.ocp._sweep_kernels import store_stage, sweep_costates
from spacecraft_gnc.ocp._terminal_kernels import terminal_hessian
from spacecraft_gnc.ocp._track_kernels import control_reference, stage_weighed


@inner_kernel
def _row(data, i):
    """Torque of the unit control z_i: row i of G."""
    g = D_U + int(data[M_U]) + 3 * i
    return (data[g], data[g + 1], data[g + 2])


@kernel
def rollout(body, data, R, Pi, z, W):
    """Propagate row 0 under z (N, m) and fill the stages of W; returns the number of steps made."""
    h = data[H]
    Jd = body_nonstandard_inertia(body)
    R_k, Pi_k = load9(R, 0), load3(Pi, 0)
    for k in range(z.shape[0]):
        q0, q, ok = relative_quaternion(body, h, Pi_k)
        if not ok:
            return k
        p = rotate_back(q0, q, Pi_k)
        store_stage(h, Jd, W, k, q0, q, p)
        W[k, SIGMA_AT] = -1.0
        torque = (0.0, 0.0, 0.0)
        for i in range(z.shape[1]):
            W[k, Z_AT + i] = z[k, i]
            torque = add(torque, scale(z[k, i], _row(data, i)))
        R_k = rotate_rows(q0, q, R_k)
        Pi_k = add(p, scale(h, torque))
        store9(R, k + 1, R_k)
        store3(Pi, k + 1, Pi_k)
    return z.shape[0]


@inner_kernel
def _sigma(data, W, k):
    """2 mu0 max(0, H0) of stage k."""
    excess = squared_control(W, k) - data[ALPHA]
    return 2.0 * data[MU0] * excess if data[ALPHA] > 0.0 and excess > 0.0 else 0.0


@kernel
def adjoint_gradient(data, zones, track, R, Pi, lam, W, gradient):
    """Sweep (34)-(37) backward into lam (N,6); gradient (N,m) of the cost to z by (38)."""
    N = W.shape[0]
    h = data[H]
    sweep_costates(data, zones, track, R, Pi, lam, W)
    for k in range(N):
        sigma = _sigma(data, W, k)
        for i in range(gradient.shape[1]):
            pull = (data[D_U + i] + sigma) * W[k, Z_AT + i]
            pull -= data[D_U + i] * control_reference(track, gradient.shape[1], i)
            gradient[k, i] = 2.0 * h * (pull - dot(_row(data, i), load3(lam, k, 3)))


@inner_kernel
def _deviation(W, k0, d_Pi, states):
    """Carry delta Pi at step k0 + 1 along the horizon into ``states`` (N+1, 6)."""
    N = W.shape[0]
    eta = (0.0, 0.0, 0.0)
    for k in range(k0 + 1, N + 1):
        store3(states, k, eta)
        store3(states, k, d_Pi, 3)
        if k < N:
            eta = add(mat_t_vec(load9_flat(W, k), eta), mat_vec(load9_flat(W, k, M_AT), d_Pi))
            d_Pi = mat_vec(load9_flat(W, k, A_AT), d_Pi)


@kernel
def reduced_hessian(body, data, zones, track, R, Pi, lam, W, states, hessian):
    """Second derivative (Nm, Nm) of the cost to z at a rollout with its costates.

    ``states`` (N+1, 6) is work space for (eta, delta Pi) of one column.
    """
    N, m = W.shape[0], int(data[M_U])
    h, mu0 = data[H], data[MU0]
    Jd = body_nonstandard_inertia(body)
    V11, V12, V21, V22 = terminal_hessian(data, track, R, Pi)
    for column in range(m * N):
        k0, i0 = column // m, column % m
        _deviation(W, k0, scale(h, _row(data, i0)), states)
        eta, d_Pi = load3(states, N), load3(states, N, 3)
        d_l1 = scale(-1.0, add(mat_vec(V11, eta), mat_vec(V12, d_Pi)))
        d_l2 = scale(-1.0, add(mat_vec(V21, eta), mat_vec(V22, d_Pi)))
        for k in range(N - 1, k0 - 1, -1):
            for i in range(m):
                hessian[m * k + i, column] = -2.0 * h * dot(_row(data, i), d_l2)
            if k > k0:
                F, M, A = load9_flat(W, k), load9_flat(W, k, M_AT), load9_flat(W, k, A_AT)
                l1, l2 = load3(lam, k), load3(lam, k, 3)
                G = attitude_hessian(h, stage_weighed(track, k), zones, load9(R, k))
                Z = stage_curvature(data, Jd, W, k, l1, l2)
                eta, d_Pi = load3(states, k), load3(states, k, 3)
                swept = add(mat_t_vec(A, d_l2), mat_t_vec(M, d_l1))
                turned = sub(d_l1, mat_vec(hat_mat(l1, M), d_Pi))
                d_l2 = sub(swept, mat_vec(Z, d_Pi))
                d_l1 = sub(mat_vec(F, turned), mat_vec(G, eta))
        sigma = _sigma(data, W, k0)
        hessian[column, column] += 2.0 * h * (data[D_U + i0] + sigma)
        if sigma > 0.0:
            for i in range(m):
                pull = 4.0 * mu0 * W[k0, Z_AT + i] * W[k0, Z_AT + i0]
                hessian[m * k0 + i, column] += 2.0 * h * pull
    # The part above the block diagonal was not swept: mirror it.
    for r in range(m * N):
        for c in range(m * N):
            if c // m > r // m:
                hessian[r, c] = hessian[c, r]
