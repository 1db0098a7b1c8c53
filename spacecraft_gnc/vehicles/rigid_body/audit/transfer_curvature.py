"""Second-order condition of a told transfer: its second variation where nothing acts.

The motion is taken out: with the turn s of the end so far, in its own frame, and dPi,

    s+ = s + C dPi,   dPi+ = A dPi + h du,

and the Lagrangian's second variation is the sum over the steps of

    |du|^2 + dPi . H dPi + C dPi . (c x s).

H is the derivative of `stage_gradients`, by an imaginary step, exact to rounding; the last term is
that of second order in the product of the turns (Baker, Campbell and Hausdorff). What acts strictly
is kept: torques on a bound do not change; a momentum on a bound, and the last one, is kept by the
torque before it, which follows from dPi. The end's turn has a large weight, and so has a momentum
whose torque is on a bound itself. A sweep from the end completes squares, step by step: where all
are positive, so is the second variation.
"""

from __future__ import annotations

from typing import Final

import numpy as np

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
WEIGHT: Final = 1e7
"""Of what is kept, over what it takes to keep it."""


def is_curved(plan: Transfer, least: float) -> bool:
    """Tell whether the second variation is more than ``least`` sum |du|^2 where nothing acts."""
    N, h, share = len(plan.torques), plan.time_step, 1.0 - least
    unit_u, _ = plan.units
    free = np.abs(plan.torque_multipliers) <= STRONG * unit_u
    kept = np.abs(plan.momentum_multipliers[1:]) * h > STRONG * unit_u
    kept[-1] = True
    held, left, soft = kept & free, free & ~kept, kept & ~free
    A, _, C = linearization(plan)
    H, bent = stage_hessians(plan), 0.5 * transposed(C) @ hats(plan.end_price)
    moment = float(np.linalg.eigvalsh(plan.inertia)[-1])
    P, ahead, momenta = np.zeros((6, 6)), np.eye(6), range(3, 6)
    P[:3, :3] = WEIGHT * 12.0 * moment**2 / (h**4 * N**3) * np.eye(3)
    for k in range(N - 1, -1, -1):
        P[momenta, momenta] += np.where(soft[k], WEIGHT / h**2, 0.0)
        ahead[:3, 3:], ahead[3:, 3:] = C[k], np.where(held[k][:, None], 0.0, A[k])
        along = P @ ahead
        pushed, answer = h * along[3:][left[k]], h**2 * P[3:, 3:][np.ix_(left[k], left[k])]
        P = ahead.T @ along
        P[3:, 3:] += H[k] + share / h**2 * A[k][held[k]].T @ A[k][held[k]]
        P[3:, :3] += bent[k]
        P[:3, 3:] += bent[k].T
        try:
            L = np.linalg.cholesky(answer + share * np.eye(len(answer)))
        except np.linalg.LinAlgError:
            return False
        pushed = np.linalg.solve(L, pushed)
        P -= pushed.T @ pushed
    return bool(np.isfinite(P).all())


def stage_hessians(plan: Transfer) -> Array:
    """Return H (N, 3, 3) of the stages."""
    F, Pi = plan.turns, plan.momenta[:-1]
    _, B, _ = linearization(plan)
    found = np.empty(F.shape)
    for i in range(3):
        turned = F @ (np.eye(3) + 1j * STEP * hats(B[:, :, i]))
        found[:, :, i] = stage_gradients(plan, turned, Pi + 1j * STEP * np.eye(3)[i]).imag / STEP
    return np.asarray(0.5 * (found + transposed(found)))
