"""Plans of transfers as the audit reads them, and their second variation as one dense matrix."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh, qr

from spacecraft_gnc.vehicles.rigid_body.audit.matrices import hats, transposed
from spacecraft_gnc.vehicles.rigid_body.audit.transfer_conditions import Transfer, linearization
from spacecraft_gnc.vehicles.rigid_body.audit.transfer_curvature import STRONG, stage_hessians


def transfer_of(solution):
    """Return the numbers of a solution."""
    problem = solution.problem
    return Transfer(
        problem.body.inertia, problem.body.time_step, problem.limits, problem.goal,
        solution.attitude, solution.momentum, solution.torque, solution.co_momentum,
        solution.zeta, solution.torque_multipliers, solution.momentum_multipliers,
    )  # fmt: skip


class SecondVariation(NamedTuple):
    """Hessian of the Lagrangian by the torques (3 N, 3 N), and derivatives by the torques."""

    hessian: np.ndarray
    momenta: np.ndarray
    """(N+1, 3, 3 N)."""
    end: np.ndarray
    """(3, 3 N) turn of the end."""


def second_variation(plan):
    """Return the Hessian of a plan and its derivatives."""
    N, h = len(plan.torques), plan.time_step
    A, _, C = linearization(plan)
    moved = np.zeros((N + 1, 3, 3 * N))
    for k in range(N):
        moved[k + 1] = A[k] @ moved[k]
        moved[k + 1, :, 3 * k : 3 * k + 3] += h * np.eye(3)
    turned = C @ moved[:-1]
    summed = np.cumsum(turned, axis=0)
    before = np.concatenate([np.zeros((1, 3, 3 * N)), summed[:-1]])
    along = stage_hessians(plan) @ moved[:-1] + transposed(C) @ (hats(plan.end_price) @ before)
    hessian = np.eye(3 * N) + moved[:-1].reshape(3 * N, -1).T @ along.reshape(3 * N, -1)
    return SecondVariation(0.5 * (hessian + hessian.T), moved, summed[-1])


def least_curvature(plan):
    """Return the least eigenvalue of the Hessian where nothing acts."""
    found = second_variation(plan)
    unit_u, _ = plan.units
    free = (np.abs(plan.torque_multipliers) <= STRONG * unit_u).ravel()
    pushed = np.abs(plan.momentum_multipliers) * plan.time_step > STRONG * unit_u
    pushed[[0, -1]] = [[False] * 3, [True] * 3]  # the last one is given
    kept = np.vstack([found.momenta[pushed], found.end])[:, free]
    kept /= np.linalg.norm(kept, axis=1, keepdims=True)
    Q, R, _ = qr(kept.T, pivoting=True)
    sizes = np.abs(np.diagonal(R))
    basis = Q[:, int(np.count_nonzero(sizes > 1e-11 * sizes.max())) :]
    reduced = basis.T @ found.hessian[np.ix_(free, free)] @ basis
    return float(eigh(reduced, eigvals_only=True, subset_by_index=[0, 0])[0])
