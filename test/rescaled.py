"""A scenario in other units of mass, time and cost, and the expected flight."""

from __future__ import annotations

import numpy as np

from spacecraft_gnc.scenario import Scenario, load
from spacecraft_gnc.scenario.checks_reads import unread_by


def factors(scenario: Scenario, mass: float, time: float, cost: float) -> dict[str, float]:
    """Factor of each parameter that has a unit."""
    torque, momentum = mass / time**2, mass / time
    # (28) multiplies the stage cost by h; Kalabic's (24) does not.
    stage = cost if scenario.controller.method == "terminal_set" else cost / time
    own = {
        "nmpc_controller.weights.stage_attitude": stage,
        "nmpc_controller.weights.stage_momentum": stage / momentum**2,
        "nmpc_controller.weights.stage_torque": stage / torque**2,
        "nmpc_controller.weights.stage_rate": stage * time**2,
        "nmpc_controller.weights.terminal_attitude": cost,
        "nmpc_controller.weights.terminal_momentum": cost / momentum**2,
        "nmpc_controller.torque_penalty": stage / torque**4,
        "nmpc_controller.feedback_attitude_gain": torque,
        "nmpc_controller.feedback_momentum_gain": 1.0 / time,
        "nmpc_controller.nominal_momentum": momentum,
        "plant.initial_momentum": momentum,
        "reference_governor.max_momentum": momentum,
        "reference_governor.lyapunov_level": torque,
        "reference_governor.slew_rate_tolerance": 1.0 / time,
        "reference_governor.reference_rate": 1.0 / time,
        "reference_governor.trajectory.times": time,
        "reference_governor.trajectory.angular_velocities": 1.0 / time,
        "plant.duration": time,
        "plant.constant_torque": torque,
        "plant.noise_torque": torque,
        "plant.push_torque": torque,
        "plant.push_time": time,
        "plant.push_duration": time,
        "plant.orbit_rate": 1.0 / time,
    }
    for section in ("plant", "nmpc_controller"):
        own |= {f"{section}.inertia": mass, f"{section}.time_step": time}
    for section in ("nmpc_controller", "reference_governor"):
        own[f"{section}.max_torque"] = torque
    if "settling_time" in scenario.sections.get("nmpc_controller", {}):
        own["nmpc_controller.settling_time"] = time
    for section, plans in (
        ("nmpc_controller", scenario.method.name == "planned"),
        ("reference_governor", scenario.law.name == "planned"),
    ):
        if plans:
            own |= {
                f"{section}.plan.duration": time,
                f"{section}.plan.torque_bounds": torque,
                f"{section}.plan.momentum_bounds": momentum,
            }
    own |= {
        f"nmpc_controller.zones.{zone.name}.penalty": stage for zone in scenario.controller.zones
    }
    return own


def rescaled(
    path: str,
    units: tuple[float, float, float],
    steps: int,
    changes: dict[str, object] | None = None,
) -> Scenario:
    """The first ``steps`` of the scenario in ``path`` in other units, including defaults."""
    plain = load(path, changes or {})
    short = (steps + 0.5) * plain.period
    own = {"plant.duration": min(plain.plant.duration, short)}
    scaled = dict(changes or {}) | own
    own_factors = factors(plain, *units)
    names = [name.partition(".")[2] for name in own_factors if name.startswith("nmpc_controller.")]
    ignored = unread_by(plain.vehicle, plain.controller.method, names)
    unread = {f"nmpc_controller.{name}" for name in ignored}
    for name, factor in own_factors.items():
        section, _, key = name.partition(".")
        if name in unread:
            continue
        value = own.get(name, plain.values[section].get(key))
        if value is None:
            continue
        scaled[name] = (np.array(value) * factor).tolist()
    return load(path, scaled)
