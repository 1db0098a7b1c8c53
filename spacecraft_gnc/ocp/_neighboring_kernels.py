"""Kernels of the neighboring extremals; see `neighboring` (on line) and `nominal` (stored run).

On line they live on what a backward sweep leaves in the solver's arena: the multipliers ``guess``,
their mismatch ``resid`` at the last state, R over Pi, and a factorization.
"""

from __future__ import annotations

import math

from spacecraft_gnc._inner_kernels import inner_kernel
from spacecraft_gnc._kernels import kernel, unowned
from spacecraft_gnc.lie._mat3_kernels import (
    add,
    dot,
    load3,
    load9,
    load9_rows,
    mat_mat,
    mat_t_mat,
    scale,
    store3,
    store9,
    store9_rows,
    sub,
    vee_antisymmetric,
)
from spacecraft_gnc.ocp._data_kernels import ALPHA, H
from spacecraft_gnc.ocp._newton_kernels import CONVERGED, move
from spacecraft_gnc.ocp._solve_kernels import (
    carve,
    is_momentum,
    is_rotation,
    parts_of,
    sum_up,
)
from spacecraft_gnc.ocp._stage_kernels import control, squared_control
from spacecraft_gnc.ocp._sweep_kernels import evaluate, substitute
from spacecraft_gnc.ocp._track_kernels import set_track

LAST = 9  # row of ``inputs`` where the last state stands
SEEN = 13  # row: the largest contraction seen since the factorization, per step; steps since then
LAST_REFERENCE = 14  # row where the last reference attitude stands
# What is claimed beyond the geometric series; docs/solver.md has what was measured.
SAFETY = 2.0  # of the bound, for a contraction seen once
CAUTION = 4.0  # of a contraction that was seen on earlier steps and not on this one


@inner_kernel
def small_rotation_vector(E):
    """Rotation vector of E, for angles below half a turn."""
    v = vee_antisymmetric(E)
    sine = math.sqrt(dot(v, v))
    angle = math.atan2(sine, 0.5 * (E[0] + E[4] + E[8] - 1.0))
    return scale(angle / sine, v) if sine > 1e-8 else v


@kernel
def feed_back(attitudes, momenta, torques, gains, k, state, u):
    """Torque u of step k of a stored run, corrected for ``state`` (4, 3), rows R and Pi."""
    eta = small_rotation_vector(mat_t_mat(load9(attitudes, k), load9_rows(state, 0)))
    off = sub(load3(state, 3), load3(momenta, k))
    for i in range(3):
        u[i] = torques[k, i]
        for j in range(3):
            u[i] += gains[k, i, j] * eta[j] + gains[k, i, 3 + j] * off[j]


@inner_kernel
def _cut(data, u, W):
    """Scale u_0 down to the torque limit, which the penalty lets it pass by a little."""
    zz = squared_control(W, 0)
    if data[ALPHA] > 0.0 and zz > data[ALPHA]:
        store3(u, 0, scale((1.0 - 2.0**-52) * math.sqrt(data[ALPHA] / zz), load3(u, 0)))


@inner_kernel
def _fill_torques(data, track, guess, u, W):
    """Fill the torques u, and the controls in W, that follow from the multipliers by (38)."""
    for k in range(u.shape[0]):
        store3(u, k, control(data, track, load3(guess, k), W, k)[0])


@inner_kernel
def _torque_change(data, track, guess, step, u, W):
    """Euclidean norm, over all stages, of how far ``step`` moves the torques u of the guess.

    By (38) itself, not by its derivative: a stage at the border of its limit counts in full.
    Leaves other controls in W.
    """
    total = 0.0
    for k in range(u.shape[0]):
        moved, _ = control(data, track, add(load3(guess, k), load3(step, k)), W, k)
        d = sub(moved, load3(u, k))
        total += dot(d, d)
    return math.sqrt(total)


@kernel
def error_bound(change, contraction):
    """Bound of what is left after a correction, from the next one, which is not made.

    Where the changes go on falling by the factor ``contraction``, change / (1 - contraction) is.
    """
    if change == 0.0:
        return 0.0
    if not contraction < 1.0:
        return math.inf
    return SAFETY * change / (1.0 - contraction)


@inner_kernel
def _correct_until(allowed, problem, horizon, work, pattern, seen):
    """Make the correction in ``step``, and one more where the first bound exceeds ``allowed``.

    What the second one moves over what the first one moved is the contraction; the first bound
    takes it from earlier steps, ``seen`` (`SEEN`), in proportion to the age. Returns
    the bound, infinite where other limits act than ``pattern`` has, and the residual. The last
    point is left in ``trial``, its residual in ``resid``.
    """
    body, data, zones, track = problem
    R, Pi, u, lam, W = horizon
    guess, trial, resid, step, fac = work
    zero = (0.0, 0.0, 0.0)
    move(guess, 1.0, step, trial)
    last_change, bound, norm = math.inf, math.inf, math.inf
    for correction in range(2):
        if correction > 0:
            move(trial, 1.0, step, trial)
        status, norm, acts = evaluate(body, data, zones, track, trial, R, Pi, u, lam, resid, W)
        if status != 0 or acts != pattern or not math.isfinite(norm):
            return math.inf, norm
        substitute(data[H], fac, resid, zero, zero, 0.0, step)
        change = _torque_change(data, track, trial, step, u, W)
        if correction == 0:
            bound = error_bound(change, CAUTION * seen[0] * seen[1])
            if bound <= allowed:
                return bound, norm
            last_change = change
        else:
            q = change / last_change if last_change > 0.0 else 0.0
            bound = error_bound(change, q)
            seen[0] = max(q / seen[1], seen[0] if seen[0] < math.inf else 0.0)
    return bound, norm


@kernel
def correct(inputs, moving, allowed, plan, arena, kept):
    """Carry the last optimum over to the state and reference in ``inputs`` (17, 3), into ``plan``.

    Its rows are R, Pi, R_ref, omega_ref, tau_ref, the last R and Pi, what was seen (`SEEN`) and the
    last R_ref. One solve with the kept factorization predicts the multipliers, and one or two more
    correct them; the last correction is not made, but shows how far the torques would move once
    more. Where the reference is ``moving``, the last optimum is turned along with it first.

    Returns success and the bound of the error of all torques. The curvature is left to the caller.
    """
    plan, arena, kept, inputs = unowned(plan), unowned(arena), unowned(kept), unowned(inputs)
    R_0, Pi_0, R_ref = load9_rows(inputs, 0), load3(inputs, 3), load9_rows(inputs, 4)
    R, Pi, u, lam, margins, numbers, target = parts_of(plan, arena)
    N = u.shape[0]
    problem, W, work, _ = carve(arena, N, margins.shape[0])
    body, data, _, track = problem
    guess, trial, resid, step, fac = work
    if not is_rotation(R_0) or not is_momentum(Pi_0):
        return False, math.nan
    last = load9_rows(inputs, LAST)
    if moving:
        omega, tau = load3(inputs, 7), load3(inputs, 8)
        if not is_rotation(R_ref) or not is_momentum(omega) or not is_momentum(tau):
            return False, math.nan
        if not set_track(body, data, R_ref, omega, tau, track):
            return False, math.nan
        last = mat_mat(R_ref, mat_t_mat(load9_rows(inputs, LAST_REFERENCE), last))
    eta = small_rotation_vector(mat_t_mat(last, R_0))
    substitute(data[H], fac, resid, eta, sub(Pi_0, load3(inputs, LAST + 3)), 0.0, step)
    store9(R, 0, R_0)
    store3(Pi, 0, Pi_0)
    seen = inputs[SEEN]
    seen[1] += 1.0
    horizon = (R, Pi, u, lam[:N], W)
    bound, norm = _correct_until(allowed, problem, horizon, work, kept[1], seen)
    if not bound <= allowed:
        return False, bound
    move(trial, 0.0, trial, guess)
    for i in range(4):
        store3(inputs, LAST + i, load3(inputs, i))
    if moving:
        store9_rows(inputs, LAST_REFERENCE, R_ref)
    _fill_torques(data, track, guess, u, W)  # and the controls in W, which the cost needs
    store9_rows(target, 0, R_ref)
    numbers[0], numbers[1], numbers[2] = CONVERGED, 0, norm
    sum_up(problem, R_ref, horizon, lam, margins, numbers)
    _cut(data, u, W)
    return True, bound
