"""What tracks the motion of a plan."""

from __future__ import annotations

import math

from spacecraft_gnc.ocp import ShootingSolver
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import (
    ShootingController,
    continuation_of,
    monitor_of,
    options_of,
    problem_of,
)
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario


def tracking_of(scenario: Scenario) -> ShootingController:
    """Return the NMPC that tracks a plan, from a scenario's section ``nmpc_controller``.

    Raises
    ------
    GncError
        If a parameter is refused.
    """
    ocp = problem_of(scenario)
    solver = ShootingSolver(ocp, scenario.controller.variant, options_of(scenario))
    way = continuation_of(scenario, ocp)
    if way is not None:
        way.patience = math.inf  # on a plan, many Newton steps are rounding, not a long way
    return ShootingController(solver, monitor_of(scenario, ocp), way)
