"""Planning of a rigid body's transfers for ``gnc plan``, and the reading of its plans.

Kernels are imported by what solves: ``gnc check`` reads how a plan is told.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.parameters.problems import Problem
from spacecraft_gnc.vehicles.rigid_body.planner.plan import Plan, numbers
from spacecraft_gnc.vehicles.rigid_body.planner.rows import checks, summary_rows
from spacecraft_gnc.vehicles.rigid_body.planner.transfer import (
    plan_parameters,
    too_short,
    transfer_of,
)
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.rigid_body.planner.figures import PlanFigures
    from spacecraft_gnc.vehicles.rigid_body.planner.report import PlanReport


class RigidBodyPlanner:
    """Implements `drawing.vehicle.VehiclePlanner`."""

    numbers = staticmethod(numbers)
    summary = staticmethod(summary_rows)
    checks = staticmethod(checks)

    @property
    def report(self) -> PlanReport:
        """The part of a page that shows plans."""
        from spacecraft_gnc.vehicles.rigid_body.planner.report import PlanReport

        return PlanReport()

    @property
    def figures(self) -> PlanFigures:
        """Figures of plans for print."""
        from spacecraft_gnc.vehicles.rigid_body.planner.figures import PlanFigures

        return PlanFigures()

    def warm_up(self) -> None:
        """Load the kernels; compile them where that was never done."""
        import numpy as np

        from spacecraft_gnc import lie
        from spacecraft_gnc.dynamics import RigidBody
        from spacecraft_gnc.ocp.transfer import AttitudeTransfer, TransferSolver

        body, goal = RigidBody(np.eye(3), 0.4), lie.exp(np.array([0.1, 0.0, 0.0]))
        TransferSolver().solve(
            AttitudeTransfer(body=body, n_steps=4, goal=goal, torque=1.0, momentum=1.0)
        )

    def solve(self, scenario: Scenario, *, shortest: bool = False) -> Plan:
        """Return the plan of a scenario; or the one of the shortest time, where any is found."""
        from spacecraft_gnc.ocp.transfer import TransferSolver, shortest_transfer

        problem, plan = transfer_of(scenario), plan_parameters(scenario)
        solver, is_shortest = TransferSolver(starts=plan.starts), False
        if shortest:
            with suppress(ParameterError):  # none in any time: what was tried in the given one says
                solution, is_shortest = shortest_transfer(problem, solver), True
        if not is_shortest:
            solution = solver.solve(problem)
        return Plan(solution, is_shortest, (plan.torque_reserve, plan.momentum_reserve))

    def refusal(self, scenario: Scenario, plan: Plan) -> Problem | None:
        """Return why there is no plan; None where there is."""
        return None if plan.solution.converged else too_short(scenario, plan.solution)

    def save(self, path: Path, plan: Plan, scenario: str, defaults: str) -> None:
        """Write a plan, with the texts of its scenario and of the defaults that it took."""
        from spacecraft_gnc.vehicles.rigid_body.planner.file import save_plan

        save_plan(path, plan.solution, scenario, defaults)

    def load(self, path: Path) -> tuple[Plan, str, str]:
        """Read a plan, and these texts."""
        from spacecraft_gnc.vehicles.rigid_body.planner.file import load_plan

        found = load_plan(path)
        return Plan(found.solution), found.scenario, found.defaults


PLANNER: Final[Any] = RigidBodyPlanner()
