"""Governors of the formation from a scenario."""

from __future__ import annotations

import math

import numpy as np

from spacecraft_gnc.governors.time_shift import (
    TimeShiftGovernor,
    TimeShiftProblem,
    start_violation,
)
from spacecraft_gnc.parameters.problems import InvalidScenario, Problem
from spacecraft_gnc.vehicles.formation.build import gain, initial_states, trajectory, transition
from spacecraft_gnc.vehicles.formation.governors.none import PassThroughGovernor
from spacecraft_gnc.vehicles.formation.governors.time_shift import FormationGovernor
from spacecraft_gnc.vehicles.formation.scenario import Scenario


def pass_through(scenario: Scenario) -> PassThroughGovernor:
    """Return the governor ``none`` of a scenario."""
    return PassThroughGovernor(trajectory(scenario), scenario.governor.formed_error)


def time_shift(scenario: Scenario) -> FormationGovernor:
    """Return the governor ``time_shift`` of a scenario.

    Raises
    ------
    InvalidScenario
        If no shifts are admissible at the start.
    """
    problem = time_shift_problem(scenario)
    _require_admissible(scenario, problem)
    g = scenario.governor
    governor = TimeShiftGovernor(
        problem, formed_within=g.formed_error, resolves_deadlocks=g.resolves_deadlocks
    )
    return FormationGovernor(trajectory(scenario), governor, scenario.plant.spacecraft)


def time_shift_problem(scenario: Scenario) -> TimeShiftProblem:
    """Return the problem of a scenario: its limits less the margins."""
    p, g, w = scenario.plant, scenario.governor, scenario.controller.weights
    angle = p.max_communication_angle_deg - g.communication_angle_margin_deg
    return TimeShiftProblem(
        state_map=transition(scenario),
        gain=gain(scenario),
        natural=trajectory(scenario).states,
        phases=np.array(g.phase),
        max_delta_v=p.max_delta_v - g.delta_v_margin,
        min_separation=p.min_separation + g.separation_margin,
        max_angle=math.radians(angle),
        state_weight=np.diag(np.repeat([w.position, w.velocity], 3)),
        control_weight=w.delta_v * np.eye(3),
        shift_weight=g.shift_weight,
        horizon=g.horizon,
        substeps=g.prediction_substeps,
    )


def _require_admissible(scenario: Scenario, problem: TimeShiftProblem) -> None:
    """Refuse a start without admissible shifts, with what the least violating ones exceed."""
    missed = start_violation(problem, initial_states(scenario))
    if missed is None:
        return
    names = scenario.plant.spacecraft
    by_state = scenario.plant.initial_position.size
    raise InvalidScenario(
        [
            Problem(
                scenario.path,
                None,
                "plant.initial_position" if by_state else "plant.initial_phase",
                f"a start from which none of the {problem.samples**problem.n_craft} combinations "
                "of time shifts keeps every limit",
                f"a start with one that does; the best one misses {missed.text(names)}, by "
                f"{-100.0 * missed.share:.3g} %",
                "start nearer to the formation, or widen that limit",
            )
        ]
    )
