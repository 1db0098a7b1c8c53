"""Kernels behind `shooting.ShootingSolver`: one solve, and many.

``arena`` is problem, settings and work space of one solver, a flat array by `make_arena`; ``kept``
(4,) tells what of it an earlier solve left for the chord: two entries for each formulation.
``plan`` takes what a solve finds, flat: `_plan_kernels` says where.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from spacecraft_gnc._inner_kernels import inlined_inner_kernel, inner_kernel
from spacecraft_gnc._kernels import given, inlined_kernel, kernel, unowned
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
    store9_rows,
    vee_antisymmetric,
)
from spacecraft_gnc.ocp._certificate_kernels import is_stationary, largest_row, rounding_of
from spacecraft_gnc.ocp._data_kernels import D_U, M_U, data3
from spacecraft_gnc.ocp._newton_kernels import (
    CHORD,
    CONVERGED,
    LINE_SEARCH_FAILED,
    SADDLE,
    newton,
)
from spacecraft_gnc.ocp._plan_kernels import cut
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

BAD_STATE, BAD_REFERENCE, BAD_GUESS, BAD_SHAPE = -1, -2, -4, -5
ROTATION_ERROR_SQUARED = 1e-12  # square of types.ROTATION_TOLERANCE
_VECTORS = 12  # columns of guess, trial, resid, step
_SINGLE = 108  # numbers of the Jacobian (6, 6) and its carrier (6, 12) of single shooting
FORWARD_LOSS = 100.0  # of the tolerance, between costates run forward and backward
# Of the last numbers of the arena: how many steps and zones, what `ShootingSolver` sets, and the
# rate and the torque with which the reference moves.
N_AT, ZONES_AT, SETTINGS_AT, MOTION_AT, TAIL = 0, 1, 2, 8, 14


def make_arena(body: Array, data: Array, zones: Array, n: int, settings: Sequence[float]) -> Array:
    """Return the arena for n steps, with the problem's constants in place."""
    m = int(data[M_U])
    stages = n * (work_size(m) + FACTOR_SIZE + _VECTORS)
    room = np.zeros(track_size(n, m) + _SINGLE + stages)
    tail = [n, len(zones), *settings, *np.zeros(TAIL - MOTION_AT)]
    return np.concatenate([body, data, zones.ravel(), room, tail])


@inlined_inner_kernel
def is_rotation(R):
    """Whether |R^T R - I|_F^2 is small and det R > 0; false for NaN."""
    S = mat_t_mat(R, R)
    error = 0.0
    for i in range(9):
        e = S[i] - (1.0 if i % 4 == 0 else 0.0)
        error += e * e
    return error <= ROTATION_ERROR_SQUARED and inverse(R)[1] > 0.0


@inlined_inner_kernel
def is_momentum(Pi):
    """Whether three numbers are finite; how large a momentum may be, the integrator says."""
    return 0.0 * Pi[0] + 0.0 * Pi[1] + 0.0 * Pi[2] == 0.0


@inlined_inner_kernel
def _is_finite(rows):
    """Whether multipliers (N, 6) are finite, and so are the sums of a row."""
    total = 0.0
    for k in range(rows.shape[0]):
        a, b = load3(rows, k), load3(rows, k, 3)
        total += 0.0 * ((a[0] + a[1] + a[2]) + (b[0] + b[1] + b[2]))
    return total == 0.0


@inlined_inner_kernel
def _angle(A, B):
    """Angle between two rotations, accurate near 0 and near pi."""
    E = mat_t_mat(A, B)
    v = vee_antisymmetric(E)
    return math.atan2(math.sqrt(dot(v, v)), 0.5 * (E[0] + E[4] + E[8] - 1.0))


@inlined_inner_kernel
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


@inlined_kernel
def summarize(zones, R_ref, R, W, margins):
    """Fill the zone margins; returns the largest |u|^2, the first error and the angle turned."""
    largest = 0.0
    for k in range(W.shape[0]):
        largest = max(largest, squared_control(W, k))
    _margins(zones, R, margins)
    return largest, _angle(R_ref, load9(R, 0)), _angle(load9(R, 0), load9(R, W.shape[0]))


@inlined_inner_kernel
def repeat_last(lam):
    """Repeat the last multipliers in the row after them."""
    N = lam.shape[0] - 1
    for i in range(6):
        lam[N, i] = lam[N - 1, i]


@inner_kernel
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


@inner_kernel
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


@inner_kernel
def _shoot(problem, horizon, work, rest, kept, options):
    """Solve by single shooting from row 0 of lam; the sweep certifies what it finds.

    Run backward, the costates are those of the torques found; what they miss of the forward ones is
    the residual, of which `FORWARD_LOSS` allows for the way over the horizon.
    """
    body, data, zones, track = problem
    guess, resid, fac = work[0], work[2], work[4]
    R, Pi, _, lam, W = horizon
    rule, damping, estimated, tolerance, max_steps = options
    T, E = rest[:72].reshape((6, 12)), rest[72:_SINGLE].reshape((6, 6))
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
    never = norm < 0.0  # a variable: for a literal, numba would compile it once more
    factorize(body, data, zones, track, R, Pi, lam, W, fac, 0.0, never)
    pivot = smallest_pivot(data[0], fac)
    return (CONVERGED if pivot > 0.0 else SADDLE), steps, norm, pivot


@inlined_inner_kernel
def parts_of(plan, arena):
    """Cut a plan of the arena's solver into R, Pi, u, lam, margins, numbers, R_ref."""
    tail = arena.shape[0] - TAIL
    return cut(plan, int(arena[tail + N_AT]), int(arena[tail + ZONES_AT]))


@inlined_inner_kernel
def stand_still(arena):
    """Have the reference of the next solves rest."""
    for i in range(arena.shape[0] - TAIL + MOTION_AT, arena.shape[0]):
        arena[i] = 0.0


@inlined_inner_kernel
def sum_up(problem, R_ref, horizon, lam, margins, numbers):
    """Fill what is told of a plan: cost, largest |u|^2, angles and zone margins."""
    _, data, zones, track = problem
    R, Pi, _, _, W = horizon
    repeat_last(lam)
    numbers[3] = horizon_cost(data, zones, track, R, Pi, W)
    numbers[5], numbers[6], numbers[7] = summarize(zones, R_ref, R, W, margins)


@kernel
def solve(attitude, momentum, target, guess, plan, arena, kept):
    """Solve from a state (3, 3), (3,), a reference (3, 3) and multipliers (N, 6) into ``plan``.

    The first four are `given`. Returns the status, negative where an input is refused. One kernel
    of few levels: numba compiles at each all that is below.
    """
    plan, arena, kept = unowned(plan), unowned(arena), unowned(kept)
    tail = arena.shape[0] - TAIL
    N, n_zones = int(arena[tail + N_AT]), int(arena[tail + ZONES_AT])
    shaped = attitude.shape == (3, 3) and target.shape == (3, 3)
    if not shaped or momentum.shape[0] != 3 or guess.shape != (N, 6):
        return BAD_SHAPE
    R_0, R_ref = load9_rows(attitude, 0), load9_rows(target, 0)
    Pi_0 = (momentum[0], momentum[1], momentum[2])
    omega, tau = data3(arena, tail + MOTION_AT), data3(arena, tail + MOTION_AT + 3)
    if not is_rotation(R_0) or not is_momentum(Pi_0):
        return BAD_STATE
    if not is_rotation(R_ref) or not is_momentum(omega) or not is_momentum(tau):
        return BAD_REFERENCE
    if not _is_finite(guess):
        return BAD_GUESS
    problem, W, work, rest = carve(arena, N, n_zones)
    if not set_track(problem[0], problem[1], R_ref, omega, tau, problem[3]):
        return BAD_REFERENCE
    R, Pi, u, lam, margins, numbers, reference = cut(plan, N, n_zones)
    store9_rows(reference, 0, R_ref)
    store9(R, 0, R_0)
    store3(Pi, 0, Pi_0)
    horizon, s = (R, Pi, u, lam[:N], W), tail + SETTINGS_AT
    rule, damping, estimated = int(arena[s + 1]), arena[s + 2], arena[s + 3] > 0.0
    tolerance, max_steps = arena[s + 4], int(arena[s + 5])
    if rule != CHORD:
        kept[0], kept[2] = 0, 0
    if arena[s] > 0.0:
        store3(lam, 0, load3(guess, 0))
        store3(lam, 0, load3(guess, 0, 3), 3)
        options = (rule, damping, estimated, tolerance, max_steps)
        status, steps, norm, pivot = _shoot(problem, horizon, work, rest, kept[2:], options)
    else:
        for k in range(N):
            store3(work[0], k, load3(guess, k, 3))
        status, steps, norm, pivot = newton(
            problem, horizon, work, kept[:2], rule, damping, estimated, tolerance, max_steps
        )
    if status != CONVERGED:
        kept[0], kept[2] = 0, 0
    numbers[0], numbers[1], numbers[2], numbers[4] = status, steps, norm, pivot
    if math.isfinite(norm):
        sum_up(problem, R_ref, horizon, lam, margins, numbers)
        return status
    leave_no_plan(R, Pi, u, lam, margins)
    numbers[3] = numbers[4] = numbers[5] = numbers[6] = numbers[7] = math.nan
    return status


@kernel
def solve_batch(attitudes, momenta, target, guesses, plans, arena, kept, status):
    """Solve from every row of ``attitudes`` (n, 3, 3) and ``momenta`` (n, 3) into ``plans``.

    ``guesses`` (1 or n, N, 6) are the multipliers to start from, of which the last serves the rest.
    """
    for j in range(status.shape[0]):
        kept[0], kept[2] = 0, 0  # a chord, too, starts each row by itself
        guess = guesses[min(j, guesses.shape[0] - 1)]
        status[j] = solve(
            given(attitudes[j]), given(momenta[j]), given(target), given(guess),
            plans[j], arena, kept,
        )  # fmt: skip
