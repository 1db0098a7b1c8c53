"""Kernels of control steps flown at once; `stretch` documents them."""

from __future__ import annotations

import math

from spacecraft_gnc._kernels import kernel
from spacecraft_gnc.dynamics._lgvi_kernels import advance
from spacecraft_gnc.lie._mat3_kernels import dot, load3
from spacecraft_gnc.ocp._newton_kernels import CONVERGED
from spacecraft_gnc.ocp._solve_kernels import solve

ROUNDING = 1.0 + 1e-9  # more than separates the norms here from those of NumPy


@kernel
def _is_finite(rows):
    """Whether torques (N, 3) are finite."""
    total = 0.0
    for k in range(rows.shape[0]):
        u = load3(rows, k)
        total += 0.0 * u[0] + 0.0 * u[1] + 0.0 * u[2]
    return total == 0.0


@kernel
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
    inputs, warm, R, Pi, u, lam, margins, arena, kept,
    single, rule, damping, estimated, tolerance, max_steps,
    numbers, body, h, substeps, patience, rest, state, attitudes, momenta, torques, counts, values,
):  # fmt: skip
    """Fly control steps until one is out of the ordinary or the rows are full; return how many.

    The first arguments are those of `solve`: ``inputs`` and ``warm`` move on from step to step, and
    each array of a plan has room for two, of which row k % 2 belongs to step k, like the
    ``numbers`` (2, 8) that `solve` returns. ``state`` (5, 3) is room for `advance`. Row k of the
    last five arrays takes attitude, momentum, torque, iterations, and residual and cost of step k.
    """
    for k in range(counts.shape[0]):
        i = k % 2
        status, steps, norm, cost, pivot, largest, error, travel = solve(
            inputs, warm, R[i], Pi[i], u[i], lam[i], margins[i], arena, kept,
            single, rule, damping, estimated, tolerance, max_steps,
        )  # fmt: skip
        if status != CONVERGED or steps > patience or not _is_finite(u[i]):
            return k
        if _may_stand(error, travel, load3(inputs, 3), load3(u[i], 0), rest):
            return k
        for j in range(3):
            for row in range(4):
                state[row, j] = inputs[row, j]
            state[4, j] = u[i, 0, j]
        if advance(body, h, state, substeps) != substeps:
            return k
        n = numbers[i]
        n[0], n[1], n[2], n[3] = status, steps, norm, cost
        n[4], n[5], n[6], n[7] = pivot, largest, error, travel
        counts[k], values[k, 0], values[k, 1] = steps, norm, cost
        for j in range(3):
            momenta[k, j], torques[k, j] = inputs[3, j], u[i, 0, j]
            inputs[3, j] = state[3, j]
            for row in range(3):
                attitudes[k, row, j] = inputs[row, j]
                inputs[row, j] = state[row, j]
        for row in range(warm.shape[0]):
            for j in range(6):
                warm[row, j] = lam[i, row + 1, j]
    return counts.shape[0]
