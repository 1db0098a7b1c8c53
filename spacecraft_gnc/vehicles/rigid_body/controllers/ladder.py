"""Fallback ladder: torque applied when the solver has no valid answer.

optimal -> neighboring extremal -> shifted plan -> saturated feedback -> zero torque.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.governors.feedback import AttitudeFeedback
from spacecraft_gnc.loop.protocols import Command, Reference, Source, State
from spacecraft_gnc.ocp import AttitudeOcp, Solution
from spacecraft_gnc.ocp.linearization import Linearization, deviation, linearize
from spacecraft_gnc.ocp.neighboring import FORMULATION as NEIGHBORING
from spacecraft_gnc.ocp.reference import is_moving
from spacecraft_gnc.types import Array, Vector3
from spacecraft_gnc.vehicles.rigid_body.controllers.report import SolveReport

# Attitude [rad] off the plan up to which its neighboring extremal is trusted.
NEIGHBORHOOD = 0.2
SAME_ATTITUDE = 1e-9  # of the entries of a rotation: as far as its motion was planned


class FallbackLadder:
    """Turn a solve, good or not, into a command; remember the last good plan.

    Parameters
    ----------
    ocp : AttitudeOcp
        Gives the actuators and their limit, and the inertia and period of the feedback law.
    """

    def __init__(self, ocp: AttitudeOcp) -> None:
        self._ocp = ocp
        self.reset()

    @cached_property
    def _feedback(self) -> AttitudeFeedback:
        """Made when it is needed, which is hardly ever."""
        ocp = self._ocp
        return AttitudeFeedback.critically_damped(
            ocp.body.inertia, ocp.time_step, ocp.max_torque, float(ocp.plant_step or 0.0)
        )

    def reset(self) -> None:
        """Forget the plan."""
        self._plan: Solution | None = None
        self._plan_step = 0
        self._neighborhood: Linearization | None = None

    def memory(self) -> tuple[Any, ...]:
        """Return the last good plan, and the step that it was made at."""
        return None if self._plan is None else self._plan.plain(), self._plan_step

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Take the plan of a `memory`."""
        plan, self._plan_step = memory
        self._plan = None if plan is None else Solution.of_plain(plan, self._ocp)
        self._neighborhood = None

    def command(self, state: State, reference: Reference, solution: Solution | None) -> Command:
        """Return the command of the highest rung that holds at ``state``."""
        report = SolveReport(solution)
        if solution is not None and solution.converged and _all_finite(solution.torques):
            self._plan, self._plan_step, self._neighborhood = solution, state.step, None
            corrected = solution.formulation == NEIGHBORING
            source = Source.NEIGHBORING_EXTREMAL if corrected else Source.OPTIMAL
            return Command(solution.torques[0], source, report)
        ahead = state.step - self._plan_step
        if self._plan is not None and 0 < ahead < len(self._plan.torques):
            torque = self._corrected(self._plan, ahead, state, reference)
            if torque is not None:
                return Command(torque, Source.NEIGHBORING_EXTREMAL, report)
            return Command(self._plan.torques[ahead], Source.SHIFTED_PLAN, report)
        torque = self._ocp.realizable(self._feedback.torque(state, reference))
        if math.isfinite(float(torque @ torque)):
            return Command(torque, Source.FEEDBACK, report)
        return Command(np.zeros(3), Source.ZERO, report)

    def _continues(self, planned: Reference, ahead: int, reference: Reference) -> bool:
        """Tell whether a reference is where the planned one has moved to ``ahead`` steps on."""
        if not is_moving(planned):
            return not is_moving(reference) and np.array_equal(reference.attitude, planned.attitude)
        turn = lie.exp(ahead * self._ocp.time_step * np.asarray(planned.angular_velocity))
        off = np.abs(reference.attitude - planned.attitude @ turn).max()
        same = all(map(np.array_equal, reference[1:], planned[1:]))
        return same and bool(off <= SAME_ATTITUDE)

    def _corrected(
        self, plan: Solution, ahead: int, state: State, reference: Reference
    ) -> Vector3 | None:
        """Torque of the plan with its neighboring extremal for where the body really is.

        None where the target has changed, or where the body has left the plan's neighborhood.
        """
        if not self._continues(plan.tracked, ahead, reference):
            return None
        if not np.isfinite(state.attitude).all():
            return None
        if self._neighborhood is None:
            self._neighborhood = linearize(plan)
        off = deviation(state.attitude, state.momentum, plan.attitudes[ahead], plan.momenta[ahead])
        torque = plan.torques[ahead] + self._neighborhood.gains[ahead] @ off
        if not np.isfinite(torque).all() or np.linalg.norm(off[:3]) > NEIGHBORHOOD:
            return None
        return self._ocp.realizable(torque)


def _all_finite(array: Array) -> bool:
    # A finite sum of squares has finite terms; three times faster than np.isfinite on small arrays.
    return math.isfinite(np.vdot(array, array)) or bool(np.isfinite(array).all())
