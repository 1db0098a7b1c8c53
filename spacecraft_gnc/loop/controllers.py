"""Torque laws behind the `Controller` protocol."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from spacecraft_gnc.errors import GncError
from spacecraft_gnc.loop.ladder import FALLBACK_BANDWIDTH, FallbackLadder, SaturatedFeedback
from spacecraft_gnc.loop.protocols import Command, Reference, State
from spacecraft_gnc.ocp import (
    AttitudeOcp,
    PointingZone,
    ShootingOptions,
    ShootingSolver,
    Solution,
    Weights,
)
from spacecraft_gnc.types import Array

if TYPE_CHECKING:
    from spacecraft_gnc.scenario import Scenario


class ShootingController:
    """NMPC by indirect single shooting, warm-started, with the failure ladder behind it.

    Parameters
    ----------
    solver : ShootingSolver

    Notes
    -----
    The multipliers of one solve, shifted by one step, start the next. A failed solve leaves no
    warm start behind; where a warm start fails, the same step is tried once more from zero.
    """

    name = "shooting"
    slow = False

    def __init__(self, solver: ShootingSolver) -> None:
        ocp = solver.ocp
        self.solver = solver
        self.period = ocp.time_step
        bandwidth = FALLBACK_BANDWIDTH / ocp.time_step
        feedback = SaturatedFeedback(ocp.body.inertia, bandwidth, ocp.max_torque)
        self._ladder = FallbackLadder(feedback)
        self._warm_start: Array | None = None

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> ShootingController:
        """Build the controller of a scenario's section ``nmpc_controller``."""
        c = scenario.controller
        options = ShootingOptions(c.residual_tolerance, c.max_iterations)
        return cls(ShootingSolver(problem_of(scenario), c.variant, options))

    def warm_up(self) -> None:
        """Compile or load the kernels."""
        self.solver.warm_up()

    def reset(self) -> None:
        """Forget warm start and plan."""
        self._warm_start = None
        self._ladder.reset()

    def command(self, state: State, reference: Reference) -> Command:
        """Solve from ``state`` and return the torque of the highest rung of the ladder."""
        return self._ladder.command(state, reference, self._solve(state, reference))

    def _solve(self, state: State, reference: Reference) -> Solution | None:
        try:
            solution = self.solver.solve(
                state.attitude, state.momentum, reference.attitude, self._warm_start
            )
            if self._warm_start is not None and not solution.converged:
                solution = self.solver.solve(state.attitude, state.momentum, reference.attitude)
        except GncError:  # a state or reference that is no state: the ladder deals with it
            self._warm_start = None
            return None
        self._warm_start = solution.warm_start
        return solution


def problem_of(scenario: Scenario) -> AttitudeOcp:
    """Return the optimal control problem of a scenario's section ``nmpc_controller``."""
    c = scenario.controller
    w = c.weights
    return AttitudeOcp(
        inertia=c.inertia,
        time_step=c.time_step,
        horizon=c.horizon,
        weights=Weights(
            w.stage_attitude,
            w.stage_momentum,
            w.stage_torque,
            w.terminal_attitude,
            w.terminal_momentum,
        ),
        max_torque=c.max_torque,
        torque_penalty=c.torque_penalty,
        zones=tuple(
            PointingZone(
                "inclusion" if zone.kind == "inclusion" else "exclusion",
                zone.body_axis,
                zone.inertial_axis,
                math.radians(zone.half_angle_deg),
                zone.penalty,
            )
            for zone in c.zones
        ),
    )
