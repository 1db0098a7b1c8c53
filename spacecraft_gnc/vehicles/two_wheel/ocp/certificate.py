"""Second-order certificate of a plan for two wheels: the least curvature that is left to it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array


def least_curvature(
    dynamics: tuple[Array, Array], hessians: Array, end: Array, active: NDArray[np.bool_]
) -> float:
    """Return the smallest eigenvalue of the reduced Hessian by the accelerations [(s^2/rad)^2].

    Parameters
    ----------
    dynamics : (N, n, n), (N, n, 2) arrays
        Derivatives of the next state by state and accelerations; the last two states are speeds.
    hessians : (N+1, n+2, n+2) array
        Of the Lagrangian by state and accelerations of each stage.
    end : (p, n) array
        Derivatives of the conditions at the end by the last state.
    active : (N, 4) array of bool
        Bounds with a multiplier: of the speeds after each step (columns 0, 1), which the last row
        leaves out, and of the accelerations (columns 2, 3).

    Returns
    -------
    float
        Infinity where conditions and active bounds leave no direction.
    """
    A, B = dynamics
    N, n = A.shape[:2]
    motion = np.zeros((N + 1, n + 2, 2 * N))
    for k in range(N):
        motion[k, n:, 2 * k : 2 * k + 2] = np.eye(2)
        motion[k + 1, :n] = A[k] @ motion[k, :n] + B[k] @ motion[k, n:]
    flat = motion.reshape(-1, 2 * N)
    hessian = flat.T @ (hessians @ motion).reshape(-1, 2 * N)
    speeds, accelerations = motion[1:N, n - 2 : n][active[:-1, :2]], motion[:N, n:][active[:, 2:]]
    return reduced_curvature(hessian, np.vstack([end @ motion[N, :n], speeds, accelerations]))


def reduced_curvature(hessian: Array, conditions: Array) -> float:
    """Return the smallest eigenvalue of a Hessian (n, n) over the null space of rows (c, n)."""
    scaled = conditions / np.maximum(np.linalg.norm(conditions, axis=1, keepdims=True), 1e-300)
    _, sizes, rows = np.linalg.svd(scaled)
    free = rows[int(np.count_nonzero(sizes > 1e-10)) :]
    if not len(free):
        return math.inf
    return float(np.linalg.eigvalsh(free @ hessian @ free.T)[0])
