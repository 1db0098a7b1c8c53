"""``method: terminal_set``: the NMPC with a terminal set of Kalabic et al. 2014, section IV."""

from __future__ import annotations

import math

from spacecraft_gnc import lie
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.ocp import ShootingOptions, Status, TerminalSetOcp, TerminalSetSolver
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import SolverController
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario, known_inertia
from spacecraft_gnc.vehicles.rigid_body.zones import zones_of


class TerminalSetController(SolverController):
    """One solve a step, and the failure ladder behind it.

    No standstill is looked for: half a turn away, the logarithm takes a side, and the solve
    with it. Where the terminal set is out of reach, the status is INFEASIBLE, and the ladder flies.
    So it does where the reference moves, which the solver refuses: the set is invariant around rest
    only. The feedback law at the ladder's foot tracks it, without constraints but the torque limit.
    """

    name = "terminal_set"

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> TerminalSetController:
        """Build the controller of a scenario's section ``nmpc_controller``.

        Raises
        ------
        ParameterError
            If the terminal set is out of reach from the scenario's own start, which it can tell
            where no governor stands between the target and the controller.
        """
        c, ocp = scenario.controller, cls.problem(scenario)
        solver = TerminalSetSolver(ocp, ShootingOptions(c.residual_tolerance, c.max_iterations))
        if "plant" in scenario.sections and scenario.governor.governor == "none":
            _require_feasible(scenario, solver)
        return cls(solver)

    @staticmethod
    def problem(scenario: Scenario) -> TerminalSetOcp:
        """Return the optimal control problem of a scenario's section ``nmpc_controller``."""
        c = scenario.controller
        return TerminalSetOcp(
            inertia=known_inertia(scenario, "nmpc_controller", c.inertia),
            time_step=c.time_step,
            horizon=c.horizon,
            stage_attitude=c.weights.stage_attitude,
            stage_rate=c.weights.stage_rate,
            stage_torque=c.weights.stage_torque,
            stage_cost_scale=c.stage_cost_scale,
            max_torque=c.max_torque,
            terminal_set=c.terminal_set,
            zones=zones_of(scenario),
        )


def _require_feasible(scenario: Scenario, solver: TerminalSetSolver) -> None:
    plant, level = scenario.plant, solver.ocp.level
    start = (lie.exp(plant.initial_rotation_vector), plant.initial_momentum)
    target = lie.exp(scenario.governor.target_rotation_vector)
    if level is None:
        return
    found = solver.solve(*start, target)
    if found.status is not Status.INFEASIBLE:
        return
    n, angle = solver.ocp.horizon, math.degrees(found.attitude_error)
    enough = solver.sufficient_horizon(*start, target)
    remedies = [f"horizon: {enough}"] if enough else ["a larger max_torque"]
    if solver.ocp.terminal_set == "true":
        remedies.append("terminal_set: without_kappa")
    remedies.append("terminal_set: false")
    least = solver.least_level(*start, target).terminal_level
    raise ParameterError(
        f"nmpc_controller.terminal_set: received {solver.ocp.terminal_set} with horizon: {n}, "
        f"infeasible from the start, {angle:.5g} deg off the target; required |(Z_N, Pi_N)|_P^2 <= "
        f"{level.value:.4g} (by {level.bound_by}), of which {n} steps reach "
        f"{least:.4g} at the least; use {', or '.join(remedies)}"
    )
