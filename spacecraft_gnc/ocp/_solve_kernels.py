"""Kernels behind `shooting.ShootingSolver`: one solve, and many.

``arena`` is problem and work space of one solver, a flat array by `make_arena`; ``kept`` (4,)
tells what of it an earlier solve left for the chord: two entries for each formulation.
"""

from __future__ import annotations

import math

import numpy as np

from spacecraft_gnc._kernels import kernel
from spacecraft_gnc.dynamics._lgvi_kernels import BODY_SIZE
from spacecraft_gnc.lie._mat3_kernels import (
    dot,
    inverse,
    load3,
    load9,
    load9_rows,
    mat_t_mat,
    mat_t_vec,
    store3,
    store9,
    vee_antisymmetric,
)
from spacecraft_gnc.ocp._certificate_kernels import is_stationary, largest_row, rounding_of
from spacecraft_gnc.ocp._data_kernels import D_U, M_U
from spacecraft_gnc.ocp._newton_kernels import (
    CHORD,
    CONVERGED,
    LINE_SEARCH_FAILED,
    SADDLE,
    newton,
)
from spacecraft_gnc.ocp._shooting_kernels import newton_shooting
from spacecraft_gnc.ocp._stage_kernels import (
    Z_AT,
    ZONE_SIZE,
    horizon_cost,
    squared_control,
    work_size,
)
from spacecraft_gnc.ocp._sweep_kernels import (
    FACTOR_SIZE,
    factorize,
    smallest_pivot,
    sweep_residual,
)
from spacecraft_gnc.ocp._track_kernels import STAGE_SIZE, STAGES_AT, set_track, track_size
from spacecraft_gnc.types import Array

BAD_STATE, BAD_REFERENCE, BAD_GUESS = -1, -2, -4
ROTATION_ERROR_SQUARED = 1e-12  # square of types.ROTATION_TOLERANCE
_VECTORS = 12  # columns of guess, trial, resid, step
_SINGLE = 108  # numbers of the Jacobian (6, 6) and its carrier (6, 12) of single shooting
FORWARD_LOSS = 100.0  # of the tolerance, between costates run forward and backward
_INPUTS = 27  # numbers of the state and reference that a batch hands to `solve`


def make_arena(body: Array, data: Array, zones: Array, n: int) -> Array:
    """Return the arena for n steps, with the problem's constants in place."""
    m = int(data[M_U])
    stages = n * (work_size(m) + FACTOR_SIZE + _VECTORS)
    room = track_size(n, m) + _SINGLE + stages + _INPUTS
    return np.concatenate([body, data, zones.ravel(), np.zeros(room)])


@kernel
def is_rotation(R):
    """Whether |R^T R - I|_F^2 is small and det R > 0; false for NaN."""
    S = mat_t_mat(R, R)
    error = 0.0
    for i in range(9):
        e = S[i] - (1.0 if i % 4 == 0 else 0.0)
        error += e * e
    return error <= ROTATION_ERROR_SQUARED and inverse(R)[1] > 0.0


@kernel
def is_momentum(Pi):
    """Whether three numbers are finite; how large a momentum may be, the integrator says."""
    return 0.0 * Pi[0] + 0.0 * Pi[1] + 0.0 * Pi[2] == 0.0


@kernel
def _is_finite(rows):
    """Whether multipliers (N, 6) are finite, and so are the sums of a row."""
    total = 0.0
    for k in range(rows.shape[0]):
        a, b = load3(rows, k), load3(rows, k, 3)
        total += 0.0 * ((a[0] + a[1] + a[2]) + (b[0] + b[1] + b[2]))
    return total == 0.0


@kernel
def _angle(A, B):
    """Angle between two rotations, accurate near 0 and near pi."""
    E = mat_t_mat(A, B)
    v = vee_antisymmetric(E)
    return math.atan2(math.sqrt(dot(v, v)), 0.5 * (E[0] + E[4] + E[8] - 1.0))


@kernel
def _margins(zones, R, margins):
    """Smallest angle to each zone over the horizon (negative: violated)."""
    for i in range(zones.shape[0]):
        v = (zones[i, 0], zones[i, 1], zones[i, 2])
        d = (zones[i, 3], zones[i, 4], zones[i, 5])
        sign, closest = zones[i, 7], -math.inf
        for k in range(R.shape[0]):
            closest = max(closest, sign * dot(v, mat_t_vec(load9(R, k), d)))
        cosine = max(-1.0, min(1.0, sign * closest))
        margins[i] = sign * (math.acos(cosine) - math.acos(zones[i, 6]))


@kernel
def summarize(zones, R_ref, R, W, margins):
    """Fill the zone margins; returns the largest |u|^2, the first error and the angle turned."""
    largest = 0.0
    for k in range(W.shape[0]):
        largest = max(largest, squared_control(W, k))
    _margins(zones, R, margins)
    return largest, _angle(R_ref, load9(R, 0)), _angle(load9(R, 0), load9(R, W.shape[0]))


@kernel
def repeat_last(lam):
    """Repeat the last multipliers in the row after them."""
    N = lam.shape[0] - 1
    for i in range(6):
        lam[N, i] = lam[N - 1, i]


@kernel
def leave_no_plan(R, Pi, u, lam, margins):
    """Fill everything but the first state with NaN: a rollout that broke off left it as it was."""
    for k in range(u.shape[0]):
        for i in range(3):
            u[k, i] = Pi[k + 1, i] = math.nan
            for j in range(3):
                R[k + 1, i, j] = math.nan
    for k in range(lam.shape[0]):
        for i in range(6):
            lam[k, i] = math.nan
    for i in range(margins.shape[0]):
        margins[i] = math.nan


@kernel
def carve(arena, N, n_zones):
    """Cut the arena into (body, data, zones, track), W, (guess, trial, resid, step, fac), rest."""
    m = int(arena[BODY_SIZE + M_U])
    a = BODY_SIZE + D_U + 7 * m
    body, data = arena[:BODY_SIZE], arena[BODY_SIZE:a]
    b = a + ZONE_SIZE * n_zones
    zones = arena[a:b].reshape((n_zones, ZONE_SIZE))
    a = b + STAGES_AT + STAGE_SIZE * N + m
    problem = (body, data, zones, arena[b:a])
    b = a + N * (Z_AT + m)
    W, n = arena[a:b].reshape((N, Z_AT + m)), 3 * N
    guess, trial = arena[b : b + n].reshape((N, 3)), arena[b + n : b + 2 * n].reshape((N, 3))
    b += 2 * n
    resid, step = arena[b : b + n].reshape((N, 3)), arena[b + n : b + 2 * n].reshape((N, 3))
    b += 2 * n
    fac = arena[b : b + FACTOR_SIZE * N].reshape((N, FACTOR_SIZE))
    return problem, W, (guess, trial, resid, step, fac), arena[b + FACTOR_SIZE * N :]


@kernel
def _sweep(problem, horizon, work, kept, warm, rule, damping, estimated, tolerance, max_steps):
    """Solve by the backward sweep from the multipliers ``warm`` (N, 6)."""
    for k in range(warm.shape[0]):
        store3(work[0], k, load3(warm, k, 3))
    return newton(problem, horizon, work, kept, rule, damping, estimated, tolerance, max_steps)


@kernel
def _shoot(problem, horizon, work, rest, kept, warm, options):
    """Solve by single shooting from row 0 of ``warm``; the sweep certifies what it finds.

    Run backward, the costates are those of the torques found; what they miss of the forward ones is
    the residual, of which `FORWARD_LOSS` allows for the way over the horizon.
    """
    body, data, zones, track = problem
    guess, resid, fac = work[0], work[2], work[4]
    R, Pi, _, lam, W = horizon
    rule, damping, estimated, tolerance, max_steps = options
    T, E = rest[:72].reshape((6, 12)), rest[72:_SINGLE].reshape((6, 6))
    store3(lam, 0, load3(warm, 0))
    store3(lam, 0, load3(warm, 0, 3), 3)
    status, steps, norm = newton_shooting(
        problem, horizon, T, E, kept, rule, damping, estimated, tolerance, max_steps
    )
    if status != CONVERGED:
        return status, steps, norm, math.nan
    for k in range(lam.shape[0]):
        store3(guess, k, load3(lam, k, 3))
    _, norm = sweep_residual(data, zones, track, guess, R, Pi, lam, resid, W)
    left = max(FORWARD_LOSS * tolerance * largest_row(lam, 3), rounding_of(data, track, Pi))
    if norm > left or not is_stationary(data, track, lam, W, left):
        return LINE_SEARCH_FAILED, steps, norm, math.nan
    factorize(body, data, zones, track, R, Pi, lam, W, fac, 0.0, False)
    pivot = smallest_pivot(data[0], fac)
    return (CONVERGED if pivot > 0.0 else SADDLE), steps, norm, pivot


@kernel
def solve(
    inputs, warm, R, Pi, u, lam, margins, arena, kept,
    single, rule, damping, estimated, tolerance, max_steps,
):  # fmt: skip
    """Solve from ``inputs`` (9, 3): rows R, Pi, R_ref, omega_ref, tau_ref.

    Fills R, Pi, u, lam and the zone margins.

    ``lam`` has N + 1 rows, the last of which repeats the one before it.

    Returns status (negative: input refused), steps, residual, cost, curvature, largest |u|^2, the
    angle from R_0 to R_ref and the angle turned over the horizon.
    """
    N = u.shape[0]
    nan = math.nan
    R_0, Pi_0, R_ref = load9_rows(inputs, 0), load3(inputs, 3), load9_rows(inputs, 4)
    omega, tau = load3(inputs, 7), load3(inputs, 8)
    if not is_rotation(R_0) or not is_momentum(Pi_0):
        return BAD_STATE, 0, nan, nan, nan, nan, nan, nan
    if not is_rotation(R_ref) or not is_momentum(omega) or not is_momentum(tau):
        return BAD_REFERENCE, 0, nan, nan, nan, nan, nan, nan
    if not _is_finite(warm):
        return BAD_GUESS, 0, nan, nan, nan, nan, nan, nan
    problem, W, work, rest = carve(arena, N, margins.shape[0])
    if not set_track(problem[0], problem[1], R_ref, omega, tau, problem[3]):
        return BAD_REFERENCE, 0, nan, nan, nan, nan, nan, nan
    store9(R, 0, R_0)
    store3(Pi, 0, Pi_0)
    horizon = (R, Pi, u, lam[:N], W)
    if rule != CHORD:
        kept[0], kept[2] = 0, 0
    if single:
        options = (rule, damping, estimated, tolerance, max_steps)
        status, steps, norm, pivot = _shoot(problem, horizon, work, rest, kept[2:], warm, options)
    else:
        status, steps, norm, pivot = _sweep(
            problem, horizon, work, kept[:2], warm, rule, damping, estimated, tolerance, max_steps
        )
    if status != CONVERGED:
        kept[0], kept[2] = 0, 0
    if not math.isfinite(norm):
        leave_no_plan(R, Pi, u, lam, margins)
        return status, steps, norm, nan, nan, nan, nan, nan
    repeat_last(lam)
    cost = horizon_cost(problem[1], problem[2], problem[3], R, Pi, W)
    largest, error, travel = summarize(problem[2], R_ref, R, W, margins)
    return status, steps, norm, cost, pivot, largest, error, travel


@kernel
def solve_batch(
    states, reference, warm, R, Pi, u, lam, margins, arena, kept,
    single, rule, damping, estimated, tolerance, max_steps, numbers,
):  # fmt: skip
    """Solve from every row of ``states`` (n, 4, 3), R over Pi; ``numbers`` (n, 8) as `solve`.

    ``reference`` (5, 3) stands in the last rows of its inputs.

    ``warm`` (1 or n, N, 6) are the multipliers to start from, of which the last serves the rest.
    ``inputs`` of `solve` is made in the last numbers of the arena.
    """
    inputs = arena[arena.shape[0] - _INPUTS :].reshape((9, 3))
    for j in range(states.shape[0]):
        kept[0], kept[2] = 0, 0  # a chord, too, starts each row by itself
        inputs[:4] = states[j]
        inputs[4:] = reference
        n = numbers[j]
        n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7] = solve(
            inputs, warm[min(j, warm.shape[0] - 1)], R[j], Pi[j], u[j], lam[j], margins[j],
            arena, kept,
            single, rule, damping, estimated, tolerance, max_steps,
        )  # fmt: skip
