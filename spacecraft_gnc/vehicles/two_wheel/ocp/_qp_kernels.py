"""Kernels of the quadratic program of one SQP step: an interior-point method along the stages.

Minimize the sum over stages of 1/2 z' M_k z + m_k' z with z = (x, u), subject to x_k+1 = A x + B u,
x_0 = 0, bounds on u_k and on the speed part of x_k, and C x_N = b, whose first ``n_soft`` rows may
be missed at a price sigma per unit (l1). x holds the attitude (na) and two speeds. Each iteration
(Mehrotra's predictor and corrector) is one Riccati recursion, in which the multipliers y of C x_N
are parameters, and a small system for y. docs/underactuated.md has the derivation.
"""

from __future__ import annotations

import numpy as np

from spacecraft_gnc._inner_kernels import inner_kernel

SOLVED, NOT_CONVEX, NOT_SOLVED = 0, 1, 2
MOST_ITERATIONS = 50
_TO_BOUNDARY = 0.995
_GAP = 1e-12  # of the complementarity, over the scale of the gradient
_LEAST_SHIFT, _MOST_SHIFT = 1e-5, 1e4  # of the curvature by u, over the scale of the gradient
_SHIFT_RISE, _SHIFT_FALL = 8.0, 4.0
_PULL = 1e-12  # of the shift's gradient, over the same scale
_OPEN = 1e-10  # of the conditions that a full step closes, over what they were


@inner_kernel
def factor(A, B, M, P, Y, K, Ky, R, rho, N, nx, mt, C, extra, G):
    """Backward pass of the matrices: gains K, Ky, P, Y of every stage, and G = d(C x_N)/dy.

    ``extra`` (N, 4): diagonals that the bounds add, of the speeds of x_k+1 and of u_k. Returns
    whether every control block is positive definite.
    """
    W, F = np.empty((nx, nx)), np.empty((2, nx))
    for i in range(nx):
        for j in range(nx):
            v = 0.0
            for r in range(mt):
                v += rho[r] * C[r, i] * C[r, j]
            P[N, i, j] = M[N, i, j] + v
        for r in range(mt):
            Y[N, i, r] = C[r, i]
    G[:] = 0.0
    for k in range(N - 1, -1, -1):
        # W = P A, F = B' P A + cross terms, R = control block.
        for i in range(nx):
            for j in range(nx):
                v = 0.0
                for r in range(nx):
                    v += P[k + 1, i, r] * A[k, r, j]
                W[i, j] = v
        for i in range(2):
            for j in range(nx):
                v = M[k, nx + i, j]
                for r in range(nx):
                    v += B[k, r, i] * W[r, j]
                F[i, j] = v
        r00, r01, r11 = M[k, nx, nx], M[k, nx, nx + 1], M[k, nx + 1, nx + 1]
        r00 += extra[k, 2]
        r11 += extra[k, 3]
        for i in range(nx):
            p0, p1 = 0.0, 0.0
            for r in range(nx):
                p0 += P[k + 1, i, r] * B[k, r, 0]
                p1 += P[k + 1, i, r] * B[k, r, 1]
            r00 += B[k, i, 0] * p0
            r01 += B[k, i, 0] * p1
            r11 += B[k, i, 1] * p1
        det = r00 * r11 - r01 * r01
        if not (r00 > 0.0 and det > 1e-14 * r00 * r11):
            return False
        i00, i01, i11 = r11 / det, -r01 / det, r00 / det
        R[k, 0], R[k, 1], R[k, 2] = i00, i01, i11
        for j in range(nx):
            K[k, 0, j] = -(i00 * F[0, j] + i01 * F[1, j])
            K[k, 1, j] = -(i01 * F[0, j] + i11 * F[1, j])
        for r in range(mt):
            b0, b1 = 0.0, 0.0
            for i in range(nx):
                b0 += B[k, i, 0] * Y[k + 1, i, r]
                b1 += B[k, i, 1] * Y[k + 1, i, r]
            Ky[k, 0, r] = -(i00 * b0 + i01 * b1)
            Ky[k, 1, r] = -(i01 * b0 + i11 * b1)
            for c in range(mt):
                c0, c1 = 0.0, 0.0
                for i in range(nx):
                    c0 += B[k, i, 0] * Y[k + 1, i, c]
                    c1 += B[k, i, 1] * Y[k + 1, i, c]
                G[r, c] += Ky[k, 0, r] * c0 + Ky[k, 1, r] * c1
        for i in range(nx):
            for j in range(nx):
                v = M[k, i, j] + F[0, i] * K[k, 0, j] + F[1, i] * K[k, 1, j]
                for r in range(nx):
                    v += A[k, r, i] * W[r, j]
                P[k, i, j] = v
            for r in range(mt):
                v = F[0, i] * Ky[k, 0, r] + F[1, i] * Ky[k, 1, r]
                for c in range(nx):
                    v += A[k, c, i] * Y[k + 1, c, r]
                Y[k, i, r] = v
        if k > 0:
            P[k, nx - 2, nx - 2] += extra[k - 1, 0]
            P[k, nx - 1, nx - 1] += extra[k - 1, 1]
    return True


@inner_kernel
def backward(A, B, m, extra, K, Ky, R, p, kff, N, nx, mt, s):
    """Backward pass of the vectors: feed-forward kff, and s = C x_N for y = 0.

    ``extra`` (N, 4): what the bounds add to the gradient, placed as in `factor`.
    """
    for i in range(nx):
        p[N, i] = m[N, i]
    s[:] = 0.0
    for k in range(N - 1, -1, -1):
        r0, r1 = m[k, nx] + extra[k, 2], m[k, nx + 1] + extra[k, 3]
        for i in range(nx):
            r0 += B[k, i, 0] * p[k + 1, i]
            r1 += B[k, i, 1] * p[k + 1, i]
        kff[k, 0] = -(R[k, 0] * r0 + R[k, 1] * r1)
        kff[k, 1] = -(R[k, 1] * r0 + R[k, 2] * r1)
        for r in range(mt):
            s[r] += Ky[k, 0, r] * r0 + Ky[k, 1, r] * r1
        for i in range(nx):
            v = m[k, i] + K[k, 0, i] * r0 + K[k, 1, i] * r1
            for c in range(nx):
                v += A[k, c, i] * p[k + 1, c]
            p[k, i] = v
        if k > 0:
            p[k, nx - 2] += extra[k - 1, 0]
            p[k, nx - 1] += extra[k - 1, 1]


@inner_kernel
def forward(A, B, K, Ky, kff, y, x, u, N, nx, mt):
    """Forward pass: the minimizer for given multipliers."""
    x[0, :] = 0.0
    for k in range(N):
        for i in range(2):
            v = kff[k, i]
            for j in range(nx):
                v += K[k, i, j] * x[k, j]
            for r in range(mt):
                v += Ky[k, i, r] * y[r]
            u[k, i] = v
        for i in range(nx):
            v = B[k, i, 0] * u[k, 0] + B[k, i, 1] * u[k, 1]
            for j in range(nx):
                v += A[k, i, j] * x[k, j]
            x[k + 1, i] = v


@inner_kernel
def solve_small(S, r, n):
    """Solve S x = r in place (pivoted elimination); tell whether S is regular."""
    for c in range(n):
        best = c
        for i in range(c + 1, n):
            if abs(S[i, c]) > abs(S[best, c]):
                best = i
        if S[best, c] == 0.0 or not np.isfinite(S[best, c]):
            return False
        if best != c:
            for j in range(n):
                S[c, j], S[best, j] = S[best, j], S[c, j]
            r[c], r[best] = r[best], r[c]
        for i in range(c + 1, n):
            f = S[i, c] / S[c, c]
            for j in range(c, n):
                S[i, j] -= f * S[c, j]
            r[i] -= f * r[c]
    for c in range(n - 1, -1, -1):
        v = r[c]
        for j in range(c + 1, n):
            v -= S[c, j] * r[j]
        r[c] = v / S[c, c]
    return True


@inner_kernel
def terminal_response(G, s, rho, mt, Ge, se):
    """Response of C x_N to y without the convexifying term: (I + G rho)^-1 (G, s)."""
    S, column = np.empty((mt, mt)), np.empty(mt)
    for c in range(mt + 1):
        for i in range(mt):
            for j in range(mt):
                S[i, j] = G[i, j] * rho[j] + (1.0 if i == j else 0.0)
            column[i] = s[i] if c == mt else G[i, c]
        if not solve_small(S, column, mt):
            return False
        for i in range(mt):
            if c == mt:
                se[i] = column[i]
            else:
                Ge[i, c] = column[i]
    return True


@inner_kernel
def is_pair(k, i, N, n_soft):
    """Tell whether place (k, i) holds a pair of bounds; row N: the soft rows' misses."""
    return i < n_soft if k == N else k < N - 1 or i > 1


@inner_kernel
def start_pairs(m, low, high, sigma, n_soft, S, Z, N, nx):
    """Slacks S, multipliers Z (N+1, 4, 2) to begin with; returns the gradient's scale, pairs."""
    scale, pairs = 1.0, 0
    for k in range(N):
        for i in range(nx + 2):
            scale = max(scale, abs(m[k, i]))
    for k in range(N + 1):
        for i in range(4):
            if not is_pair(k, i, N, n_soft):
                continue
            for side in range(2):
                if k == N:
                    Z[k, i, side] = sigma
                    S[k, i, side] = 0.1 * scale / sigma
                else:
                    room = high[k, i] - low[k, i]
                    S[k, i, side] = max(-low[k, i] if side == 0 else high[k, i], 0.05 * room)
                    Z[k, i, side] = 0.1 * scale / S[k, i, side]
            pairs += 2
    return scale, pairs


@inner_kernel
def bound_terms(low, high, S, Z, dS, dZ, tau, corrector, shift, u, E, g, N):
    """Diagonals E and gradients g (N, 4) that the bounds add for the target ``tau``.

    So does ``shift`` / 2 |u - u now|^2, which is nothing once u moves no more.
    """
    for k in range(N):
        for i in range(4):
            E[k, i] = shift if i > 1 else 0.0
            g[k, i] = -shift * u[k, i - 2] if i > 1 else 0.0
            if not is_pair(k, i, N, 0):
                continue
            for side in range(2):
                t = tau - (dS[k, i, side] * dZ[k, i, side] if corrector else 0.0)
                s, ratio = S[k, i, side], Z[k, i, side] / S[k, i, side]
                E[k, i] += ratio
                if side == 0:
                    g[k, i] -= t / s + ratio * (low[k, i] + s)
                else:
                    g[k, i] += t / s - ratio * (high[k, i] - s)


@inner_kernel
def multiplier_step(Ge, se, b, y, S, Z, dS, dZ, tau, corrector, n_soft, N, mt, T, dy):
    """Step dy of the multipliers of C x_N = b; tell whether there is one."""
    for r in range(mt):
        dy[r] = b[r] - se[r]
        for c in range(mt):
            dy[r] -= Ge[r, c] * y[c]
            T[r, c] = Ge[r, c]
        if r < n_soft:
            for side in range(2):
                t = tau - (dS[N, r, side] * dZ[N, r, side] if corrector else 0.0)
                dy[r] += (1.0 if side == 0 else -1.0) * t / Z[N, r, side]
                T[r, r] -= S[N, r, side] / Z[N, r, side]
    return solve_small(T, dy, mt)


@inner_kernel
def pair_steps(x, u, dy, low, high, S, Z, dS, dZ, tau, corrector, n_soft, N, nx):
    """Steps dS, dZ toward a new (x, u) and by ``dy``; returns the longest that stays inside."""
    longest = 1.0 / _TO_BOUNDARY
    for k in range(N + 1):
        for i in range(4):
            if not is_pair(k, i, N, n_soft):
                continue
            for side in range(2):
                s, z = S[k, i, side], Z[k, i, side]
                t = tau - (dS[k, i, side] * dZ[k, i, side] if corrector else 0.0)
                if k == N:
                    dz = -dy[i] if side == 0 else dy[i]
                    ds = (t - s * dz) / z - s
                else:
                    w = x[k + 1, nx - 2 + i] if i < 2 else u[k, i - 2]
                    ds = (w - low[k, i] if side == 0 else high[k, i] - w) - s
                    dz = (t - z * ds) / s - z
                dS[k, i, side], dZ[k, i, side] = ds, dz
                if ds < 0.0:
                    longest = min(longest, -s / ds)
                if dz < 0.0:
                    longest = min(longest, -z / dz)
    return longest


@inner_kernel
def gap_after(alpha, S, Z, dS, dZ, n_soft, N):
    """Sum of the products of all pairs after a step of length ``alpha``."""
    total = 0.0
    for k in range(N + 1):
        for i in range(4):
            if is_pair(k, i, N, n_soft):
                for side in range(2):
                    s = S[k, i, side] + alpha * dS[k, i, side]
                    total += s * (Z[k, i, side] + alpha * dZ[k, i, side])
    return total


@inner_kernel
def interior_point(A, B, M, m, C, b, sigma, rho, n_soft, low, high, work, x, u, y, z):
    """Solve the program; returns SOLVED, NOT_CONVEX or NOT_SOLVED, and the iterations.

    ``low``, ``high`` (N, 4): bounds of the speeds of x_k+1 (columns 0, 1; not used in the last row)
    and of u_k (columns 2, 3). Into ``x`` (N+1, nx), ``u`` (N, 2), ``y`` (mt,) and the multipliers
    of the bounds ``z`` (N, 4), positive at upper ones.
    """
    P, Y, K, Ky, R, p, kff, S, Z, dS, dZ, E, g, xn, un = work
    N, nx, mt = A.shape[0], A.shape[1], C.shape[0]
    G, Ge, T = np.empty((mt, mt)), np.empty((mt, mt)), np.empty((mt, mt))
    s, se, dy, yp = np.empty(mt), np.empty(mt), np.empty(mt), np.empty(mt)
    scale, pairs = start_pairs(m, low, high, sigma, n_soft, S, Z, N, nx)
    x[:] = 0.0
    u[:] = 0.0
    y[:] = 0.0
    open_share, pull, shift = 1.0, 0.0, 0.0
    status, iteration = NOT_SOLVED, 0
    while iteration < MOST_ITERATIONS:
        gap = gap_after(0.0, S, Z, dS, dZ, n_soft, N) / pairs
        if not np.isfinite(gap):
            break
        if gap < _GAP * scale and open_share < _OPEN and pull < _PULL * scale:
            status = SOLVED
            break
        iteration += 1
        tau, alpha = 0.0, 0.0
        for corrector in range(2):
            bound_terms(low, high, S, Z, dS, dZ, tau, corrector == 1, shift, u, E, g, N)
            while corrector == 0 and not factor(A, B, M, P, Y, K, Ky, R, rho, N, nx, mt, C, E, G):
                shift = max(_SHIFT_RISE * shift, _LEAST_SHIFT * scale)
                if shift > _MOST_SHIFT * scale:
                    return NOT_CONVEX, iteration
                bound_terms(low, high, S, Z, dS, dZ, tau, False, shift, u, E, g, N)
            backward(A, B, m, g, K, Ky, R, p, kff, N, nx, mt, s)
            if not terminal_response(G, s, rho, mt, Ge, se) or not multiplier_step(
                Ge, se, b, y, S, Z, dS, dZ, tau, corrector == 1, n_soft, N, mt, T, dy
            ):
                return NOT_SOLVED, iteration
            for r in range(mt):  # the recursion's own multiplier is y - rho C x
                yp[r] = y[r] + dy[r] - rho[r] * se[r]
                for c in range(mt):
                    yp[r] -= rho[r] * Ge[r, c] * (y[c] + dy[c])
            forward(A, B, K, Ky, kff, yp, xn, un, N, nx, mt)
            alpha = pair_steps(
                xn, un, dy, low, high, S, Z, dS, dZ, tau, corrector == 1, n_soft, N, nx
            )
            if corrector == 0:
                after = gap_after(min(alpha, 1.0), S, Z, dS, dZ, n_soft, N) / pairs
                tau = gap * (after / gap) ** 3
        alpha = min(1.0, _TO_BOUNDARY * alpha)
        open_share *= 1.0 - alpha
        pull *= 1.0 - alpha
        for k in range(N):
            for i in range(2):
                pull = max(pull, alpha * shift * abs(un[k, i] - u[k, i]))
        shift = shift / _SHIFT_FALL if shift > _LEAST_SHIFT * scale else 0.0
        for k in range(N + 1):
            for i in range(nx):
                x[k, i] += alpha * (xn[k, i] - x[k, i])
            for i in range(4):
                if is_pair(k, i, N, n_soft):
                    for side in range(2):
                        S[k, i, side] += alpha * dS[k, i, side]
                        Z[k, i, side] += alpha * dZ[k, i, side]
            if k < N:
                for i in range(2):
                    u[k, i] += alpha * (un[k, i] - u[k, i])
        for r in range(mt):
            y[r] += alpha * dy[r]
    for k in range(N):
        for i in range(4):
            z[k, i] = Z[k, i, 1] - Z[k, i, 0] if is_pair(k, i, N, 0) else 0.0
    return status, iteration
