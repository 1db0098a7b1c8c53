"""Kernels of control steps flown at once; `stretch` documents them."""

from __future__ import annotations

import math

from spacecraft_gnc._clock_kernels import now
from spacecraft_gnc._inner_kernels import inner_kernel
from spacecraft_gnc._kernels import given, kernel
from spacecraft_gnc.dynamics._lgvi_kernels import advance
from spacecraft_gnc.lie._mat3_kernels import dot, load3, load9_rows, store3, store9, store9_rows
from spacecraft_gnc.ocp._newton_kernels import CONVERGED
from spacecraft_gnc.ocp._solve_kernels import parts_of, solve, stand_still

ROUNDING = 1.0 + 1e-9  # more than separates the norms here from those of NumPy


@inner_kernel
def _is_finite(rows):
    """Whether torques (N, 3) are finite."""
    total = 0.0
    for k in range(rows.shape[0]):
        u = load3(rows, k)
        total += 0.0 * u[0] + 0.0 * u[1] + 0.0 * u[2]
    return total == 0.0


@inner_kernel
def _may_stand(error, travel, Pi, u, rest):
    """Whether `StandstillMonitor.may_stand` may hold, which decides with the last digit.

    ``rest``: its tolerance, its share of the error that a horizon turns, its horizon [s], and the
    momentum for an error of one radian.
    """
    if not error > rest[0] or travel > rest[1] * error * ROUNDING:
        return False
    stopped = math.sqrt(dot(Pi, Pi)) * rest[2] + 0.5 * math.sqrt(dot(u, u)) * rest[2] ** 2
    return stopped <= rest[3] * error * ROUNDING


@kernel
def fly_steps(
    inputs, warm, plans, arena, kept, body, h, substeps, patience, rest, state,
    attitudes, momenta, torques, counts, values,
):  # fmt: skip
    """Fly control steps until one is out of the ordinary or the rows are full; return how many.

    ``inputs`` (7, 3), R over Pi over R_ref, and ``warm`` (N, 6) move on from step to step; row
    k % 2 of the flat ``plans`` belongs to step k. ``state`` (5, 3) is room for `advance`. Row k of
    the last five arrays takes attitude, momentum, torque, iterations, and residual, cost and wall
    time [s] of the solve of step k.
    """
    N = warm.shape[0]
    stand_still(arena)
    for k in range(counts.shape[0]):
        plan, begun = plans[k % 2], now()
        status = solve(
            given(inputs[:3]), given(inputs[3]), given(inputs[4:]), given(warm), plan, arena, kept
        )
        values[k, 2] = now() - begun
        _, _, torque, lam, _, numbers, _ = parts_of(plan, arena)
        if status != CONVERGED or numbers[1] > patience or not _is_finite(torque):
            return k
        u = load3(torque, 0)
        if _may_stand(numbers[6], numbers[7], load3(inputs, 3), u, rest):
            return k
        for j in range(3):
            for row in range(4):
                state[row, j] = inputs[row, j]
        store3(state, 4, u)
        if advance(body, h, state, substeps) != substeps:
            return k
        counts[k], values[k, 0], values[k, 1] = int(numbers[1]), numbers[2], numbers[3]
        store3(momenta, k, load3(inputs, 3))
        store3(torques, k, u)
        store9(attitudes, k, load9_rows(inputs, 0))
        store9_rows(inputs, 0, load9_rows(state, 0))
        store3(inputs, 3, load3(state, 3))
        for row in range(N):
            store3(warm, row, load3(lam, row + 1))
            store3(warm, row, load3(lam, row + 1, 3), 3)
    return counts.shape[0]
