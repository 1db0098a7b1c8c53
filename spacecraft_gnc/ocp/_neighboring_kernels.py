"""Kernels of the neighbouring extremals; see `neighboring` (on line) and `nominal` (stored run).

On line they live on what a backward sweep leaves in the solver's arena: the multipliers ``guess``,
their mismatch ``resid`` at the last state, R over Pi, and a factorisation.
"""

from __future__ import annotations

import math

from spacecraft_gnc._kernels import kernel
from spacecraft_gnc.lie._mat3_kernels import (
    dot,
    load3,
    load9,
    load9_flat,
    load9_rows,
    mat_t_mat,
    mat_vec,
    scale,
    store3,
    store9,
    sub,
    vee_antisymmetric,
)
from spacecraft_gnc.ocp._data_kernels import ALPHA, H
from spacecraft_gnc.ocp._newton_kernels import move
from spacecraft_gnc.ocp._solve_kernels import carve, is_rotation, repeat_last, summarise
from spacecraft_gnc.ocp._stage_kernels import horizon_cost, squared_control
from spacecraft_gnc.ocp._sweep_kernels import U_AT, evaluate, substitute

LAST = 7  # row of ``inputs`` where the last state stands


@kernel
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


@kernel
def _cut(data, u, W):
    """Scale u_0 down to the torque limit, which the penalty lets it pass by a little."""
    zz = squared_control(W, 0)
    if data[ALPHA] > 0.0 and zz > data[ALPHA]:
        store3(u, 0, scale((1.0 - 2.0**-52) * math.sqrt(data[ALPHA] / zz), load3(u, 0)))


@kernel
def correct(inputs, R, Pi, u, lam, margins, arena, kept):
    """Carry the last optimum over to the state in ``inputs`` (11, 3), rows R, Pi, R_ref, last.

    One solve with the kept factorisation predicts the multipliers, one evaluation shows what is
    left of the conditions, and a second solve the error of the torque. Returns whether the state
    was good and the same limits act, the predicted error of u_0, and the numbers of `solve`.
    """
    nan = math.nan
    N = u.shape[0]
    R_0, Pi_0, R_ref = load9_rows(inputs, 0), load3(inputs, 3), load9_rows(inputs, 4)
    problem, W, work, _ = carve(arena, N, margins.shape[0])
    body, data, zones, track = problem
    guess, trial, resid, step, fac = work
    if not is_rotation(R_0) or not math.isfinite(dot(Pi_0, Pi_0)):
        return False, nan, nan, nan, nan, nan, nan
    eta = small_rotation_vector(mat_t_mat(load9_rows(inputs, LAST), R_0))
    substitute(data[H], fac, resid, eta, sub(Pi_0, load3(inputs, LAST + 3)), 0.0, step)
    move(guess, 1.0, step, trial)
    store9(R, 0, R_0)
    store3(Pi, 0, Pi_0)
    status, norm, pattern = evaluate(body, data, zones, track, trial, R, Pi, u, lam[:N], resid, W)
    if status != 0 or not math.isfinite(norm):
        return False, nan, norm, nan, nan, nan, nan
    zero = (0.0, 0.0, 0.0)
    substitute(data[H], fac, resid, zero, zero, 0.0, step)
    left = mat_vec(load9_flat(fac, 0, U_AT), load3(step, 0))
    move(trial, 0.0, trial, guess)
    for i in range(4):
        store3(inputs, LAST + i, load3(inputs, i))
    repeat_last(lam)
    cost = horizon_cost(data, zones, track, R, Pi, W)
    largest, error, travel = summarise(zones, R_ref, R, W, margins)
    _cut(data, u, W)
    return pattern == kept[1], math.sqrt(dot(left, left)), norm, cost, largest, error, travel
