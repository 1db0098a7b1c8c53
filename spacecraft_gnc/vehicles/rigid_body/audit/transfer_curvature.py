"""Second-order condition of a told transfer: its Hessian, reduced to what the bounds leave.

The motion is taken out: dPi_k and the turn s of the end are linear in the torques du, and the
Lagrangian's second variation is

    sum |du|^2 + dPi_k . H_k dPi_k + y_k . (c x s_k),   y_k = C_k dPi_k,   s_k = y_0 + .. + y_k-1.

H_k is the derivative of `stage_gradients`, by an imaginary step, exact to rounding; the last terms
are those of second order in the product of the turns (Baker, Campbell and Hausdorff). What acts
strictly is kept: bounds with a multiplier, and the end.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from scipy.linalg import eigh, qr

from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.audit.matrices import hats, transposed
from spacecraft_gnc.vehicles.rigid_body.audit.transfer_conditions import (
    Transfer,
    linearization,
    stage_gradients,
)

STEP: Final = 1e-20
"""Imaginary step."""
STRONG: Final = 1e-9
"""Multiplier, over the unit, from which a bound acts."""
_DEPENDENT: Final = 1e-11
"""Share of the largest row below which a row depends on the others."""


class SecondVariation(NamedTuple):
    """Hessian of the Lagrangian by the torques, and what their changes are kept from."""

    hessian: Array
    """(3 N, 3 N)."""
    momenta: Array
    """(N+1, 3, 3 N) derivatives of the momenta."""
    end: Array
    """(3, 3 N) turn of the end."""


def second_variation(plan: Transfer) -> SecondVariation:
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
    along = _stage_hessians(plan) @ moved[:-1] + transposed(C) @ (hats(plan.end_price) @ before)
    hessian = np.eye(3 * N) + moved[:-1].reshape(3 * N, -1).T @ along.reshape(3 * N, -1)
    return SecondVariation(0.5 * (hessian + hessian.T), moved, summed[-1])


def least_curvature(plan: Transfer) -> float:
    """Return the least eigenvalue of the Hessian where nothing acts; infinite where all is kept."""
    found = second_variation(plan)
    unit_u, _ = plan.units
    free = (np.abs(plan.torque_multipliers) <= STRONG * unit_u).ravel()
    pushed = np.abs(plan.momentum_multipliers) * plan.time_step > STRONG * unit_u
    pushed[[0, -1]] = [[False] * 3, [True] * 3]  # the last one is given
    kept = np.vstack([found.momenta[pushed], found.end])[:, free]
    kept /= np.maximum(np.linalg.norm(kept, axis=1, keepdims=True), 1e-300)
    Q, R, _ = qr(kept.T, pivoting=True)
    sizes = np.abs(np.diagonal(R))
    rank = int(np.count_nonzero(sizes > _DEPENDENT * max(float(sizes.max(initial=0.0)), 1e-300)))
    basis = Q[:, rank:]
    if not basis.shape[1]:
        return np.inf
    reduced = basis.T @ found.hessian[np.ix_(free, free)] @ basis
    return float(eigh(reduced, eigvals_only=True, subset_by_index=[0, 0])[0])


def _stage_hessians(plan: Transfer) -> Array:
    """Return H (N, 3, 3) of the stages."""
    F, Pi = plan.turns, plan.momenta[:-1]
    _, B, _ = linearization(plan)
    found = np.empty(F.shape)
    for i in range(3):
        turned = F @ (np.eye(3) + 1j * STEP * hats(B[:, :, i]))
        found[:, :, i] = stage_gradients(plan, turned, Pi + 1j * STEP * np.eye(3)[i]).imag / STEP
    return np.asarray(0.5 * (found + transposed(found)))
