"""Outlook of a scenario for ``gnc check``: when its loop settles, whether it keeps its limit."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from spacecraft_gnc.vehicles.rigid_body.planner.transfer import (
    plan_parameters,
    planning_section,
    plans,
)
from spacecraft_gnc.vehicles.rigid_body.prediction import Prediction, predict
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario
from spacecraft_gnc.vehicles.vehicle import Outlook

LARGEST_EXCESS: Final = 1e-3
"""Share of the torque limit above which a warning is due."""


def outlook(scenario: Scenario, cut_short: bool) -> Outlook:
    """Return what a scenario that can fly is to expect.

    ``cut_short``: its duration is shorter on purpose, and no warning is due.
    """
    if scenario.law.moves:
        return Outlook("not predicted for a reference that moves", _numbers(None, 0.0))
    if plans(scenario):
        return _of_plan(scenario, cut_short)
    prediction = predict(scenario)
    settling = _settling(scenario, prediction)
    if prediction is None:
        return Outlook(settling, _numbers(None, 0.0))
    excess = prediction.most_excess
    if excess > LARGEST_EXCESS:
        excess = _first_excess(scenario)
    warnings = (*_of_settling(scenario, prediction, cut_short), *_of_limit(scenario, excess))
    return Outlook(settling, _numbers(prediction, excess), warnings)


def _of_plan(scenario: Scenario, cut_short: bool) -> Outlook:
    """Return when a plan ends; a longer flight than that is to be expected."""
    end, duration = plan_parameters(scenario).duration, scenario.n_steps * scenario.period
    warnings = []
    if duration < end and not cut_short:
        text = f"received {duration:g} s; required at least {end:g} s, the time of the plan"
        warnings = [f"{scenario.path}: plant.duration: {text}; lengthen it"]
    warnings += _of_reserve(scenario)
    numbers = {**_numbers(None, 0.0), "predicted_settling_time": end}
    settling = f"at rest at the target from {end:g} s, the end of the plan"
    return Outlook(settling, numbers, tuple(warnings))


def _of_reserve(scenario: Scenario) -> list[str]:
    """Return what is missing where the body is not as believed, and a plan leaves nothing to it."""
    plan, plant = plan_parameters(scenario), scenario.plant
    bounds = {"torque": plan.torque_bounds, "momentum": plan.momentum_bounds}
    reserves = {"torque": plan.torque_reserve, "momentum": plan.momentum_reserve}
    missing = [
        f"{name}_reserve" for name, b in bounds.items() if len(b) and not reserves[name] > 0.0
    ]
    is_another = not np.array_equal(plant.inertia, scenario.controller.inertia)
    disturbances = [f"disturbance {name}" for name in plant.disturbances]
    causes = [*disturbances, *(["an inertia other than believed"] if is_another else [])]
    if not (missing and causes):
        return []
    section = planning_section(scenario)
    text = f"received {' and '.join(missing)} 0 beside {', '.join(causes)}"
    need = "required a share of the bounds for the tracking, else it may exceed them"
    return [f"{scenario.path}: {section}.plan: {text}; {need}; add some"]


def _numbers(prediction: Prediction | None, excess: float) -> dict[str, Any]:
    """Return the prediction in numbers; None for what is not predicted, or never."""
    if prediction is None:
        return dict.fromkeys(("spectral_radius", "predicted_settling_time", "limit_excess"))
    time = prediction.settling_time
    return {
        "spectral_radius": prediction.spectral_radius,
        "predicted_settling_time": time if math.isfinite(time) else None,
        "limit_excess": excess,
    }


def _settling(scenario: Scenario, prediction: Prediction | None) -> str:
    """Return the predicted settling time in words."""
    if prediction is None:
        return f"not predicted for method {scenario.controller.method}"
    below = f"{scenario.governor.slew_tolerance_deg:g} deg"
    radius = f"spectral radius {prediction.spectral_radius:.4g} at the target"
    if math.isinf(prediction.settling_time):
        return f"never below {below} for good, {radius}"
    from_then = f"below {below} for good from {prediction.settling_time:.4g} s"
    return f"{from_then}, predicted without zones and governor; {radius}"


def _of_settling(scenario: Scenario, prediction: Prediction, cut_short: bool) -> list[str]:
    duration, settled = scenario.n_steps * scenario.period, prediction.settling_time
    if settled <= duration or (cut_short and not math.isinf(settled)):
        return []
    instead = _instead(scenario)
    if math.isinf(settled):
        text = (
            "nmpc_controller: the loop does not settle at its target: received a spectral radius "
            f"of {prediction.spectral_radius:.6g} a step; required less than 1; use a horizon of 2 "
            f"steps or more{instead}"
        )
    else:
        text = (
            f"plant.duration: received {duration:g} s; required at least {settled:.4g} s, after "
            f"which the error is predicted to stay below {scenario.governor.slew_tolerance_deg:g} "
            f"deg; lengthen it{instead or ', or shorten nmpc_controller.settling_time'}"
        )
    return [f"{scenario.path}: {text}"]


def _instead(scenario: Scenario) -> str:
    """Return what to do about given weights or gains; empty where none is given."""
    given = scenario.sections.get("nmpc_controller", {})
    if not any(name == "weights" or name.endswith("_gain") for name in given):
        return ""
    return ", or leave out weights and gains, which then follow from nmpc_controller.settling_time"


def _of_limit(scenario: Scenario, excess: float) -> list[str]:
    if not excess > LARGEST_EXCESS:
        return []
    c = scenario.controller
    factor = f"{1.0 + excess:.4g} times" if excess > 1.0 else f"{excess:.2%} above"
    return [
        (
            f"{scenario.path}: nmpc_controller.torque_penalty: received {c.torque_penalty:g}, too "
            f"little beside the weights: the first torque is {factor} max_torque {c.max_torque:g} "
            f"N m; required at most {LARGEST_EXCESS:.1%} above; raise it, or leave it out"
        )
    ]


def _first_excess(scenario: Scenario) -> float:
    """Return by which share the controls of the first solve exceed their limit; 0: unknown."""
    from spacecraft_gnc import lie
    from spacecraft_gnc.ocp import ShootingSolver
    from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import options_of, problem_of

    plant = scenario.plant
    solver = ShootingSolver(problem_of(scenario), options=options_of(scenario))
    start = lie.exp(plant.initial_rotation_vector)
    target = lie.exp(scenario.governor.target_rotation_vector)
    solution = solver.solve(start, plant.initial_momentum, target)
    if not solution.converged:
        return 0.0
    controls = solver.ocp.allocation @ solution.torques[0]
    return max(0.0, float(np.linalg.norm(controls)) / scenario.controller.max_torque - 1.0)
