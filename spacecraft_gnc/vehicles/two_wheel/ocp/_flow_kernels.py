"""Kernels of the prediction models: attitude over a step, its derivatives and its coordinates.

``model``: 0 simplified, 1 euler_321, 2 so3. An attitude ``a`` holds roll, pitch, yaw (3) in the
simplified model, and the quaternion q0, q of the error (4) in the others, whose flow is exact up to
the fourth order of Magnus' expansion: q_k+1 = q_k exp(Omega / 2),

    Omega = T (w0 + w1) / 2 + T^2 / 12 w0 x w1,    w = C nu + drift,

for a rate w that is linear in time. Everything is in the prediction frame, in which the third row
of ``C`` (3, 2) is zero. `sqp` documents the use, docs/underactuated.md the derivation.
"""

from __future__ import annotations

import math

import numpy as np

from spacecraft_gnc._inner_kernels import inner_kernel
from spacecraft_gnc._kernels import kernel

SIMPLIFIED, EULER_321, SO3 = 0, 1, 2
# s(t) = sin(sqrt(t) / 2) / sqrt(t) = sum of SERIES[k] t^k: 13 terms, exact to rounding up to 2 pi.
SERIES = tuple((-1.0) ** k * 0.5 / (4.0**k * math.factorial(2 * k + 1)) for k in range(13))
_LEAST_COSINE = 1e-12  # of the squared cosine of pitch: keeps the chart finite at its singularity


@inner_kernel
def half_sine(t):
    """s(t), s'(t), s''(t) with s(t) = sin(sqrt(t) / 2) / sqrt(t)."""
    s, d, dd = 0.0, 0.0, 0.0
    for k in range(len(SERIES) - 1, -1, -1):
        dd = dd * t + 2.0 * d
        d = d * t + s
        s = s * t + SERIES[k]
    return s, d, dd


@kernel
def rates(C, drift, k, nu, w):
    """Rates (2, 3) at the start and the end of step k."""
    for j in range(2):
        for i in range(3):
            w[j, i] = C[i, 0] * nu[k + j, 0] + C[i, 1] * nu[k + j, 1] + drift[k + j, i]


@kernel
def turn(T, w, Omega, d):
    """Rotation vector of a step into ``Omega`` (3,), its quaternion into ``d`` (4,); s, s', s''."""
    h = T * T / 12.0
    Omega[0] = 0.5 * T * (w[0, 0] + w[1, 0]) + h * (w[0, 1] * w[1, 2] - w[0, 2] * w[1, 1])
    Omega[1] = 0.5 * T * (w[0, 1] + w[1, 1]) + h * (w[0, 2] * w[1, 0] - w[0, 0] * w[1, 2])
    Omega[2] = 0.5 * T * (w[0, 2] + w[1, 2]) + h * (w[0, 0] * w[1, 1] - w[0, 1] * w[1, 0])
    t = Omega[0] * Omega[0] + Omega[1] * Omega[1] + Omega[2] * Omega[2]
    s, ds, dds = half_sine(t)
    d[0] = 1.0 - 0.5 * t * quarter_cosine(t)
    for i in range(3):
        d[1 + i] = s * Omega[i]
    return s, ds, dds


@inner_kernel
def quarter_cosine(t):
    """(1 - cos(sqrt(t) / 2)) / (t / 2) = 1/4 (sin(x) / x)^2 with x = sqrt(t) / 4."""
    s, _, _ = half_sine(0.25 * t)  # sin(sqrt(t) / 4) / (sqrt(t) / 2)
    return s * s


@kernel
def advance(model, T, C, drift, k, nu, a, w, Omega, d):
    """Attitude of node k + 1 from that of node k."""
    rates(C, drift, k, nu, w)
    if model == SIMPLIFIED:
        for i in range(3):
            a[k + 1, i] = a[k, i] + 0.5 * T * (w[0, i] + w[1, i])
        area = 3.0 * w[0, 1] * w[0, 0] + w[0, 1] * w[1, 0] + 5.0 * w[1, 1] * w[0, 0]
        area += 3.0 * w[1, 1] * w[1, 0]
        a[k + 1, 2] += 0.5 * T * (w[0, 1] + w[1, 1]) * a[k, 0] + T * T / 24.0 * area
        return
    turn(T, w, Omega, d)
    q0, x, y, z = a[k, 0], a[k, 1], a[k, 2], a[k, 3]
    a[k + 1, 0] = q0 * d[0] - x * d[1] - y * d[2] - z * d[3]
    a[k + 1, 1] = q0 * d[1] + d[0] * x + y * d[3] - z * d[2]
    a[k + 1, 2] = q0 * d[2] + d[0] * y + z * d[1] - x * d[3]
    a[k + 1, 3] = q0 * d[3] + d[0] * z + x * d[2] - y * d[1]


@inner_kernel
def turn_derivatives(T, C, w, V):
    """Derivatives (3, 4) of the rotation vector by nu_k and nu_k+1, two columns each."""
    h = T * T / 12.0
    for j in range(2):
        x, y, z = C[0, j], C[1, j], C[2, j]
        V[0, j] = 0.5 * T * x + h * (y * w[1, 2] - z * w[1, 1])
        V[1, j] = 0.5 * T * y + h * (z * w[1, 0] - x * w[1, 2])
        V[2, j] = 0.5 * T * z + h * (x * w[1, 1] - y * w[1, 0])
        V[0, 2 + j] = 0.5 * T * x + h * (w[0, 1] * z - w[0, 2] * y)
        V[1, 2 + j] = 0.5 * T * y + h * (w[0, 2] * x - w[0, 0] * z)
        V[2, 2 + j] = 0.5 * T * z + h * (w[0, 0] * y - w[0, 1] * x)


@kernel
def linearize(model, T, C, drift, k, nu, a, A, D, w, Omega, d, V):
    """Derivatives of the attitude of node k + 1: A (na, na) by that of node k, D (na, 4) by nu."""
    rates(C, drift, k, nu, w)
    A[:] = 0.0
    if model == SIMPLIFIED:
        for i in range(3):
            A[i, i] = 1.0
            for j in range(2):
                D[i, j] = D[i, 2 + j] = 0.5 * T * C[i, j]
        A[2, 0] = 0.5 * T * (w[0, 1] + w[1, 1])
        h = T * T / 24.0
        for j in range(2):
            x, y = C[0, j], C[1, j]
            pull = 0.5 * T * y * a[k, 0]
            D[2, j] += pull + h * (
                3.0 * (y * w[0, 0] + w[0, 1] * x) + y * w[1, 0] + 5.0 * w[1, 1] * x
            )
            D[2, 2 + j] += pull + h * (
                w[0, 1] * x + 5.0 * y * w[0, 0] + 3.0 * (y * w[1, 0] + w[1, 1] * x)
            )
        return
    s, ds, _ = turn(T, w, Omega, d)
    turn_derivatives(T, C, w, V)
    A[0, 0] = A[1, 1] = A[2, 2] = A[3, 3] = d[0]
    A[1, 0] = A[2, 3] = d[1]
    A[0, 1] = A[3, 2] = -d[1]
    A[2, 0] = A[3, 1] = d[2]
    A[0, 2] = A[1, 3] = -d[2]
    A[3, 0] = A[1, 2] = d[3]
    A[0, 3] = A[2, 1] = -d[3]
    q0, x, y, z = a[k, 0], a[k, 1], a[k, 2], a[k, 3]
    for j in range(4):
        along = Omega[0] * V[0, j] + Omega[1] * V[1, j] + Omega[2] * V[2, j]
        e0 = -0.5 * s * along
        e1 = s * V[0, j] + 2.0 * ds * along * Omega[0]
        e2 = s * V[1, j] + 2.0 * ds * along * Omega[1]
        e3 = s * V[2, j] + 2.0 * ds * along * Omega[2]
        D[0, j] = q0 * e0 - x * e1 - y * e2 - z * e3
        D[1, j] = x * e0 + q0 * e1 - z * e2 + y * e3
        D[2, j] = y * e0 + z * e1 + q0 * e2 - x * e3
        D[3, j] = z * e0 - y * e1 + x * e2 + q0 * e3


@kernel
def curvature(model, T, C, drift, k, nu, a, lam, X, H, w, Omega, d, V):
    """Second derivatives of ``lam`` . attitude of node k + 1: X (na, 4) mixed, H (4, 4) by nu.

    By the attitude alone they are zero: both flows are linear in it.
    """
    X[:] = 0.0
    rates(C, drift, k, nu, w)
    if model == SIMPLIFIED:
        h = T * T / 24.0 * lam[2]
        for i in range(2):
            X[0, i] = X[0, 2 + i] = 0.5 * T * C[1, i] * lam[2]
            for j in range(2):
                yx, xy = C[1, i] * C[0, j], C[0, i] * C[1, j]
                H[i, j] = 3.0 * h * (yx + xy)
                H[2 + i, 2 + j] = 3.0 * h * (yx + xy)
                H[i, 2 + j] = h * (yx + 5.0 * xy)
                H[2 + i, j] = h * (xy + 5.0 * yx)
        return
    s, ds, dds = turn(T, w, Omega, d)
    turn_derivatives(T, C, w, V)
    q0, x, y, z = a[k, 0], a[k, 1], a[k, 2], a[k, 3]
    m0 = q0 * lam[0] + x * lam[1] + y * lam[2] + z * lam[3]
    m1 = -x * lam[0] + q0 * lam[1] + z * lam[2] - y * lam[3]
    m2 = -y * lam[0] - z * lam[1] + q0 * lam[2] + x * lam[3]
    m3 = -z * lam[0] + y * lam[1] - x * lam[2] + q0 * lam[3]
    mo = m1 * Omega[0] + m2 * Omega[1] + m3 * Omega[2]
    # Gradient g (3,) and Hessian of m . d by the rotation vector; c' = -s/4, c'' = -s'/4.
    flat = -0.5 * m0 * s + 2.0 * ds * mo
    steep = -m0 * ds + 4.0 * dds * mo
    g1 = flat * Omega[0] + s * m1
    g2 = flat * Omega[1] + s * m2
    g3 = flat * Omega[2] + s * m3
    twist = (
        T
        * T
        / 12.0
        * (
            g1 * (C[1, 0] * C[2, 1] - C[2, 0] * C[1, 1])
            + g2 * (C[2, 0] * C[0, 1] - C[0, 0] * C[2, 1])
            + g3 * (C[0, 0] * C[1, 1] - C[1, 0] * C[0, 1])
        )
    )
    for i in range(4):
        oi = Omega[0] * V[0, i] + Omega[1] * V[1, i] + Omega[2] * V[2, i]
        mi = m1 * V[0, i] + m2 * V[1, i] + m3 * V[2, i]
        e0 = -0.5 * s * oi
        e1 = s * V[0, i] + 2.0 * ds * oi * Omega[0]
        e2 = s * V[1, i] + 2.0 * ds * oi * Omega[1]
        e3 = s * V[2, i] + 2.0 * ds * oi * Omega[2]
        X[0, i] = e0 * lam[0] + e1 * lam[1] + e2 * lam[2] + e3 * lam[3]
        X[1, i] = -e1 * lam[0] + e0 * lam[1] - e3 * lam[2] + e2 * lam[3]
        X[2, i] = -e2 * lam[0] + e3 * lam[1] + e0 * lam[2] - e1 * lam[3]
        X[3, i] = -e3 * lam[0] - e2 * lam[1] + e1 * lam[2] + e0 * lam[3]
        for j in range(4):
            oj = Omega[0] * V[0, j] + Omega[1] * V[1, j] + Omega[2] * V[2, j]
            mj = m1 * V[0, j] + m2 * V[1, j] + m3 * V[2, j]
            vv = V[0, i] * V[0, j] + V[1, i] * V[1, j] + V[2, i] * V[2, j]
            H[i, j] = flat * vv + steep * oi * oj + 2.0 * ds * (mi * oj + oi * mj)
    H[0, 3] += twist
    H[3, 0] += twist
    H[1, 2] -= twist
    H[2, 1] -= twist


@kernel
def chart(model, a, e, E):
    """Coordinates e (3,) of an attitude, about its angle from the reference, and E = de/da."""
    E[:] = 0.0
    if model == SIMPLIFIED:
        for i in range(3):
            e[i] = a[i]
            E[i, i] = 1.0
    elif model == SO3:
        for i in range(3):
            e[i] = 2.0 * a[1 + i]
            E[i, 1 + i] = 2.0
    else:
        q0, x, y, z = a[0], a[1], a[2], a[3]
        sine, cosine = 2.0 * (y * z + q0 * x), q0 * q0 - x * x - y * y + z * z
        r = sine * sine + cosine * cosine
        e[0] = math.atan2(sine, cosine)
        E[0, 0] = 2.0 * (cosine * x - sine * q0) / r
        E[0, 1] = 2.0 * (cosine * q0 + sine * x) / r
        E[0, 2] = 2.0 * (cosine * z + sine * y) / r
        E[0, 3] = 2.0 * (cosine * y - sine * z) / r
        p = min(max(2.0 * (q0 * y - x * z), -1.0), 1.0)
        e[1] = math.asin(p)
        root = math.sqrt(max(1.0 - p * p, _LEAST_COSINE))
        E[1, 0], E[1, 1], E[1, 2], E[1, 3] = 2.0 * y, -2.0 * z, 2.0 * q0, -2.0 * x
        for i in range(4):
            E[1, i] /= root
        sine, cosine = 2.0 * (x * y + q0 * z), q0 * q0 + x * x - y * y - z * z
        r = sine * sine + cosine * cosine
        e[2] = math.atan2(sine, cosine)
        E[2, 0] = 2.0 * (cosine * z - sine * q0) / r
        E[2, 1] = 2.0 * (cosine * y - sine * x) / r
        E[2, 2] = 2.0 * (cosine * x + sine * y) / r
        E[2, 3] = 2.0 * (cosine * q0 + sine * z) / r


@kernel
def add_chart_curvature(model, a, weights, M):
    """Add sum of weights[i] d2e_i/da2 to M (na, na); zero but for euler_321."""
    if model != EULER_321:
        return
    q0, x, y, z = a[0], a[1], a[2], a[3]
    g, f, v = np.empty(4), np.empty(4), np.empty(4)
    for which in range(0, 3, 2):
        if which == 0:
            sine, cosine = 2.0 * (y * z + q0 * x), q0 * q0 - x * x - y * y + z * z
            g[0], g[1], g[2], g[3] = 2.0 * x, 2.0 * q0, 2.0 * z, 2.0 * y
            f[0], f[1], f[2], f[3] = 2.0 * q0, -2.0 * x, -2.0 * y, 2.0 * z
        else:
            sine, cosine = 2.0 * (x * y + q0 * z), q0 * q0 + x * x - y * y - z * z
            g[0], g[1], g[2], g[3] = 2.0 * z, 2.0 * y, 2.0 * x, 2.0 * q0
            f[0], f[1], f[2], f[3] = 2.0 * q0, 2.0 * x, -2.0 * y, -2.0 * z
        r = sine * sine + cosine * cosine
        c = weights[which] / r
        for i in range(4):
            v[i] = cosine * g[i] - sine * f[i]
        for i in range(4):
            for j in range(4):
                M[i, j] += c * (g[i] * f[j] - f[i] * g[j])
                M[i, j] -= c * v[i] * (2.0 * cosine * f[j] + 2.0 * sine * g[j]) / r
        # Second derivatives of sine and cosine themselves.
        if which == 0:
            M[2, 3] += c * cosine * 2.0
            M[3, 2] += c * cosine * 2.0
            M[0, 1] += c * cosine * 2.0
            M[1, 0] += c * cosine * 2.0
            M[0, 0] -= c * sine * 2.0
            M[1, 1] += c * sine * 2.0
            M[2, 2] += c * sine * 2.0
            M[3, 3] -= c * sine * 2.0
        else:
            M[1, 2] += c * cosine * 2.0
            M[2, 1] += c * cosine * 2.0
            M[0, 3] += c * cosine * 2.0
            M[3, 0] += c * cosine * 2.0
            M[0, 0] -= c * sine * 2.0
            M[1, 1] -= c * sine * 2.0
            M[2, 2] += c * sine * 2.0
            M[3, 3] += c * sine * 2.0
    p = min(max(2.0 * (q0 * y - x * z), -1.0), 1.0)
    square = max(1.0 - p * p, _LEAST_COSINE)
    c = weights[1] / math.sqrt(square)
    g[0], g[1], g[2], g[3] = 2.0 * y, -2.0 * z, 2.0 * q0, -2.0 * x
    for i in range(4):
        for j in range(4):
            M[i, j] += c * p / square * g[i] * g[j]
    M[0, 2] += 2.0 * c
    M[2, 0] += 2.0 * c
    M[1, 3] -= 2.0 * c
    M[3, 1] -= 2.0 * c
