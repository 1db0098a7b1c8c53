"""Keeper of a scenario's plan, for the method and the governor law that fly one."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors.planned.guard import BoundGuard
from spacecraft_gnc.governors.planned.keeper import PlanKeeper
from spacecraft_gnc.ocp.transfer import (
    AttitudeTransfer,
    TransferSolution,
    TransferSolver,
    shortest_transfer,
)
from spacecraft_gnc.parameters.problems import InvalidScenario, Problem
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario
from spacecraft_gnc.vehicles.rigid_body.transfer import (
    plan_parameters,
    planning_section,
    real_limits,
    transfer_of,
)

_HELD: Final = 0.5
"""Share of the reserve of the momentum that the guard leaves to what is not known."""


def guard_of(scenario: Scenario) -> BoundGuard:
    """Return what keeps the bounds of a scenario, those of the momentum less half of the reserve.

    Raises
    ------
    GncError
        If a parameter is refused.
    """
    limits: Array = np.array(real_limits(scenario))
    limits[2:] *= 1.0 - _HELD * plan_parameters(scenario).momentum_reserve
    return BoundGuard(transfer_of(scenario).body, limits)


def keeper_of(scenario: Scenario, guard: BoundGuard) -> PlanKeeper:
    """Return the keeper of a scenario's plan, with the first plan made.

    Raises
    ------
    GncError
        If a parameter is refused, or no plan is found.
    """
    plan = plan_parameters(scenario)
    return PlanKeeper(
        first_plan(scenario),
        guard,
        scenario.plant.time_step,
        solver=TransferSolver(starts=plan.starts),
        replan_error=math.radians(plan.replan_error_deg),
        lead=plan.replan_lead,
    )


def first_plan(scenario: Scenario) -> TransferSolution:
    """Return the plan from the start of a scenario to its target.

    Raises
    ------
    GncError
        If a parameter is refused, or no plan is found; it then tells the shortest time for which
        one is, where it can be found.
    """
    transfer, solver = transfer_of(scenario), TransferSolver(starts=plan_parameters(scenario).starts)
    found = solver.solve(transfer)
    if found.converged:
        return found
    key = f"{planning_section(scenario)}.plan.duration"
    need = f"a time in which a plan is found: {found.reason}"
    problem = Problem(
        scenario.path, None, key, f"{transfer.duration:g} s", need, _remedy(transfer, solver)
    )
    raise InvalidScenario([problem])


def _remedy(transfer: AttitudeTransfer, solver: TransferSolver) -> str:
    try:
        shortest = shortest_transfer(transfer, solver).problem.duration
    except ParameterError:
        return "widen plan.torque_bounds and plan.momentum_bounds"
    return f"give at least {shortest:g} s, the shortest time for which one is found"
