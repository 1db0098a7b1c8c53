"""Kernels of the linear system of one Newton step, by a Riccati recursion along the stages.

Minimize the sum over stages of 1/2 du' D du + g' du + 1/2 x' M x + gp' dPi with x = (eta, dPi),
subject to the linearized motion of `_stage_kernels`, x_0 = 0 and x_N = b. The multipliers y of the
end are parameters of the recursion, which a system of six equations closes. ``rho`` (2,) times
|eta_N|^2 / 2 and |dPi_N|^2 / 2 makes the program convex where it is so on x_N = b only.
"""

from __future__ import annotations

import math

import numpy as np

from spacecraft_gnc._inner_kernels import inner_kernel
from spacecraft_gnc.lie._mat3_kernels import (
    EYE,
    add,
    inverse,
    load3,
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
    store9_flat,
    transpose,
)
from spacecraft_gnc.ocp.transfer._stage_kernels import A_AT, B_AT, HPE, HPP, PHI

KE, KP, YE, YP, FF = 0, 9, 18, 27, 36  # columns of ``gains`` (N, 39)


@inner_kernel
def is_positive(R):
    """Whether a symmetric 3 x 3 matrix is positive definite."""
    if not R[0] > 0.0:
        return False
    d1 = R[4] - R[1] * R[1] / R[0]
    if not d1 > 1e-14 * abs(R[4]):
        return False
    e = R[5] - R[1] * R[2] / R[0]
    return R[8] - R[2] * R[2] / R[0] - e * e / d1 > 1e-14 * abs(R[8])


@inner_kernel
def symmetric(A):
    """Symmetric part of A."""
    a, b, c = 0.5 * (A[1] + A[3]), 0.5 * (A[2] + A[6]), 0.5 * (A[5] + A[7])
    return (A[0], a, b, a, A[4], c, b, c, A[8])


@inner_kernel
def rows(d, A):
    """Product diag(d) A."""
    return (
        d[0] * A[0], d[0] * A[1], d[0] * A[2],
        d[1] * A[3], d[1] * A[4], d[1] * A[5],
        d[2] * A[6], d[2] * A[7], d[2] * A[8],
    )  # fmt: skip


@inner_kernel
def add_block(G, i, j, A):
    """Subtract A from a 3 x 3 block of G."""
    for r in range(3):
        for c in range(3):
            G[i + r, j + c] -= A[3 * r + c]


@inner_kernel
def backward(h, stage, D, g, Dp, gp, gap, rho, gains, G, s):
    """Backward pass: gains, and x_N = G y + s; whether every block of the torque is positive."""
    N = D.shape[0]
    zero = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    E, X, Q = mat_scale(rho[0], EYE), zero, mat_scale(rho[1], EYE)
    ee, ep, pe, pp = EYE, zero, zero, EYE  # of Y: rows eta, dPi; columns y_eta, y_Pi
    ve, vp = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    G[:] = 0.0
    s[:] = 0.0
    hh = h * h
    for k in range(N - 1, -1, -1):
        d, r = load3(D, k), load3(gap, k)
        R = (
            d[0] + hh * Q[0], hh * Q[1], hh * Q[2],
            hh * Q[3], d[1] + hh * Q[4], hh * Q[5],
            hh * Q[6], hh * Q[7], d[2] + hh * Q[8],
        )  # fmt: skip
        if not is_positive(R):
            return False
        Ri, _ = inverse(R)
        Ri = symmetric(Ri)
        Phi, B, A = (
            load9_flat(stage, k, PHI), load9_flat(stage, k, B_AT), load9_flat(stage, k, A_AT),
        )  # fmt: skip
        # Feed-forward and the response of the end.
        qe, qp = add(ve, mat_vec(X, r)), add(vp, mat_vec(Q, r))
        ff = scale(-1.0, mat_vec(Ri, add(scale(h, qp), load3(g, k))))
        hf = scale(h, ff)
        w = add(r, hf)
        a, b = mat_t_vec(pe, w), mat_t_vec(pp, w)
        for i in range(3):
            s[i] += a[i]
            s[3 + i] += b[i]
        Re, Rp = mat_mat(Ri, pe), mat_mat(Ri, pp)
        add_block(G, 0, 0, mat_scale(hh, mat_t_mat(pe, Re)))
        add_block(G, 0, 3, mat_scale(hh, mat_t_mat(pe, Rp)))
        add_block(G, 3, 0, mat_scale(hh, mat_t_mat(pp, Re)))
        add_block(G, 3, 3, mat_scale(hh, mat_t_mat(pp, Rp)))
        # Gains.
        Xt = transpose(X)
        RX, RQ = mat_mat(Ri, Xt), mat_mat(Ri, Q)
        store9_flat(gains, k, mat_scale(-h, mat_mat(RX, Phi)), KE)
        store9_flat(gains, k, mat_scale(-h, mat_add(mat_mat(RX, B), mat_mat(RQ, A))), KP)
        store9_flat(gains, k, mat_scale(-h, Re), YE)
        store9_flat(gains, k, mat_scale(-h, Rp), YP)
        store3(gains, k, ff, FF)
        # S = P - h^2 P_:p Ri P_p:, and I - h^2 Q Ri = D Ri: no cancellation where Q is large.
        See = symmetric(mat_sub(E, mat_scale(hh, mat_mat(X, RX))))
        Sep = transpose(rows(d, RX))
        Spp = symmetric(rows(d, RQ))
        U = mat_add(mat_mat(See, B), mat_mat(Sep, A))
        V = mat_add(mat_t_mat(Sep, B), mat_mat(Spp, A))
        ne = add(qe, mat_vec(X, hf))
        np_ = add(qp, mat_vec(Q, hf))
        ve = mat_t_vec(Phi, ne)
        vp = add(add(mat_t_vec(B, ne), mat_t_vec(A, np_)), load3(gp, k))
        E = symmetric(mat_t_mat(Phi, mat_mat(See, Phi)))
        X = mat_add(mat_t_mat(Phi, U), transpose(load9_flat(stage, k, HPE)))
        Q = symmetric(mat_add(mat_add(mat_t_mat(B, U), mat_t_mat(A, V)), load9_flat(stage, k, HPP)))
        c = load3(Dp, k)
        Q = (Q[0] + c[0], Q[1], Q[2], Q[3], Q[4] + c[1], Q[5], Q[6], Q[7], Q[8] + c[2])
        XR = transpose(RX)
        te, tp = (
            mat_sub(ee, mat_scale(hh, mat_mat(XR, pe))),
            mat_sub(ep, mat_scale(hh, mat_mat(XR, pp))),
        )
        be, bp = rows(d, Re), rows(d, Rp)
        ee, ep = mat_t_mat(Phi, te), mat_t_mat(Phi, tp)
        pe = mat_add(mat_t_mat(B, te), mat_t_mat(A, be))
        pp = mat_add(mat_t_mat(B, tp), mat_t_mat(A, bp))
    return True


@inner_kernel
def close_end(G, s, b, y):
    """Solve G y = b - s by scaled elimination; tell whether there is an answer."""
    n = 6
    T, size = np.empty((n, n)), np.empty(n)
    for i in range(n):
        size[i] = 1.0 / math.sqrt(abs(G[i, i])) if G[i, i] != 0.0 else 1.0
    for i in range(n):
        y[i] = (b[i] - s[i]) * size[i]
        for j in range(n):
            T[i, j] = G[i, j] * size[i] * size[j]
    for c in range(n):
        best = c
        for i in range(c + 1, n):
            if abs(T[i, c]) > abs(T[best, c]):
                best = i
        if not abs(T[best, c]) > 1e-14:
            return False
        if best != c:
            for j in range(n):
                T[c, j], T[best, j] = T[best, j], T[c, j]
            y[c], y[best] = y[best], y[c]
        for i in range(c + 1, n):
            f = T[i, c] / T[c, c]
            for j in range(c, n):
                T[i, j] -= f * T[c, j]
            y[i] -= f * y[c]
    for c in range(n - 1, -1, -1):
        v = y[c]
        for j in range(c + 1, n):
            v -= T[c, j] * y[j]
        y[c] = v / T[c, c]
    for i in range(n):
        y[i] *= size[i]
    return True


@inner_kernel
def forward(h, stage, gains, gap, y, du, dPi):
    """Forward pass: du (N, 3) and dPi (N+1, 3)."""
    N = du.shape[0]
    ye, yp = (y[0], y[1], y[2]), (y[3], y[4], y[5])
    eta, p = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    store3(dPi, 0, p)
    for k in range(N):
        v = add(mat_vec(load9_flat(gains, k, KE), eta), mat_vec(load9_flat(gains, k, KP), p))
        v = add(
            v, add(mat_vec(load9_flat(gains, k, YE), ye), mat_vec(load9_flat(gains, k, YP), yp))
        )
        v = add(v, load3(gains, k, FF))
        store3(du, k, v)
        eta = add(mat_vec(load9_flat(stage, k, PHI), eta), mat_vec(load9_flat(stage, k, B_AT), p))
        p = add(add(mat_vec(load9_flat(stage, k, A_AT), p), scale(h, v)), load3(gap, k))
        store3(dPi, k + 1, p)


@inner_kernel
def newton_step(h, stage, D, g, Dp, gp, gap, rho, end, gains, G, s, y, du, dPi, lam):
    """Step du, dPi to eta_N = -end, dPi_N = 0, with the new multipliers ``lam``, and y of the end.

    Returns 0, or 1: not convex, or 2: singular.
    """
    if not backward(h, stage, D, g, Dp, gp, gap, rho, gains, G, s):
        return 1
    b = np.zeros(6)
    b[0], b[1], b[2] = -end[0], -end[1], -end[2]
    if not close_end(G, s, b, y):
        return 2
    forward(h, stage, gains, gap, y, du, dPi)
    for i in range(3):
        y[i] += rho[0] * b[i]
    for k in range(du.shape[0]):
        for i in range(3):
            lam[k, i] = -(D[k, i] * du[k, i] + g[k, i]) / h
    return 0
