"""Kernels of Algorithm 2: Newton's method on (5.9) with projection, identification, enforcement.

``au`` (N, 3), ``ap`` (N+1, 3): -1, 0, 1 where the lower bound, none, the upper bound acts; ``zu``,
``zp``: its multiplier, positive at upper ones. An active bound is enforced by a large weight on its
component with the multiplier carried over (the method of multipliers), so that the sets change the
numbers of a stage, not its size.
"""

from __future__ import annotations

import math

import numpy as np

from spacecraft_gnc._inner_kernels import inner_kernel
from spacecraft_gnc._kernels import unlocked_kernel
from spacecraft_gnc.ocp.transfer._interior_kernels import (
    CONVERGED,
    NOT_FINITE,
    SPENT,
    UNSOLVABLE,
    regular_step,
    sum_abs,
)
from spacecraft_gnc.ocp.transfer._riccati_kernels import backward
from spacecraft_gnc.ocp.transfer._stage_kernels import first_order, linearize, move

_FIRM = 1e8  # weight of an active bound, over that of the torque
_CLOSED = 1e-12
_GOOD = 1e-9


@inner_kernel
def project(x, z, active, lo, hi, first, last):
    """Set components beyond their bounds, and active ones, on them; release those that pull.

    Returns the number of changes of the active set.
    """
    changes = 0
    for k in range(first, last):
        for i in range(3):
            if active[k, i] != 0 and z[k, i] * active[k, i] < 0.0:
                active[k, i] = 0
                z[k, i] = 0.0
                changes += 1
            elif active[k, i] == 0:
                z[k, i] = 0.0
                if x[k, i] < lo[i] or x[k, i] > hi[i]:
                    active[k, i] = -1 if x[k, i] < lo[i] else 1
                    changes += 1
            if active[k, i] < 0:
                x[k, i] = lo[i]
            elif active[k, i] > 0:
                x[k, i] = hi[i]
            else:
                x[k, i] = min(max(x[k, i], lo[i]), hi[i])
    return changes


@unlocked_kernel
def active_set(body, h, first, units, limits, most, passes, plan, z, sets, arena, told):
    """Algorithm 2 from ``plan`` = (u, Pi, lam, m), which the answer replaces; a `Status` value.

    Ends after ``most`` iterations or ``passes`` along the stages. Into ``told``: iterations,
    residual relative to the units, passes (to which it adds).
    """
    u, Pi, lam, m = plan
    zu, zp = z
    au, ap = sets
    quaternions, gap, stage, D, g, Dp, gp, ru, rp, _, _, step, _ = arena
    _, _, _, y, du, dPi, lam_new = step
    N = u.shape[0]
    us, ps = units[0], units[1]
    firm_p = _FIRM / (h * h)
    best, stalled, shift = math.inf, 0, 0.0
    Dp[:] = 0.0
    gp[:] = 0.0
    for iteration in range(most + 1):
        told[0] = iteration
        changes = project(u, zu, au, limits[0], limits[1], 0, N)
        changes += project(Pi, zp, ap, limits[2], limits[3], 1, N)
        ok, end = move(body, h, u, Pi, first, quaternions, gap)
        if not ok:
            return UNSOLVABLE
        linearize(body, h, Pi, quaternions, lam, (m[0], m[1], m[2]), True, stage)
        wu, wp = first_order(h, u, lam, (m[0], m[1], m[2]), zu, zp, stage, ru, rp)
        _, wg = sum_abs(gap)
        ends = max(abs(end[0]), abs(end[1]), abs(end[2]))
        error = max(wu / us, wp / us, wg / ps, ends)
        told[1] = error
        if not math.isfinite(error):
            return NOT_FINITE
        if changes == 0:
            if error < _CLOSED:
                return CONVERGED
            stalled = stalled + 1 if error > 0.5 * best else 0
            best = min(best, error)
            if stalled >= 2 and error < _GOOD:
                return CONVERGED
        if iteration == most or told[2] >= passes:
            break
        for k in range(N):
            for i in range(3):
                D[k, i] = 1.0 + (_FIRM if au[k, i] != 0 else 0.0)
                g[k, i] = u[k, i] + zu[k, i]
                if k > 0:
                    Dp[k, i] = firm_p if ap[k, i] != 0 else 0.0
                    gp[k, i] = zp[k, i]
        status, shift = regular_step(h, stage, D, g, Dp, gp, gap, units, end, shift, step, told)
        if status != 0:
            return status
        for k in range(N + 1):
            for i in range(3):
                Pi[k, i] += dPi[k, i]
                if ap[k, i] != 0:
                    zp[k, i] += firm_p * dPi[k, i]
                if k < N:
                    if au[k, i] != 0:
                        zu[k, i] += _FIRM * du[k, i]
                    u[k, i] += du[k, i]
                    lam[k, i] = lam_new[k, i]
        for i in range(3):
            m[i] = y[i]
    return SPENT


@unlocked_kernel
def is_minimum(h, stage, sets, units, curvature, D, g, Dp, gp, gap, step):
    """Whether the reduced Hessian is at least ``curvature``, with a large weight on what is kept.

    Sufficient: a positive definite Hessian with weights on the conditions and the active bounds is
    so on the directions that keep them.
    """
    au, ap = sets
    gains, G, s, _, _, _, _ = step
    N = D.shape[0]
    rho = np.empty(2)
    rho[0], rho[1] = 1e5 * units[2], 1e5 * units[3]
    for k in range(N):
        for i in range(3):
            D[k, i] = 1.0 - curvature + (_FIRM if au[k, i] != 0 else 0.0)
            Dp[k, i] = _FIRM / (h * h) if k > 0 and ap[k, i] != 0 else 0.0
    return backward(h, stage, D, g, Dp, gp, gap, rho, gains, G, s)
