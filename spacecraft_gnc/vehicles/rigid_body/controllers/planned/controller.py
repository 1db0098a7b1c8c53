"""``method: planned`` behind the `Controller` protocol."""

from __future__ import annotations

from typing import Any

from spacecraft_gnc.arguments import require_kind
from spacecraft_gnc.governors.planned.guard import BoundGuard
from spacecraft_gnc.governors.planned.keeper import PlanKeeper
from spacecraft_gnc.loop.protocols import Command, Reference, State
from spacecraft_gnc.vehicles.rigid_body.controllers.planned.tracking import tracking_of
from spacecraft_gnc.vehicles.rigid_body.controllers.report import SolveReport
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import ShootingController
from spacecraft_gnc.vehicles.rigid_body.planner.keeper import guard_of, keeper_of
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario


class PlannedController:
    """``method: planned``: an optimal transfer, tracked by Newton's NMPC, within its bounds.

    The reference given is the target, at rest. What is tracked is the motion of the plan, and after
    its end the target. What the tracking asks for is clipped to the bounds.

    Parameters
    ----------
    tracking : ShootingController
    keeper : PlanKeeper
    guard : BoundGuard
    """

    name = "planned"
    slow = False

    def __init__(self, tracking: ShootingController, keeper: PlanKeeper, guard: BoundGuard) -> None:
        self.tracking = require_kind("tracking", tracking, ShootingController)
        self.keeper = require_kind("keeper", keeper, PlanKeeper)
        self._guard = require_kind("guard", guard, BoundGuard)
        self.period = tracking.period

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> PlannedController:
        """Build the controller of a scenario's section ``nmpc_controller``.

        Raises
        ------
        GncError
            If a parameter is refused, or no plan is found from the start to the target.
        """
        guard = guard_of(scenario)
        return cls(tracking_of(scenario), keeper_of(scenario, guard), guard)

    @property
    def waits(self) -> bool:
        """Whether a step waits for the plan that is due at it (`PlanKeeper`)."""
        return self.keeper.waits

    @waits.setter
    def waits(self, waits: bool) -> None:
        self.keeper.waits = waits

    def warm_up(self) -> None:
        """Load the kernels of the tracking; those of the planner are loaded."""
        self.tracking.warm_up()
        self.reset()

    def reset(self) -> None:
        """Return to the first plan."""
        self.tracking.reset()
        self.keeper.reset()

    def memory(self) -> tuple[Any, ...] | None:
        """Return what tracking and keeper keep."""
        tracking = self.tracking.memory()
        return None if tracking is None else (tracking, self.keeper.memory())

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on as the controller did whose `memory` it is."""
        tracking, kept = memory
        self.tracking.recall(tracking)
        self.keeper.recall(kept)

    def command(self, state: State, reference: Reference) -> Command:
        """Return the torque of the control step that starts at ``state``, and how the plan goes."""
        step = self.keeper.look(state, reference.attitude)
        nominal, source, report = self.tracking.command(state, step.reference)
        solution = report.solution
        ahead = None if solution is None or not solution.converged else solution.torques
        self.keeper.seek(state, ahead)
        torque = self._guard.clip(state.momentum, nominal)
        told = SolveReport(solution, report.standstill, step._replace(nominal_torque=nominal))
        return Command(torque, source, told)
