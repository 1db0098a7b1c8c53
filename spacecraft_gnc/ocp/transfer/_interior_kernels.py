"""Kernels of the homotopy to the bounds: a primal-dual interior-point method on (5.9).

The slackness conditions (5.8) hold with the product mu > 0 in place of 0, and mu falls. Unknowns
are torques, momenta between the ends (both strictly within their bounds) and the multipliers; the
gaps of the momentum close with the steps. An l1 merit makes it global.
"""

from __future__ import annotations

import math

import numpy as np

from spacecraft_gnc._inner_kernels import inner_kernel
from spacecraft_gnc._kernels import unlocked_kernel
from spacecraft_gnc.ocp.transfer._riccati_kernels import newton_step
from spacecraft_gnc.ocp.transfer._stage_kernels import first_order, linearize, move

CONVERGED, SPENT, NO_PROGRESS, UNSOLVABLE, NOT_FINITE, SINGULAR = 0, 1, 2, 3, 4, 5  # of `Status`
_FIRST_MU, _LAST_MU = 0.1, 1e-10  # over the square of the unit of torque
_ENOUGH = 10.0  # times mu: the error with which a barrier problem is solved
_KAPPA = 1e10
_ARMIJO = 1e-4
_SHORTEST = 1e-7
_FIRST_SHIFT, _MOST_SHIFT = 1e-4, 1e8
_INSIDE = 0.02  # of the room between two bounds, that a start keeps from each


@inner_kernel
def push_inside(x, lo, hi, unit, first, last):
    """Move rows first to last - 1 of ``x`` strictly within the bounds."""
    for k in range(first, last):
        for i in range(3):
            room = min(_INSIDE * (hi[i] - lo[i]), _INSIDE * unit)
            x[k, i] = min(max(x[k, i], lo[i] + room), hi[i] - room)


@inner_kernel
def barrier_terms(x, lo, hi, zl, zh, mu, base, first, last, D, g):
    """Diagonal D and gradient g of base |x|^2 / 2 and of the barrier."""
    for k in range(first, last):
        for i in range(3):
            D[k, i], g[k, i] = base, base * x[k, i]
            if lo[i] > -math.inf:
                s = x[k, i] - lo[i]
                D[k, i] += zl[k, i] / s
                g[k, i] -= mu / s
            if hi[i] < math.inf:
                s = hi[i] - x[k, i]
                D[k, i] += zh[k, i] / s
                g[k, i] += mu / s


@inner_kernel
def barrier(x, lo, hi, first, last):
    """Sum of the logarithms of the distances to the bounds."""
    total = 0.0
    for i in range(3):
        for k in range(first, last):
            if lo[i] > -math.inf:
                total += math.log(x[k, i] - lo[i])
            if hi[i] < math.inf:
                total += math.log(hi[i] - x[k, i])
    return total


@inner_kernel
def slackness(x, lo, hi, zl, zh, mu, first, last):
    """Largest |product of multiplier and distance - mu|."""
    worst = 0.0
    for k in range(first, last):
        for i in range(3):
            if lo[i] > -math.inf:
                worst = max(worst, abs(zl[k, i] * (x[k, i] - lo[i]) - mu))
            if hi[i] < math.inf:
                worst = max(worst, abs(zh[k, i] * (hi[i] - x[k, i]) - mu))
    return worst


@inner_kernel
def longest_steps(x, dx, lo, hi, zl, zh, mu, tau, first, last):
    """Longest steps of ``x`` and of its multipliers that stay inside, at most 1."""
    most, most_z = 1.0, 1.0
    for k in range(first, last):
        for i in range(3):
            d = dx[k, i]
            if lo[i] > -math.inf:
                s, z = x[k, i] - lo[i], zl[k, i]
                if d < 0.0:
                    most = min(most, -tau * s / d)
                dz = mu / s - z - z / s * d
                if dz < 0.0:
                    most_z = min(most_z, -tau * z / dz)
            if hi[i] < math.inf:
                s, z = hi[i] - x[k, i], zh[k, i]
                if d > 0.0:
                    most = min(most, tau * s / d)
                dz = mu / s - z + z / s * d
                if dz < 0.0:
                    most_z = min(most_z, -tau * z / dz)
    return most, most_z


@inner_kernel
def step_multipliers(x, dx, lo, hi, zl, zh, mu, alpha, first, last):
    """Step of the multipliers, before that of ``x``."""
    for k in range(first, last):
        for i in range(3):
            d = dx[k, i]
            if lo[i] > -math.inf:
                s, z = x[k, i] - lo[i], zl[k, i]
                zl[k, i] = z + alpha * (mu / s - z - z / s * d)
            if hi[i] < math.inf:
                s, z = hi[i] - x[k, i], zh[k, i]
                zh[k, i] = z + alpha * (mu / s - z + z / s * d)


@inner_kernel
def keep_near(x, lo, hi, zl, zh, mu, first, last):
    """Keep the multipliers within a wide band about mu over the distance."""
    for k in range(first, last):
        for i in range(3):
            if lo[i] > -math.inf:
                c = mu / (x[k, i] - lo[i])
                zl[k, i] = min(max(zl[k, i], c / _KAPPA), c * _KAPPA)
            if hi[i] < math.inf:
                c = mu / (hi[i] - x[k, i])
                zh[k, i] = min(max(zh[k, i], c / _KAPPA), c * _KAPPA)


@inner_kernel
def half_square(u):
    """Half the sum of the squares."""
    total = 0.0
    for k in range(u.shape[0]):
        total += u[k, 0] * u[k, 0] + u[k, 1] * u[k, 1] + u[k, 2] * u[k, 2]
    return 0.5 * total


@inner_kernel
def sum_abs(a):
    """Sum and largest of the sizes of an array (n, 3)."""
    total, worst = 0.0, 0.0
    for k in range(a.shape[0]):
        for i in range(3):
            v = abs(a[k, i])
            total += v
            worst = max(worst, v)
    return total, worst


@inner_kernel
def regular_step(h, stage, D, g, Dp, gp, gap, units, end, shift, step, told):
    """Newton step with as much shift of the curvature as makes it convex; returns status, shift.

    Adds to ``told[2]`` how often it was tried.
    """
    gains, G, s, y, du, dPi, lam = step
    rho = np.empty(2)
    added = 0.0
    for attempt in range(20):
        weight = 10.0 if attempt == 0 else 1e3
        told[2] += 1.0
        rho[0], rho[1] = weight * units[2], weight * units[3]
        status = newton_step(h, stage, D, g, Dp, gp, gap, rho, end, gains, G, s, y, du, dPi, lam)
        if status == 0:
            return 0, added
        if attempt == 0:
            continue
        more = max(_FIRST_SHIFT, shift / 3.0) if added == 0.0 else 8.0 * added
        if more > _MOST_SHIFT:
            break
        for k in range(D.shape[0]):
            for i in range(3):
                D[k, i] += more - added
        added = more
    return SINGULAR, added


@unlocked_kernel
def interior(body, h, first, units, limits, most, passes, plan, z, arena, told):
    """Solve from ``plan`` = (u, Pi, lam, m), which the answer replaces; returns a `Status` value.

    ``units`` (4,): of torque and of momentum, and the weights of the end; ``limits`` (4, 3): lower
    and upper torque, lower and upper momentum. ``z``: multipliers (lower, upper torque; lower,
    upper momentum). Ends after ``most`` iterations or ``passes`` along the stages. Into ``told``:
    iterations, error, passes (to which it adds).
    """
    u, Pi, lam, m = plan
    zul, zuh, zpl, zph = z
    quaternions, gap, stage, D, g, Dp, gp, ru, rp, zu, zp, step, trial = arena
    _, _, _, y, du, dPi, lam_new = step
    u_try, Pi_try, q_try, gap_try = trial
    ulo, uhi, plo, phi = limits[0], limits[1], limits[2], limits[3]
    N = u.shape[0]
    us, ps = units[0], units[1]
    relative = _FIRST_MU
    mu = relative * us * us
    push_inside(u, ulo, uhi, us, 0, N)
    push_inside(Pi, plo, phi, ps, 1, N)
    Dp[:] = 0.0
    gp[:] = 0.0
    for k in range(N + 1):
        for i in range(3):
            if k < N:
                zul[k, i] = mu / (u[k, i] - ulo[i])
                zuh[k, i] = mu / (uhi[i] - u[k, i])
            inner = 0 < k < N
            zpl[k, i] = mu / (Pi[k, i] - plo[i]) if inner else 0.0
            zph[k, i] = mu / (phi[i] - Pi[k, i]) if inner else 0.0
    ok, end = move(body, h, u, Pi, first, quaternions, gap)
    if not ok:
        return UNSOLVABLE
    nu_g, nu_e, shift = 0.0, 0.0, 0.0
    for iteration in range(most + 1):
        told[0] = iteration
        linearize(body, h, Pi, quaternions, lam, (m[0], m[1], m[2]), True, stage)
        for k in range(N + 1):
            for i in range(3):
                zp[k, i] = zph[k, i] - zpl[k, i]
                if k < N:
                    zu[k, i] = zuh[k, i] - zul[k, i]
        wu, wp = first_order(h, u, lam, (m[0], m[1], m[2]), zu, zp, stage, ru, rp)
        gaps, wg = sum_abs(gap)
        ends = abs(end[0]) + abs(end[1]) + abs(end[2])
        base = max(wu / us, wp / us, wg / ps, ends)
        if not math.isfinite(base):
            return NOT_FINITE
        while True:
            slack = max(
                slackness(u, ulo, uhi, zul, zuh, mu, 0, N),
                slackness(Pi, plo, phi, zpl, zph, mu, 1, N),
            )
            error = max(base, slack / (us * us))
            if error > _ENOUGH * relative or relative <= _LAST_MU:
                break
            relative = max(_LAST_MU, min(0.2 * relative, relative**1.5))
            mu = relative * us * us
            nu_g, nu_e = 0.0, 0.0
        told[1] = error
        if relative <= _LAST_MU and error <= _ENOUGH * 10.0 * _LAST_MU:
            return CONVERGED
        if iteration == most or told[2] >= passes:
            break
        barrier_terms(u, ulo, uhi, zul, zuh, mu, 1.0, 0, N, D, g)
        barrier_terms(Pi, plo, phi, zpl, zph, mu, 0.0, 1, N, Dp, gp)
        status, shift = regular_step(h, stage, D, g, Dp, gp, gap, units, end, shift, step, told)
        if status != 0:
            return SINGULAR
        tau = max(0.99, 1.0 - relative)
        au, zu_most = longest_steps(u, du, ulo, uhi, zul, zuh, mu, tau, 0, N)
        ap, zp_most = longest_steps(Pi, dPi, plo, phi, zpl, zph, mu, tau, 1, N)
        alpha, alpha_z = min(au, ap), min(zu_most, zp_most)
        _, biggest = sum_abs(lam_new)
        nu_g = max(nu_g, 1.2 * biggest)
        nu_e = max(nu_e, 1.2 * max(abs(y[0]), abs(y[1]), abs(y[2])))
        slope = -nu_g * gaps - nu_e * ends
        for k in range(N):
            for i in range(3):
                slope += g[k, i] * du[k, i] + gp[k, i] * dPi[k, i]
        inside = barrier(u, ulo, uhi, 0, N) + barrier(Pi, plo, phi, 1, N)
        merit = half_square(u) - mu * inside + nu_g * gaps + nu_e * ends
        allowed = 1e-11 * (abs(merit) + mu * N)
        moved, end_try = False, end
        while alpha > _SHORTEST:
            for k in range(N + 1):
                for i in range(3):
                    Pi_try[k, i] = Pi[k, i] + alpha * dPi[k, i]
                    if k < N:
                        u_try[k, i] = u[k, i] + alpha * du[k, i]
            told[2] += 1.0
            ok, end_try = move(body, h, u_try, Pi_try, first, q_try, gap_try)
            if ok:
                gaps_try, _ = sum_abs(gap_try)
                ends_try = abs(end_try[0]) + abs(end_try[1]) + abs(end_try[2])
                inside = barrier(u_try, ulo, uhi, 0, N) + barrier(Pi_try, plo, phi, 1, N)
                new = half_square(u_try) - mu * inside + nu_g * gaps_try + nu_e * ends_try
                if new <= merit + _ARMIJO * alpha * min(slope, 0.0) + allowed:
                    moved = True
                    break
            alpha *= 0.5
        if not moved:
            return NO_PROGRESS
        step_multipliers(u, du, ulo, uhi, zul, zuh, mu, alpha_z, 0, N)
        step_multipliers(Pi, dPi, plo, phi, zpl, zph, mu, alpha_z, 1, N)
        for k in range(N + 1):
            for i in range(3):
                Pi[k, i] = Pi_try[k, i]
                if k < N:
                    u[k, i] = u_try[k, i]
                    gap[k, i] = gap_try[k, i]
                    lam[k, i] += alpha * (lam_new[k, i] - lam[k, i])
                    for j in range(4):
                        quaternions[k, j] = q_try[k, j]
        for i in range(3):
            m[i] += alpha * (y[i] - m[i])
        keep_near(u, ulo, uhi, zul, zuh, mu, 0, N)
        keep_near(Pi, plo, phi, zpl, zph, mu, 1, N)
        end = end_try
    return SPENT
