"""The failure ladder: which torque is flown when the best one is not to be had.

optimal -> (neighbouring extremal) -> shifted plan -> saturated feedback -> zero torque.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.loop.protocols import Command, Reference, Source, State
from spacecraft_gnc.ocp import Solution
from spacecraft_gnc.types import Array, Matrix3, Vector3

# Bandwidth of the fallback law in units of 1/period: slow enough for any sampled double integrator.
FALLBACK_BANDWIDTH = 0.05


@dataclass(frozen=True, slots=True)
class SaturatedFeedback:
    """T = -K Pi - e, scaled down to the torque limit where it exceeds it.

    hat(e) = A E - E^T A with E = R_ref^T R. Source: Kalabic et al. 2014, (8)-(10), with
    A = J omega^2 / 2 and K = 2 omega (critical damping) for one bandwidth omega.

    Attributes
    ----------
    inertia : (3, 3) array
        [kg m^2]
    bandwidth : float
        omega [rad/s].
    max_torque : float
        Limit on |T| [N m]; 0 means none.
    """

    inertia: Matrix3
    bandwidth: float
    max_torque: float

    def torque(self, state: State, reference: Reference) -> Vector3:
        """Return the body torque (3,) [N m] at ``state`` towards ``reference``."""
        stiffness = 0.5 * self.bandwidth**2 * self.inertia
        relative = reference.attitude.T @ state.attitude
        e = 2.0 * lie.vee(stiffness @ relative)  # vee takes the antisymmetric half
        torque = -2.0 * self.bandwidth * state.momentum - e
        size = float(np.linalg.norm(torque))
        if 0.0 < self.max_torque < size:
            torque *= self.max_torque / size
        return np.asarray(torque)


class FallbackLadder:
    """Turn a solve, good or not, into a command; remember the last good plan.

    Parameters
    ----------
    feedback : SaturatedFeedback
        The law for when no plan is left.
    """

    def __init__(self, feedback: SaturatedFeedback) -> None:
        self._feedback = feedback
        self._plan: Array = np.empty((0, 3))
        self._plan_step = 0

    def reset(self) -> None:
        """Forget the plan."""
        self._plan = np.empty((0, 3))

    def command(self, state: State, reference: Reference, solution: Solution | None) -> Command:
        """Return the command of the highest rung that holds at ``state``."""
        if solution is not None and solution.converged and np.isfinite(solution.torques).all():
            self._plan, self._plan_step = solution.torques, state.step
            return Command(solution.torques[0], Source.OPTIMAL, solution)
        ahead = state.step - self._plan_step
        if 0 < ahead < len(self._plan):
            return Command(self._plan[ahead], Source.SHIFTED_PLAN, solution)
        torque = self._feedback.torque(state, reference)
        if math.isfinite(float(torque @ torque)):
            return Command(torque, Source.FEEDBACK, solution)
        return Command(np.zeros(3), Source.ZERO, solution)
