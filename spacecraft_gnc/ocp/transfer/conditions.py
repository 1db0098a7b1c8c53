"""First-order conditions (5.6)-(5.8) of a transfer, evaluated without the solver's kernels.

Phogat et al., (3.13) and (4.11) with gamma_k = h lambda_k, and with the multipliers of the bounds
as forces, alpha u and beta Pi, positive at upper bounds, so that bounds need not be symmetric:

    u_k + gamma_k + (alpha u)_k = 0,
    h (beta Pi)_k - gamma_k-1 + (F_k - h N_k hat(F_k^T Pi_k)) gamma_k + N_k Q_k^T zeta_0 = 0.

Erratum: the factor h after (3.13) is missing, u = -h lambda where no bound acts.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.ocp.transfer.problem import AttitudeTransfer
from spacecraft_gnc.types import Array, Vector3


class Residuals(NamedTuple):
    """Violations of the conditions, relative to the units of torque and momentum."""

    momentum: float
    """Of the momentum's dynamics, from a roll-out of the torque."""
    end_attitude: float
    """Angle from the last attitude of the roll-out to the goal [rad]."""
    end_momentum: float
    torque: float
    """Of (3.13)."""
    co_momentum: float
    """Of the co-momentum's dynamics."""
    bounds: float
    """Of the bounds of torque and momentum."""
    slackness: float
    """Largest multiplier with the wrong sign, or where no bound acts."""

    @property
    def largest(self) -> float:
        """The largest of them."""
        return max(self)


def units(problem: AttitudeTransfer) -> tuple[float, float]:
    """Return the units of torque [N m] and momentum [N m s] of a transfer."""
    T = problem.duration
    moment = float(np.linalg.eigvalsh(problem.body.inertia)[-1])
    change = float(np.linalg.norm(problem.goal_momentum - problem.start_momentum))
    torque = max(6.0 * max(problem.angle, 1e-2) * moment / T**2, change / T)
    return torque, 0.25 * torque * T


def evaluate(
    problem: AttitudeTransfer,
    torque: Array,
    momentum: Array,
    co_momentum: Array,
    zeta: Vector3,
    torque_multipliers: Array,
    momentum_multipliers: Array,
) -> tuple[Residuals, Array]:
    """Return the residuals of a plan, and its attitudes (N+1, 3, 3) by a roll-out.

    The arguments are those of `TransferSolution`.
    """
    body, h = problem.body, problem.body.time_step
    unit_u, unit_p = units(problem)
    attitudes, rolled = body.simulate(problem.start, problem.start_momentum, torque)
    F = np.einsum("kji,kjl->kil", attitudes[:-1], attitudes[1:])
    Jd = 0.5 * np.trace(body.inertia) * np.eye(3) - body.inertia
    JdFt = Jd @ F.transpose(0, 2, 1)
    traces = np.trace(JdFt, axis1=1, axis2=2)[:, None, None]
    N = np.linalg.solve(traces * np.eye(3) - JdFt, F)
    turned = np.einsum("kji,kj->ki", F, momentum[:-1])
    hats = np.zeros_like(F)
    hats[:, 2, 1], hats[:, 0, 2], hats[:, 1, 0] = turned.T
    hats -= hats.transpose(0, 2, 1)
    Qt = attitudes[1:].transpose(0, 2, 1) @ attitudes[1]  # (F_1 ... F_k)^T
    flow = np.einsum("kij,kj->ki", F - h * N @ hats, co_momentum)
    pull = np.einsum("kij,kj->ki", N, Qt @ zeta)
    co = h * momentum_multipliers[1:-1] - co_momentum[:-1] + flow[1:] + pull[1:]
    low_u, high_u, low_p, high_p = problem.limits
    inner = momentum[1:-1]
    beyond_u = np.maximum(low_u - torque, torque - high_u).max()
    beyond_p = np.maximum(low_p - inner, inner - high_p).max()
    slack = max(
        _slackness(torque, torque_multipliers, low_u, high_u, 1e-9 * unit_u),
        h * _slackness(inner, momentum_multipliers[1:-1], low_p, high_p, 1e-9 * unit_p),
    )
    residuals = Residuals(
        momentum=float(np.abs(rolled - momentum).max()) / unit_p,
        end_attitude=lie.angle_between(attitudes[-1], problem.goal),
        end_momentum=float(np.abs(rolled[-1] - problem.goal_momentum).max()) / unit_p,
        torque=float(np.abs(torque + co_momentum + torque_multipliers).max()) / unit_u,
        co_momentum=float(np.abs(co).max()) / unit_u,
        bounds=max(0.0, float(beyond_u) / unit_u, float(beyond_p) / unit_p),
        slackness=slack / unit_u,
    )
    return residuals, attitudes


def _slackness(x: Array, z: Array, low: Vector3, high: Vector3, near: float) -> float:
    """Return the largest multiplier that (5.8) does not allow."""
    wrong_low = np.where(x - low > near, np.maximum(-z, 0.0), 0.0)
    wrong_high = np.where(high - x > near, np.maximum(z, 0.0), 0.0)
    return float(max(wrong_low.max(), wrong_high.max()))
