"""The optimal control linearized in its initial state: gains of the neighboring extremals.

Around a solution, delta u_k = K_k (eta_k, delta Pi_k) to first order, where a neighboring attitude
is R_k exp(hat(eta_k)). Source: Bagherzadeh et al. 2023, (62)-(69), with its errata: (52) means
delta x_k, the left side of (63) is eta_{k+1}, and the penalty replaces the rows of the constraint,
which (60) and (65) would count twice.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.arguments import require_kind
from spacecraft_gnc.ocp import _stage_kernels, _sweep_kernels
from spacecraft_gnc.ocp.rollout import track_of
from spacecraft_gnc.ocp.solution import Solution
from spacecraft_gnc.types import Array, Matrix3, Vector3


class Linearization(NamedTuple):
    """A solution and its first-order neighborhood."""

    gains: Array
    """(N, 3, 6) K_k: torque of stage k to (eta_k, delta Pi_k) [N m/rad, 1/s]."""
    transitions: Array
    """(N, 6, 6) derivative of (eta, Pi)_{k+1} to (eta, Pi)_k at fixed torques."""
    min_curvature: float
    """Smallest pivot at the solution itself; NaN where a number overflowed."""
    time_step: float
    """[s]"""

    @property
    def closed_loop(self) -> Array:
        """(6, 6) derivative of one closed-loop step: A_0 + (0, h I) K_0."""
        jacobian = self.transitions[0].copy()
        jacobian[3:] += self.time_step * self.gains[0]
        return np.asarray(jacobian)


def factorization(solution: Solution) -> Array:
    """Return the rows of ``fac`` (`_sweep_kernels`) of one sweep at a converged solution."""
    ocp, n = solution.ocp, len(solution.torques)
    R, Pi = solution.attitudes.copy(), solution.momenta.copy()
    u, lam, resid = np.empty((n, 3)), np.empty((n, 6)), np.empty((n, 3))
    W = np.zeros((n, _stage_kernels.work_size(ocp.n_controls)))
    fac = np.zeros((n, _sweep_kernels.FACTOR_SIZE))
    track = track_of(ocp, solution.tracked)
    problem = (ocp.body.packed, ocp.data, ocp.zone_rows, track)
    guess = np.ascontiguousarray(solution.costates[:, 3:])
    _sweep_kernels.evaluate(*problem, guess, R, Pi, u, lam, resid, W)
    _sweep_kernels.factorize(*problem, R, Pi, lam, W, fac, 0.0, False)
    return fac


def linearize(solution: Solution) -> Linearization:
    """Return the gains along a converged solution, from one sweep at the solution itself."""
    require_kind("solution", solution, Solution)
    ocp, n = solution.ocp, len(solution.torques)
    fac = factorization(solution)

    def block(at: int) -> Array:
        return np.asarray(fac[:, at : at + 9].reshape(n, 3, 3))

    transitions = np.zeros((n, 6, 6))
    transitions[:, :3, :3] = block(_sweep_kernels.F_AT).transpose(0, 2, 1)
    transitions[:, :3, 3:] = block(_sweep_kernels.MF_AT)
    transitions[:, 3:, 3:] = block(_sweep_kernels.AF_AT)
    feedback = np.concatenate([block(_sweep_kernels.K1_AT), block(_sweep_kernels.K2_AT)], axis=2)
    pivot = _sweep_kernels.smallest_pivot(ocp.time_step, fac)
    return Linearization(
        -block(_sweep_kernels.U_AT) @ feedback, transitions, float(pivot), ocp.time_step
    )


def deviation(
    attitude: Matrix3, momentum: Vector3, nominal_attitude: Matrix3, nominal_momentum: Vector3
) -> Array:
    """Return (6,) (eta, delta Pi) that leads from the nominal state to the given one."""
    eta = lie.log(nominal_attitude.T @ attitude)
    return np.concatenate([eta, np.asarray(momentum) - nominal_momentum])
