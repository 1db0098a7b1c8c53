"""Kernels that drive Newton's method on the backward sweep; `shooting` documents the method.

``problem`` is (body, data, zones, track), ``horizon`` (R, Pi, u, lam, W), ``work`` the arrays
(guess, trial, resid, step, fac) of `_sweep_kernels`. ``kept`` (2,) tells whether ``fac`` holds the
exact factorisation of an earlier point, and which limits were active there.
"""

from __future__ import annotations

import math

from spacecraft_gnc._kernels import kernel
from numba import njit
thin = njit(cache=True, error_model='numpy', inline='always')
from spacecraft_gnc.dynamics._lgvi_kernels import body_inertia
from spacecraft_gnc.lie._mat3_kernels import add, dot, load3, scale, store3
from spacecraft_gnc.ocp._stage_kernels import ALPHA, P1, Q1, H
from spacecraft_gnc.ocp._sweep_kernels import (
    descent_at_saddle,
    evaluate,
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
FIRST_LEVENBERG, LARGEST_LEVENBERG = 1e-3, 1e10
CONTRACTION = 0.5  # of the residual in one step, with which a kept Jacobian is still good
SADDLES = 5  # saddle points that a solve leaves before it gives up


@thin
def _at(problem, horizon, guess, resid):
    body, data, zones, track = problem
    R, Pi, u, lam, W = horizon
    return evaluate(body, data, zones, track, guess, R, Pi, u, lam, resid, W)


@thin
def _linearise(problem, horizon, fac, rho, estimated):
    body, data, zones, track = problem
    R, Pi, _, lam, W = horizon
    return factorize(body, data, zones, track, R, Pi, lam, W, fac, rho, estimated)


@thin
def _move(guess, gamma, step, trial):
    for k in range(guess.shape[0]):
        store3(trial, k, add(load3(guess, k), scale(gamma, load3(step, k))))


@thin
def _newton_step(problem, work, rho):
    resid, step, fac = work[2], work[3], work[4]
    zero = (0.0, 0.0, 0.0)
    return substitute(problem[1][H], fac, resid, zero, zero, rho, step)


@kernel
def _cost_noise(problem, cost, N):
    """How far rounding may move a cost: that of R - R_ref enters it to first order."""
    data = problem[1]
    attitude = N * data[H] * (data[Q1] + data[Q1 + 4] + data[Q1 + 8])
    attitude += data[P1] + data[P1 + 4] + data[P1 + 8]
    return 1e-9 * abs(cost) + 1e-14 * math.sqrt(abs(cost) * attitude)


@kernel
def _is_better(status, new_cost, new_norm, cost, norm, gamma, slope, noise):
    """Armijo on the cost; near the optimum, where the cost is flat to rounding, on the residual."""
    if status != CONVERGED:
        return False
    if new_cost <= cost + SUFFICIENT_DECREASE * gamma * slope:
        return True
    if new_norm <= CONTRACTION * norm and new_cost <= cost + noise:
        return True
    return abs(gamma * slope) < 1e-4 * noise and new_norm < norm


@kernel
def _searched_step(problem, horizon, work, rho, estimated, cost, norm):
    """One step that decreases the cost, with ``rho`` raised until there is one.

    Returns status, cost, residual, pattern, the rho of the step, and that to go on with.
    """
    guess, trial, resid, _, fac = work
    noise = _cost_noise(problem, cost, guess.shape[0])
    while rho <= LARGEST_LEVENBERG:
        indefinite = _linearise(problem, horizon, fac, rho, estimated)
        slope = _newton_step(problem, work, rho)
        if indefinite < 0 and slope < 0.0:
            gamma = 1.0
            while gamma > SMALLEST_STEP:
                _move(guess, gamma, work[3], trial)
                status, new_cost, new_norm, pattern = _at(problem, horizon, trial, resid)
                if _is_better(status, new_cost, new_norm, cost, norm, gamma, slope, noise):
                    _move(trial, 0.0, trial, guess)
                    relaxed = 0.1 * rho if rho >= 10.0 * FIRST_LEVENBERG else 0.0
                    following = relaxed if gamma == 1.0 else rho
                    return CONVERGED, new_cost, new_norm, pattern, rho, following
                gamma *= 0.5
            _at(problem, horizon, guess, resid)
        rho = max(8.0 * rho, FIRST_LEVENBERG)
    return LINE_SEARCH_FAILED, cost, norm, 0, rho, rho


@kernel
def _fixed_step(problem, horizon, work, gamma, estimated):
    """One step of given length, whatever it does; returns status, cost, residual, pattern."""
    guess, _, resid, step, fac = work
    _linearise(problem, horizon, fac, 0.0, estimated)
    _newton_step(problem, work, 0.0)
    _move(guess, gamma, step, guess)
    return _at(problem, horizon, guess, resid)


@kernel
def _chord_step(problem, horizon, work, norm):
    """One step with the kept factorisation; taken back where it does not contract.

    Returns whether it was good, cost, residual, pattern.
    """
    guess, trial, resid, step, _ = work
    _newton_step(problem, work, 0.0)
    _move(guess, 1.0, step, trial)
    status, cost, new_norm, pattern = _at(problem, horizon, trial, resid)
    if status == CONVERGED and new_norm <= CONTRACTION * norm:
        _move(trial, 0.0, trial, guess)
        return True, cost, new_norm, pattern
    _at(problem, horizon, guess, resid)
    return False, cost, norm, pattern


@kernel
def _leave_saddle(problem, horizon, work, stage, cost):
    """Step along negative curvature until the cost falls.

    Returns status, cost, residual, pattern.
    """
    body, data, _, _ = problem
    guess, trial, resid, step, fac = work
    h, J = data[H], body_inertia(body)
    size = descent_at_saddle(h, fac, stage, step)
    torque = 0.1 * math.sqrt(data[ALPHA]) if data[ALPHA] > 0.0 else 0.01 * J[0] / (h * h)
    gamma = torque / size if size > 0.0 else 0.0
    for _ in range(40):
        _move(guess, gamma, step, trial)
        status, new_cost, norm, pattern = _at(problem, horizon, trial, resid)
        if status == CONVERGED and new_cost < cost:
            _move(trial, 0.0, trial, guess)
            return CONVERGED, new_cost, norm, pattern
        gamma *= 0.5
    _, cost, norm, pattern = _at(problem, horizon, guess, resid)
    return SADDLE, cost, norm, pattern


@kernel
def _costate_scale(lam):
    largest = 0.0
    for k in range(lam.shape[0]):
        l2 = load3(lam, k, 3)
        largest = max(largest, dot(l2, l2))
    return 1.0 + math.sqrt(largest)


@kernel
def newton(problem, horizon, work, kept, rule, damping, estimated, tolerance, max_steps):
    """Iterate from the guess in ``work``; returns status, steps, residual, cost, curvature."""
    h, fac = problem[1][H], work[4]
    status, cost, norm, pattern = _at(problem, horizon, work[0], work[2])
    if status != CONVERGED:
        return status, 0, math.inf, math.inf, math.nan
    rho, saddles, steps = 0.0, 0, 0
    certifying = False  # a factorisation that the chord kept from an earlier solve does not
    while True:
        if not math.isfinite(norm):
            return NOT_FINITE, steps, norm, math.inf, math.nan
        if norm <= tolerance * _costate_scale(horizon[3]):
            # This solve's last linearisation certifies, unless other limits act since.
            stage = -1
            if kept[0] == 0 or kept[1] != pattern or not certifying:
                stage = _linearise(problem, horizon, fac, 0.0, False)
                kept[0], kept[1] = 1, pattern
            pivot = smallest_pivot(h, fac)
            if pivot > 0.0:
                return CONVERGED, steps, norm, cost, pivot
            kept[0] = 0
            if stage < 0 or rule != BACKTRACKING or saddles == SADDLES or steps >= max_steps:
                return SADDLE, steps, norm, cost, pivot
            saddles += 1
            status, cost, norm, pattern = _leave_saddle(problem, horizon, work, stage, cost)
            if status != CONVERGED:
                return SADDLE, steps, norm, cost, pivot
        if steps >= max_steps:
            return MAX_ITERATIONS, steps, norm, cost, math.nan
        steps += 1
        if rule == CHORD and kept[0] == 1:
            good, new_cost, norm, new_pattern = _chord_step(problem, horizon, work, norm)
            if good:
                cost, pattern = new_cost, new_pattern
                continue
        before, used = pattern, 0.0
        if rule in (FULL, DAMPED):
            gamma = damping if rule == DAMPED else 1.0
            status, cost, norm, pattern = _fixed_step(problem, horizon, work, gamma, estimated)
        else:
            status, cost, norm, pattern, used, rho = _searched_step(
                problem, horizon, work, rho, estimated, cost, norm
            )
        kept[0], kept[1] = 1 if used == 0.0 and not estimated else 0, before
        certifying = True
        if status != CONVERGED:
            return status, steps, norm, cost, math.nan
