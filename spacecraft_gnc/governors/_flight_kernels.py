"""Kernels of a predicted closed loop; `controller_loop` documents them.

``rows`` (7, 3): R over Pi over R_ref. ``limits`` (3,): largest torque, largest momentum (0: none),
level of the settled set. ``worst`` (3,): the margin nearest to its bound as a share of the limit
(zones: in rad), the same in its own unit, and which constraint: a zone's row, or after the zones
`TORQUE`, `MOMENTUM`, `CONDITION`, `CONVERGENCE`, `SOLVER`.
"""

from __future__ import annotations

import math

from spacecraft_gnc._inner_kernels import inner_kernel
from spacecraft_gnc._kernels import given, kernel
from spacecraft_gnc.dynamics._lgvi_kernels import advance, solvable
from spacecraft_gnc.governors._zone_kernels import zone_margin
from spacecraft_gnc.lie._mat3_kernels import (
    dot,
    load3,
    load9_rows,
    mat_t_mat,
    store3,
    vee_antisymmetric,
)
from spacecraft_gnc.ocp._newton_kernels import CONVERGED
from spacecraft_gnc.ocp._solve_kernels import parts_of, solve, stand_still

TORQUE, MOMENTUM, CONDITION, CONVERGENCE, SOLVER = 0, 1, 2, 3, 4
SETTLED, ONWARD = -1, -2


@kernel
def violates(worst, room, limit, reserve, which):
    """Whether ``room`` is less than the reserve; keeps the worst, and what is violated."""
    share = room / limit
    violated = not share >= reserve
    if violated or share < worst[0]:
        worst[0], worst[1], worst[2] = share, room, which
    return violated


@inner_kernel
def _settled(rows, metric, level):
    """Whether the state lies in the settled set x^T P x <= level, x = (eta, Pi)."""
    E = mat_t_mat(load9_rows(rows, 4), load9_rows(rows, 0))
    if E[0] + E[4] + E[8] <= 1.0:  # a quarter turn or more away
        return False
    eta = vee_antisymmetric(E)
    value = 0.0
    for i in range(6):
        x_i = eta[i] if i < 3 else rows[3, i - 3]
        for j in range(6):
            value += x_i * metric[i, j] * (eta[j] if j < 3 else rows[3, j - 3])
    return value <= level


@kernel
def examine(rows, body, h, zones, limits, metric, reserve, worst):
    """Check one state: the constraint that it violates, or `SETTLED`, or `ONWARD`."""
    R, Pi, n = load9_rows(rows, 0), load3(rows, 3), zones.shape[0]
    for i in range(n):
        if violates(worst, zone_margin(zones, i, R), 1.0, reserve, i):
            return i
    if limits[1] > 0.0:
        room = limits[1] - math.sqrt(dot(Pi, Pi))
        if violates(worst, room, limits[1], reserve, n + MOMENTUM):
            return n + MOMENTUM
    if not solvable(body, h, Pi):
        return n + CONDITION
    return SETTLED if _settled(rows, metric, limits[2]) else ONWARD


@kernel
def fly(
    rows, warm, plan, arena, kept,
    body, h, substeps, zones, limits, metric, reserve, n_steps, state, worst,
):  # fmt: skip
    """Fly the loop of exact solves until it settles, violates or n steps are over.

    ``warm`` (2, N, 6) are the multipliers of a solve: cold, then warm. ``plan`` is room for one,
    ``state`` (5, 3) for `advance`. Leaves the last state in ``rows``; returns what `examine` says
    of it and its step.
    """
    n, is_warm, N = zones.shape[0], False, warm.shape[1]
    kept[0], kept[2] = 0, 0
    stand_still(arena)
    for k in range(n_steps + 1):
        found = examine(rows, body, h, zones, limits, metric, reserve, worst)
        if found != ONWARD or k == n_steps:
            return found, k
        status = -1
        for attempt in range(2):  # where a warm start fails, once more from zero
            if attempt == 1 and (status == CONVERGED or not is_warm):
                break
            start = warm[1] if is_warm and attempt == 0 else warm[0]
            status = solve(
                given(rows[:3]), given(rows[3]), given(rows[4:]), given(start), plan, arena, kept
            )
        if status != CONVERGED:
            return n + SOLVER, k
        is_warm = True
        _, _, torques, lam, _, _, _ = parts_of(plan, arena)
        for i in range(N):
            store3(warm[1], i, load3(lam, i + 1))
            store3(warm[1], i, load3(lam, i + 1, 3), 3)
        u = load3(torques, 0)
        if limits[0] > 0.0:
            room = limits[0] - math.sqrt(dot(u, u))
            if violates(worst, room, limits[0], reserve, n + TORQUE):
                return n + TORQUE, k
        for i in range(3):
            for j in range(4):
                state[j, i] = rows[j, i]
        store3(state, 4, u)
        if advance(body, h, state, substeps) != substeps:
            return n + CONDITION, k + 1
        for i in range(3):
            for j in range(4):
                rows[j, i] = state[j, i]
    return ONWARD, n_steps
