"""Keeper of a scenario's plan, for the method and the governor law that fly one."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.governors.planned.guard import BoundGuard
from spacecraft_gnc.governors.planned.keeper import PlanKeeper
from spacecraft_gnc.ocp.transfer import TransferSolution, TransferSolver
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.planner.transfer import (
    first_plan,
    plan_parameters,
    real_limits,
)
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario, known_inertia

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
    inertia = known_inertia(scenario, "nmpc_controller", scenario.controller.inertia)
    return BoundGuard(RigidBody(inertia, scenario.period), limits)


def keeper_of(
    scenario: Scenario, guard: BoundGuard, first: TransferSolution | None = None
) -> PlanKeeper:
    """Return the keeper of a scenario's plan, with the ``first`` plan made where it is not given.

    Raises
    ------
    GncError
        If a parameter is refused, or no plan is found.
    """
    plan = plan_parameters(scenario)
    return PlanKeeper(
        first or first_plan(scenario),
        guard,
        scenario.plant.time_step,
        solver=TransferSolver(starts=plan.starts),
        replan_error=math.radians(plan.replan_error_deg),
        lead=plan.replan_lead,
    )
