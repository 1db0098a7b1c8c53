"""Kernels that drive Newton's method on the backward sweep; `shooting` documents the method.

``problem`` is (body, data, zones, track), ``horizon`` (R, Pi, u, lam, W), ``work`` the arrays
(guess, trial, resid, step, fac) of `_sweep_kernels`. ``kept`` (2,) tells whether ``fac`` holds the
exact factorization of an earlier point, and which limits were active there.
"""

from __future__ import annotations

import math

from spacecraft_gnc._inner_kernels import inlined_inner_kernel, inner_kernel
from spacecraft_gnc.dynamics._lgvi_kernels import body_inertia
from spacecraft_gnc.lie._mat3_kernels import add, load3, scale, store3
from spacecraft_gnc.ocp._certificate_kernels import (
    is_stationary,
    largest_row,
    rounding_of,
)
from spacecraft_gnc.ocp._data_kernels import ALPHA, D_U, MU0, P1, Q1, U_UNIT, H
from spacecraft_gnc.ocp._stage_kernels import horizon_cost
from spacecraft_gnc.ocp._sweep_kernels import (
    begin,
    descent_at_saddle,
    evaluate_begun,
    factorize,
    smallest_pivot,
    substitute,
)

# Statuses, equal to ocp.Status.
CONVERGED, MAX_ITERATIONS, LINE_SEARCH_FAILED, UNSOLVABLE_STEP, NOT_FINITE, SINGULAR = range(6)
SADDLE = 8
BACKTRACKING, FULL, DAMPED, CHORD = range(4)  # equal to the places in shooting.STEP_RULES
SUFFICIENT_DECREASE = 1e-4
SMALLEST_STEP = 1e-3  # below it, a Levenberg term bends the step instead of shortening it further
FIRST_LEVENBERG, LARGEST_LEVENBERG = 1e-3, 1e10  # in units of 1 / U_UNIT
FAST = 0.1  # fall of the residual in one step that shows Newton at its best
LOCAL = 2.0  # residual, relative to the multipliers, from which Newton is expected at its best
CONTRACTION = 0.5  # of the residual in one step, with which a kept Jacobian is still good
SADDLES = 5  # saddle points that a solve leaves before it gives up
ARRIVED = -3  # no status: Newton's full correction is within rounding of the guess
SMALLEST_CORRECTION = 1e-10  # of the multipliers, relative to the largest


@inlined_inner_kernel
def _at(problem, horizon, guess, resid):
    body, data, zones, track = problem
    R, Pi, u, lam, W = horizon
    return evaluate_begun(body, data, zones, track, guess, R, Pi, u, lam, resid, W)


@inlined_inner_kernel
def _cost(problem, horizon):
    return horizon_cost(problem[1], problem[2], problem[3], horizon[0], horizon[1], horizon[4])


@inlined_inner_kernel
def _linearize(problem, horizon, fac, rho, estimated):
    body, data, zones, track = problem
    R, Pi, _, lam, W = horizon
    return factorize(body, data, zones, track, R, Pi, lam, W, fac, rho, estimated)


@inlined_inner_kernel
def move(guess, gamma, step, trial):
    """Fill ``trial`` with guess + gamma step, all (N, 3)."""
    for k in range(guess.shape[0]):
        store3(trial, k, add(load3(guess, k), scale(gamma, load3(step, k))))


@inlined_inner_kernel
def _newton_step(problem, work, rho):
    resid, step, fac = work[2], work[3], work[4]
    zero = (0.0, 0.0, 0.0)
    return substitute(problem[1][H], fac, resid, zero, zero, rho, step)


@inlined_inner_kernel
def _cost_noise(problem, cost, N):
    """How far rounding may move a cost: that of R - R_ref enters it to first order."""
    data = problem[1]
    attitude = N * data[H] * (data[Q1] + data[Q1 + 4] + data[Q1 + 8])
    attitude += data[P1] + data[P1 + 4] + data[P1 + 8]
    return 1e-9 * abs(cost) + 1e-14 * math.sqrt(abs(cost) * attitude)


@inlined_inner_kernel
def _is_better(new_cost, new_norm, cost, norm, gamma, slope, noise):
    """Armijo on the cost; near the optimum, where the cost is flat to rounding, on the residual."""
    if new_cost <= cost + SUFFICIENT_DECREASE * gamma * slope:
        return True
    if new_norm <= CONTRACTION * norm and new_cost <= cost + noise:
        return True
    return abs(gamma * slope) < 1e-4 * noise and new_norm < norm


@inner_kernel
def _search(problem, horizon, work, rho, cost, norm, slope):
    """Shorten the step in ``work`` until it makes progress; returns success, gamma, norm, pattern.

    ``cost`` is that of the guess. A full Newton step that brings the residual down tenfold is taken
    as it is; only otherwise does the cost decide, and where that is not known (NaN), none does.
    Without success the horizon is left at the guess.
    """
    guess, trial, resid, step, _ = work
    noise = _cost_noise(problem, cost, guess.shape[0])
    gamma = 1.0
    while gamma > SMALLEST_STEP:
        move(guess, gamma, step, trial)
        status, new_norm, pattern = _at(problem, horizon, trial, resid)
        if status == CONVERGED:
            if gamma == 1.0 and rho == 0.0 and new_norm <= FAST * norm:
                return True, gamma, new_norm, pattern
            if not math.isnan(cost) and _is_better(
                _cost(problem, horizon), new_norm, cost, norm, gamma, slope, noise
            ):
                return True, gamma, new_norm, pattern
        if math.isnan(cost):
            break
        gamma *= 0.5
    _at(problem, horizon, guess, resid)
    return False, gamma, norm, 0


@inlined_inner_kernel
def _flat(problem, norm):
    """Largest slope that is zero but for rounding; negative without a hard limit.

    On a hard limit the multipliers may change along the torques, which moves nothing.
    """
    data = problem[1]
    return 2e-12 * data[H] * norm * norm / data[D_U] if math.isinf(data[MU0]) else -1.0


@inner_kernel
def _searched_step(problem, horizon, work, rho, estimated, norm, local, stagnant):
    """One step that makes progress, with ``rho`` raised until there is one.

    ``local``: Newton is expected at its best, and the cost is worked out only if it is not.
    ``stagnant``: the last step left the residual as it was; where Newton's correction is too small
    to matter, the conditions hold as well as they can, and none is made.
    Returns status, residual, pattern, the rho of the step, that to go on with.
    """
    guess, trial, _, step, fac = work
    unit = 1.0 / problem[1][U_UNIT]
    cost = math.nan if local else _cost(problem, horizon)
    while rho <= LARGEST_LEVENBERG:
        indefinite = _linearize(problem, horizon, fac, rho * unit, estimated)
        slope = _newton_step(problem, work, rho * unit)
        plain = stagnant and rho == 0.0 and not estimated
        if plain and largest_row(step, 0) <= SMALLEST_CORRECTION * largest_row(guess, 0):
            return ARRIVED, norm, 0, 0.0, 0.0
        descends = indefinite < 0 and (slope < 0.0 or slope <= _flat(problem, norm))
        good, gamma, new_norm, pattern = False, 1.0, norm, 0
        if descends:
            good, gamma, new_norm, pattern = _search(problem, horizon, work, rho, cost, norm, slope)
        if not good and math.isnan(cost):  # once more, with the cost to decide
            cost = _cost(problem, horizon)
            if descends:
                good, gamma, new_norm, pattern = _search(
                    problem, horizon, work, rho, cost, norm, slope
                )
        if good:
            move(trial, 0.0, trial, guess)
            relaxed = 0.1 * rho if rho >= 10.0 * FIRST_LEVENBERG else 0.0
            return CONVERGED, new_norm, pattern, rho, relaxed if gamma == 1.0 else rho
        rho = max(8.0 * rho, FIRST_LEVENBERG)
    return LINE_SEARCH_FAILED, norm, 0, rho, rho


@inner_kernel
def _fixed_step(problem, horizon, work, gamma, estimated):
    """One step of given length, whatever it does; returns status, residual, pattern."""
    guess, _, resid, step, fac = work
    _linearize(problem, horizon, fac, 0.0, estimated)
    _newton_step(problem, work, 0.0)
    move(guess, gamma, step, guess)
    return _at(problem, horizon, guess, resid)


@inner_kernel
def _chord_step(problem, horizon, work, norm):
    """One step with the kept factorization; taken back where it does not contract.

    Returns whether it was good, residual, pattern.
    """
    guess, trial, resid, step, _ = work
    _newton_step(problem, work, 0.0)
    move(guess, 1.0, step, trial)
    status, new_norm, pattern = _at(problem, horizon, trial, resid)
    if status == CONVERGED and new_norm <= CONTRACTION * norm:
        move(trial, 0.0, trial, guess)
        return True, new_norm, pattern
    _at(problem, horizon, guess, resid)
    return False, norm, pattern


@inner_kernel
def _leave_saddle(problem, horizon, work, stage):
    """Step along negative curvature until the cost falls; returns status, residual, pattern."""
    body, data, _, _ = problem
    guess, trial, resid, step, fac = work
    h, J = data[H], body_inertia(body)
    cost = _cost(problem, horizon)
    size = descent_at_saddle(h, fac, stage, step)
    torque = 0.1 * math.sqrt(data[ALPHA]) if data[ALPHA] > 0.0 else 0.01 * J[0] / (h * h)
    gamma = torque / size if size > 0.0 else 0.0
    for _ in range(40):
        move(guess, gamma, step, trial)
        status, norm, pattern = _at(problem, horizon, trial, resid)
        if status == CONVERGED and _cost(problem, horizon) < cost:
            move(trial, 0.0, trial, guess)
            return CONVERGED, norm, pattern
        gamma *= 0.5
    _, norm, pattern = _at(problem, horizon, guess, resid)
    return SADDLE, norm, pattern


@inner_kernel
def newton(problem, horizon, work, kept, rule, damping, estimated, tolerance, max_steps):
    """Iterate from the guess in ``work``; returns status, steps, residual, curvature."""
    data, track, fac = problem[1], problem[3], work[4]
    R, Pi, _, lam, W = horizon
    h = data[H]
    if not begin(problem[0], data, R, Pi, W):
        return UNSOLVABLE_STEP, 0, math.inf, math.nan
    status, norm, pattern = _at(problem, horizon, work[0], work[2])
    if status != CONVERGED:
        return status, 0, math.inf, math.nan
    local = norm <= LOCAL * largest_row(lam, 3)
    rho, saddles, steps = 0.0, 0, 0
    # Variables: for literals, numba would compile what they are handed to once more.
    stagnant, never = steps == 0, steps > 0
    certifying = False  # a factorization that the chord kept from an earlier solve does not
    while True:
        if not math.isfinite(norm):
            return NOT_FINITE, steps, norm, math.nan
        small = norm <= tolerance * largest_row(lam, 3)
        # The bound on rounding is far above it, so it counts where steps no longer help only.
        rounded = steps > 0 and stagnant and norm <= rounding_of(data, track, Pi)
        if status == ARRIVED or small or rounded:
            # This solve's last linearization certifies, unless other limits act since.
            stage = -1
            if kept[0] == 0 or kept[1] != pattern or not certifying:
                stage = _linearize(problem, horizon, fac, 0.0, never)
                kept[0], kept[1] = 1, pattern
            pivot = smallest_pivot(h, fac)
            if pivot > 0.0:
                left = max(norm, rounding_of(data, track, Pi))
                done = CONVERGED if is_stationary(data, track, lam, W, left) else LINE_SEARCH_FAILED
                return done, steps, norm, pivot
            kept[0] = 0
            if stage < 0 or rule != BACKTRACKING or saddles == SADDLES or steps >= max_steps:
                return SADDLE, steps, norm, pivot
            saddles += 1
            local = False
            status, norm, pattern = _leave_saddle(problem, horizon, work, stage)
            if status != CONVERGED:
                return SADDLE, steps, norm, pivot
        if steps >= max_steps:
            return MAX_ITERATIONS, steps, norm, math.nan
        steps += 1
        if rule == CHORD and kept[0] == 1:
            good, norm, new_pattern = _chord_step(problem, horizon, work, norm)
            if good:
                pattern = new_pattern
                continue
        before, last_norm, used = pattern, norm, 0.0
        if rule in (FULL, DAMPED):
            gamma = damping if rule == DAMPED else 1.0
            status, norm, pattern = _fixed_step(problem, horizon, work, gamma, estimated)
        else:
            status, norm, pattern, used, rho = _searched_step(
                problem, horizon, work, rho, estimated, norm, local, stagnant
            )
        if status == LINE_SEARCH_FAILED and norm <= rounding_of(data, track, Pi):
            status, rho, used = ARRIVED, 0.0, math.nan
        if status == ARRIVED:
            pattern = before
        local, stagnant = norm <= FAST * last_norm, norm > CONTRACTION * last_norm
        kept[0], kept[1] = 1 if used == 0.0 and not estimated else 0, before
        certifying = True
        if status not in (CONVERGED, ARRIVED):
            return status, steps, norm, math.nan
