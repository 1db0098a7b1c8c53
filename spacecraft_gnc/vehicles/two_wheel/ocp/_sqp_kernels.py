"""Kernels of the SQP method: roll-out, stage matrices, first-order conditions, iterations.

Unknowns are the wheel speeds nu_1 .. nu_N-1; nu_0 is given and nu_N is 0, so that bounds are linear
and only the attitude at the end is a nonlinear condition. ``cost`` holds q_1, q_2, q_3 of the
attitude, that of the speeds, that of the accelerations, and that of the attitude at the end (0: a
hard condition). `sqp` documents the method.
"""

from __future__ import annotations

import numpy as np

from spacecraft_gnc._inner_kernels import inner_kernel
from spacecraft_gnc._kernels import kernel
from spacecraft_gnc.vehicles.two_wheel.ocp._flow_kernels import (
    add_chart_curvature,
    advance,
    chart,
    curvature,
    linearize,
)
from spacecraft_gnc.vehicles.two_wheel.ocp._qp_kernels import (
    NOT_CONVEX,
    SOLVED,
    interior_point,
)

CONVERGED, SPENT, NO_PROGRESS, NOT_FINITE, INFEASIBLE = 0, 1, 2, 4, 9  # values of `Status`
_ARMIJO = 1e-4
_SHORTEST = 2.0**-12
_STEEPER = 10.0  # of the price of a missed end, where the present one does not close it
_RISES = 4  # of the price
_CLOSED = 1e-3  # of the tolerance: a missed end changes the cost to first order, unlike the rest
_CONVEXIFYING = 1000.0  # of the end's condition, times the largest weight


@inner_kernel
def roll_out(model, T, C, drift, nu, a, scratch):
    """Attitudes of all nodes from that of the first."""
    w, Omega, d, _ = scratch
    for k in range(nu.shape[0] - 1):
        advance(model, T, C, drift, k, nu, a, w, Omega, d)


@inner_kernel
def objective(model, T, nu, a, cost, e, E):
    """Cost of a plan; the coordinates of its last attitude stay in ``e``, their slope in ``E``."""
    N = nu.shape[0] - 1
    total = 0.0
    for k in range(N):
        chart(model, a[k], e, E)
        for i in range(3):
            total += cost[i] * e[i] * e[i]
        for i in range(2):
            u = (nu[k + 1, i] - nu[k, i]) / T
            total += cost[3] * nu[k, i] * nu[k, i] + cost[4] * u * u
    chart(model, a[N], e, E)
    for i in range(3):
        total += cost[5] * e[i] * e[i]
    return total


@kernel
def stages(model, T, C, drift, nu, a, cost, y, exact, A, B, M, m, Ct, b, scratch, local):
    """Dynamics A, B, Hessians M and gradients m of all stages, and the conditions Ct x_N = b.

    ``y`` holds the multipliers of these conditions; ``exact``: the Hessian of the Lagrangian, else
    the Gauss-Newton one.
    """
    w, Omega, d, V = scratch
    e, E, weights, lam, later, D, X, H, Aa = local
    N, na, nx = nu.shape[0] - 1, a.shape[1], a.shape[1] + 2
    hard = cost[5] == 0.0
    M[:] = 0.0
    m[:] = 0.0
    Ct[:] = 0.0
    chart(model, a[N], e, E)
    rows = 3 if hard else 0
    for i in range(rows):
        b[i] = -e[i]
        weights[i] = y[i]
        for j in range(na):
            Ct[i, j] = E[i, j]
    for i in range(2):
        b[rows + i] = -nu[N, i]
        Ct[rows + i, na + i] = 1.0
    for j in range(na):
        lam[j] = 0.0
        for i in range(3):
            slope = y[i] if hard else 2.0 * cost[5] * e[i]
            lam[j] += E[i, j] * slope
            if not hard:
                weights[i] = slope
                m[N, j] += E[i, j] * slope
                for c in range(na):
                    M[N, j, c] += 2.0 * cost[5] * E[i, j] * E[i, c]
    if exact:
        add_chart_curvature(model, a[N], weights, M[N, :na, :na])
    for k in range(N - 1, -1, -1):
        linearize(model, T, C, drift, k, nu, a, Aa, D, w, Omega, d, V)
        A[k, :, :] = 0.0
        for i in range(na):
            for j in range(na):
                A[k, i, j] = Aa[i, j]
            for j in range(2):
                A[k, i, na + j] = D[i, j] + D[i, 2 + j]
                B[k, i, j] = T * D[i, 2 + j]
        for j in range(2):
            A[k, na + j, na + j] = 1.0
            B[k, na + j, 0] = B[k, na + j, 1] = 0.0
            B[k, na + j, j] = T
            M[k, na + j, na + j] = 2.0 * cost[3]
            M[k, nx + j, nx + j] = 2.0 * cost[4]
            m[k, na + j] = 2.0 * cost[3] * nu[k, j]
            m[k, nx + j] = 2.0 * cost[4] * (nu[k + 1, j] - nu[k, j]) / T
        chart(model, a[k], e, E)
        for i in range(3):
            weights[i] = 2.0 * cost[i] * e[i]
        for j in range(na):
            v = 0.0
            for i in range(3):
                v += E[i, j] * weights[i]
                for c in range(na):
                    M[k, j, c] += 2.0 * cost[i] * E[i, j] * E[i, c]
            m[k, j] = v
            for i in range(na):
                v += Aa[i, j] * lam[i]
            later[j] = v
        if exact:
            add_chart_curvature(model, a[k], weights, M[k, :na, :na])
            curvature(model, T, C, drift, k, nu, a, lam, X, H, w, Omega, d, V)
            for j in range(2):
                for i in range(na):
                    ax, au = X[i, j] + X[i, 2 + j], T * X[i, 2 + j]
                    M[k, i, na + j] += ax
                    M[k, na + j, i] += ax
                    M[k, i, nx + j] += au
                    M[k, nx + j, i] += au
                for i in range(2):
                    M[k, na + i, na + j] += H[i, j] + H[i, 2 + j] + H[2 + i, j] + H[2 + i, 2 + j]
                    cross = T * (H[i, 2 + j] + H[2 + i, 2 + j])
                    M[k, na + i, nx + j] += cross
                    M[k, nx + j, na + i] += cross
                    M[k, nx + i, nx + j] += T * T * H[2 + i, 2 + j]
        for j in range(na):
            lam[j] = later[j]


@inner_kernel
def first_order(A, B, m, Ct, y, z, g, lam, later):
    """Gradient g (N, 2) of the Lagrangian by the accelerations; returns its largest size, scale."""
    N, nx, mt = A.shape[0], A.shape[1], Ct.shape[0]
    for j in range(nx):
        lam[j] = m[N, j]
        for r in range(mt):
            lam[j] += Ct[r, j] * y[r]
    worst, scale = 0.0, 0.0
    for k in range(N - 1, -1, -1):
        if k < N - 1:
            lam[nx - 2] += z[k, 0]
            lam[nx - 1] += z[k, 1]
        for i in range(2):
            v = m[k, nx + i] + z[k, 2 + i]
            scale = max(scale, abs(m[k, nx + i]))
            for j in range(nx):
                v += B[k, j, i] * lam[j]
            g[k, i] = v
            worst = max(worst, abs(v))
        for j in range(nx):
            v = m[k, j]
            for i in range(nx):
                v += A[k, i, j] * lam[i]
            later[j] = v
        for j in range(nx):
            lam[j] = later[j]
    return worst, scale


@inner_kernel
def set_bounds(nu, T, most_speed, most_acceleration, low, high):
    """Bounds of the changes of nu_k+1 (columns 0, 1) and of u_k (columns 2, 3)."""
    for k in range(nu.shape[0] - 1):
        for i in range(2):
            u = (nu[k + 1, i] - nu[k, i]) / T
            low[k, i] = -most_speed - nu[k + 1, i]
            high[k, i] = most_speed - nu[k + 1, i]
            low[k, 2 + i] = -most_acceleration - u
            high[k, 2 + i] = most_acceleration - u


@inner_kernel
def complementarity(low, high, z):
    """Largest product of a bound's multiplier and its distance."""
    worst = 0.0
    for k in range(z.shape[0]):
        for i in range(4):
            room = high[k, i] if z[k, i] > 0.0 else -low[k, i]
            worst = max(worst, abs(z[k, i]) * max(room, 0.0))
    return worst


@kernel
def missed(e):
    """l1 norm of the coordinates (3,) of an attitude."""
    return abs(e[0]) + abs(e[1]) + abs(e[2])


@inner_kernel
def slope_along(m, x, u, N, nx):
    """Derivative of the cost along a step."""
    v = 0.0
    for k in range(N):
        for i in range(nx):
            v += m[k, i] * x[k, i]
        for i in range(2):
            v += m[k, nx + i] * u[k, i]
    for i in range(nx):
        v += m[N, i] * x[N, i]
    return v


@inner_kernel
def linear_miss(Ct, b, x, N, nx):
    """l1 norm of the first three conditions after a linearized step."""
    total = 0.0
    for r in range(3):
        v = -b[r]
        for i in range(nx):
            v += Ct[r, i] * x[N, i]
        total += abs(v)
    return total


@inner_kernel
def verdict(status, y, sigma, residual, miss, hard, tolerance):
    """Status of a run that ends early: infeasible where the price of the missed end is reached."""
    if residual < tolerance and miss < tolerance:
        return CONVERGED
    if hard and miss > tolerance and max(abs(y[0]), abs(y[1]), abs(y[2])) > 0.5 * sigma:
        return INFEASIBLE
    return status


@kernel
def sqp(model, T, C, drift, nu, a, cost, limits, sigma, tolerance, most, chord, arena, y, z, told):
    """Solve from the plan ``nu`` (N+1, 2), which the solution replaces; returns a `Status` value.

    ``a`` (N+1, na) holds the first attitude; ``y``, ``z`` the multipliers to begin with. Into
    ``told``: iterations, residual, cost, |attitude at the end|, QP iterations.
    """
    scratch, local, matrices, work, step, trial = arena
    e, E = local[0], local[1]
    A, B, M, m, Ct, b, low, high, g, lam, later = matrices
    x, u, yq, zq = step
    nu_try, a_try, e_try, b_try, kept = trial
    N, na = nu.shape[0] - 1, a.shape[1]
    nx, hard = na + 2, cost[5] == 0.0
    n_soft = 3 if hard else 0
    rho = np.zeros(Ct.shape[0])
    for i in range(n_soft):
        rho[i] = _CONVEXIFYING * max(cost[0], cost[1], cost[2])
    roll_out(model, T, C, drift, nu, a, scratch)
    value = objective(model, T, nu, a, cost, e, E)
    miss = missed(e) if hard else 0.0
    known, rises, residual = False, 0, np.inf
    exact, rough = bool(1), bool(0)  # with True and False, `stages` would be compiled three times
    for iteration in range(most + 1):
        told[0] = iteration
        fresh = iteration == 0 or not chord
        stages(model, T, C, drift, nu, a, cost, y, fresh, A, B, M, m, Ct, b, scratch, local)
        if fresh:
            kept[:] = M
        else:
            M[:] = kept
        set_bounds(nu, T, limits[0], limits[1], low, high)
        worst, scale = first_order(A, B, m, Ct, y, z, g, lam, later)
        residual = max(worst, complementarity(low, high, z)) / (1.0 + scale)
        told[1], told[2], told[3] = max(residual, miss), value, miss
        if not np.isfinite(value) or not np.isfinite(residual):
            return NOT_FINITE
        if known and residual < tolerance:
            if miss < _CLOSED * tolerance:
                if not fresh:  # for the certificate
                    stages(
                        model, T, C, drift, nu, a, cost, y, exact, A, B, M, m, Ct, b, scratch, local
                    )
                return CONVERGED
            if miss > tolerance:
                if rises == _RISES:
                    return INFEASIBLE
                rises += 1
                sigma *= _STEEPER
        if iteration == most:
            break
        status, count = interior_point(
            A, B, M, m, Ct, b, sigma, rho, n_soft, low, high, work, x, u, yq, zq
        )
        told[4] += count
        if status == NOT_CONVEX:
            stages(model, T, C, drift, nu, a, cost, y, rough, A, B, M, m, Ct, b, scratch, local)
            status, count = interior_point(
                A, B, M, m, Ct, b, sigma, rho, n_soft, low, high, work, x, u, yq, zq
            )
            told[4] += count
        if status != SOLVED and not np.isfinite(x[N, 0]):
            return NOT_FINITE
        slope = slope_along(m, x, u, N, nx)
        if hard:
            slope += sigma * (linear_miss(Ct, b, x, N, nx) - miss)
        merit = value + sigma * miss
        # Rounding of the merit, and of a program whose step is all but zero: it may not descend.
        allowed = 1e-12 * (1.0 + abs(merit)) + 10.0 * max(slope, 0.0)
        alpha, corrected, moved = 1.0, False, False
        while alpha > _SHORTEST:
            for k in range(1, N + 1):
                for i in range(2):
                    nu_try[k, i] = nu[k, i] + alpha * x[k, na + i]
            for i in range(2):
                nu_try[0, i], nu_try[N, i] = nu[0, i], 0.0
            for i in range(na):
                a_try[0, i] = a[0, i]
            roll_out(model, T, C, drift, nu_try, a_try, scratch)
            value_try = objective(model, T, nu_try, a_try, cost, e_try, E)
            miss_try = missed(e_try) if hard else 0.0
            if value_try + sigma * miss_try <= merit + _ARMIJO * alpha * min(slope, 0.0) + allowed:
                moved = True
                break
            if hard and not corrected and alpha == 1.0:
                # Second-order correction: the same program, toward what the step missed.
                corrected = True
                for r in range(Ct.shape[0]):
                    b_try[r] = b[r]
                for r in range(3):
                    v = -e_try[r]
                    for i in range(nx):
                        v += Ct[r, i] * x[N, i]
                    b_try[r] = v
                status, count = interior_point(
                    A, B, M, m, Ct, b_try, sigma, rho, n_soft, low, high, work, x, u, yq, zq
                )
                told[4] += count
                continue
            if corrected:
                # The correction did not help: go back along the step itself.
                corrected = False
                status, count = interior_point(
                    A, B, M, m, Ct, b, sigma, rho, n_soft, low, high, work, x, u, yq, zq
                )
                told[4] += count
                alpha = 0.5
                continue
            alpha *= 0.5
        if not moved:
            return verdict(NO_PROGRESS, y, sigma, residual, miss, hard, tolerance)
        known = True
        for k in range(N + 1):
            for i in range(2):
                nu[k, i] = nu_try[k, i]
            for i in range(na):
                a[k, i] = a_try[k, i]
        for r in range(Ct.shape[0]):
            y[r] += alpha * (yq[r] - y[r])
        for k in range(N):
            for i in range(4):
                z[k, i] += alpha * (zq[k, i] - z[k, i])
        value, miss = value_try, miss_try
    return verdict(SPENT, y, sigma, residual, miss, hard, tolerance)
