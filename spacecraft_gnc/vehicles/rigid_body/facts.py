"""Facts of a rigid body's scenario, for ``gnc check``."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.governors.laws import STORED, TURNING
from spacecraft_gnc.vehicles.rigid_body.planner.transfer import first_plan, plans, real_limits
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario, reservation
from spacecraft_gnc.vehicles.vehicle import Facts, Outlook


def facts(scenario: Scenario, expected: Outlook) -> Facts:
    """Return what a scenario would fly."""
    plant, controller, governor = scenario.plant, scenario.controller, scenario.governor
    moments = " ".join(f"{value:g}" for value in np.linalg.eigvalsh(plant.inertia))
    momentum = float(np.linalg.norm(plant.initial_momentum))
    error = _initial_error_deg(scenario)
    horizon = controller.horizon if "horizon" in scenario.method.reads else None
    zones = [f"{z.name} ({z.kind}, {z.half_angle_deg:g} deg)" for z in controller.zones]
    limits = (("torque", governor.max_torque, "N m"), ("momentum", governor.max_momentum, "N m s"))
    kept = [f"{what} limit {value:g} {unit}" for what, value, unit in limits if value > 0.0]
    return Facts(
        body=f"principal moments {moments} kg m^2{_belief(scenario)}",
        start=f"{error:.4g} deg from the {_aim(scenario)}, |Pi| {momentum:g} N m s",
        controller="" if horizon is None else f"horizon {horizon} steps",
        rows=(
            *_disturbances(scenario),
            *_limits(scenario),
            *_actuators(scenario),
            ("settling", expected.settling),
            ("zones", ", ".join(zones) or "none"),
        ),
        governor=", ".join(
            text for text in (*_motion(scenario), *kept, reservation(scenario)) if text
        ),
        numbers={
            "initial_error_deg": error,
            "horizon": horizon,
            "max_torque": controller.max_torque,
            "zones": [zone.name for zone in controller.zones],
            "disturbances": list(plant.disturbances),
            **_plan_numbers(scenario),
            **expected.numbers,
        },
    )


def _limits(scenario: Scenario) -> list[tuple[str, str]]:
    """Return the limit on the torque, or the bounds of the plans and what the first one is."""
    if not plans(scenario):
        largest = scenario.controller.max_torque
        return [("torque limit", f"{largest:g} N m" if largest else "none")]
    from spacecraft_gnc.vehicles.rigid_body.planner.rows import bounds_text  # loads the solver

    real, numbers = real_limits(scenario), _plan_numbers(scenario)
    pairs = (("torque", real[:2], "N m"), ("momentum", real[2:], "N m s"))
    kept = [f"{what} {bounds_text([*pair])} {u}" for what, pair, u in pairs if _is_bound(pair)]
    active = ", ".join(numbers["plan_active"]) or "none"
    told = f"{numbers['plan_duration']:g} s, cost {numbers['plan_cost']:.10g} N^2 m^2"
    return [("bounds", ", ".join(kept) or "none"), ("plan", f"{told}; bounds that act: {active}")]


def _actuators(scenario: Scenario) -> list[tuple[str, str]]:
    """Return what the plant's actuators give at most, in a row."""
    most = scenario.plant.max_torque
    told = f"at most {most:g} N m about each axis, cut by the plant"
    return [("actuators", told)] if most else []


def _is_bound(sides: Array) -> bool:
    return bool(np.isfinite(sides).any())


def _plan_numbers(scenario: Scenario) -> dict[str, Any]:
    """Return duration [s], cost and active bounds of the first plan; None where none is flown."""
    if not plans(scenario):
        return dict.fromkeys(("plan_duration", "plan_cost", "plan_active"))
    from spacecraft_gnc.vehicles.rigid_body.planner.plan import AXES

    plan = first_plan(scenario)
    active = dict.fromkeys(f"{one.quantity} {AXES[one.axis]}" for one in plan.active)
    return {
        "plan_duration": plan.problem.duration,
        "plan_cost": plan.cost,
        "plan_active": list(active),
    }


def _belief(scenario: Scenario) -> str:
    """Return the principal moments that the controller believes, where they are others."""
    believed = scenario.controller.inertia
    if np.array_equal(believed, scenario.plant.inertia):
        return ""
    moments = " ".join(f"{value:g}" for value in np.linalg.eigvalsh(believed))
    return f", believed {moments} kg m^2"


def _disturbances(scenario: Scenario) -> list[tuple[str, str]]:
    """Return the parts that act on the body beside the commands, in a row."""
    parts = ", ".join(scenario.plant.disturbances)
    return [("disturbances", f"{parts}, not known to the controller")] if parts else []


def _aim(scenario: Scenario) -> str:
    return "first reference" if scenario.law.moves else "target"


def _motion(scenario: Scenario) -> list[str]:
    """Return how a reference moves."""
    governor, law = scenario.governor, scenario.law
    if law is TURNING:
        rate = math.degrees(float(np.linalg.norm(governor.reference_rate)))
        return [f"{rate:.4g} deg/s"]
    if law is STORED:
        times = governor.trajectory.times
        return [f"{len(times)} rows, {times[-1]:g} s"]
    return []


def _initial_error_deg(scenario: Scenario) -> float:
    """Return the angle between the initial attitude and the target, or first reference [deg]."""
    governor = scenario.governor
    is_stored = scenario.law is STORED
    first = (
        governor.trajectory.rotation_vectors[0] if is_stored else governor.target_rotation_vector
    )
    start, target = _quaternion(scenario.plant.initial_rotation_vector), _quaternion(first)
    return math.degrees(2.0 * math.acos(min(1.0, abs(float(start @ target)))))


def _quaternion(rotation_vector: Array) -> Array:
    """Return the unit quaternion (4,), scalar first, of a rotation vector (3,) [rad]."""
    angle = float(np.linalg.norm(rotation_vector))
    vector = 0.5 * np.sinc(0.5 * angle / math.pi) * rotation_vector
    return np.array([math.cos(0.5 * angle), *vector])
