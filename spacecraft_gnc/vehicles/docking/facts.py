"""Facts of a docking scenario, for ``gnc check``, without kernels."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.holding import (
    DOCKED,
    Pose,
    clearance,
    hold_wrench,
    line_of_sight_margin,
)
from spacecraft_gnc.vehicles.docking.parameters.plant import PlantParameters
from spacecraft_gnc.vehicles.docking.scenario import Scenario
from spacecraft_gnc.vehicles.vehicle import Facts, Outlook


def facts(scenario: Scenario, expected: Outlook) -> Facts:
    """Return what a scenario would fly."""
    del expected
    p = scenario.plant
    start = Pose(p.initial_port_offset, p.initial_rotation_vector)
    turn, steps = math.degrees(np.linalg.norm(start.rotation_vector)), rotation_steps(scenario)
    margin, room = line_of_sight_margin(p, start.port_offset), clearance(p, start)
    docked = hold_wrench(p, DOCKED)
    force, moment = np.abs(docked[:, :3]).max(), np.abs(docked[:, 3:]).max()
    moments = " ".join(f"{value:.4g}" for value in np.linalg.eigvalsh(p.inertia))
    return Facts(
        body=f"deputy {p.mass:g} kg, {_edges(p.deputy_size)}, principal moments {moments} kg m^2",
        start=(
            f"port {np.linalg.norm(start.port_offset):.4g} m off, turned by {turn:.4g} deg, "
            f"line-of-sight margin {margin:.4g} m, clearance {room:.4g} m"
        ),
        controller=", ".join(_weights(scenario)),
        rows=(
            ("chief", f"{_edges(p.chief_size)}, {_rotation(p, steps, scenario.period)}"),
            ("thrusters", _thrusters(p)),
            ("docked hold", f"up to {force:.4g} N, {moment:.4g} N m over a rotation"),
            ("navigation noise", _noise(p)),
        ),
        governor=", ".join(_margins(scenario)),
        numbers={
            "initial_distance": float(np.linalg.norm(start.port_offset)),
            "initial_angle_deg": turn,
            "initial_line_of_sight_margin": margin,
            "initial_clearance": room,
            "rotation_steps": steps,
            "max_force_limit": p.max_force,
            "max_moment_limit": p.max_moment,
            "hold_force": float(force),
            "hold_moment": float(moment),
        },
    )


def rotation_steps(scenario: Scenario) -> int:
    """Return the control periods of a rotation of the chief; 1: it does not rotate."""
    rate = scenario.plant.chief_spin_rate
    return round(2.0 * math.pi / (rate * scenario.period)) if rate else 1


def _edges(size: Array) -> str:
    return " x ".join(f"{edge:g}" for edge in size.tolist()) + " m"


def _rotation(p: PlantParameters, steps: int, period: float) -> str:
    if not p.chief_spin_rate:
        return "at rest in Hill's frame"
    axis = p.chief_spin_axis / np.linalg.norm(p.chief_spin_axis)
    tilt = math.degrees(math.acos(min(1.0, abs(axis[2]))))
    about = "about the orbit normal" if tilt < 1e-6 else f"{tilt:.4g} deg off the orbit normal"
    return f"a rotation in {steps * period:g} s ({steps} control periods), {about}"


def _thrusters(p: PlantParameters) -> str:
    limits = f"up to {p.max_force:g} N, {p.max_moment:g} N m by component"
    told = limits if p.saturates else f"limits of {limits[6:]} not applied"
    if not p.thruster_lost:
        return told
    return f"{told}; {p.thruster_lost} lost at {p.thruster_lost_at:g} s"


def _noise(p: PlantParameters) -> str:
    parts = (
        (p.position_noise, "m"),
        (p.velocity_noise, "m/s"),
        (p.attitude_noise, "rad"),
        (p.rate_noise, "rad/s"),
    )
    return ", ".join(f"{value:g} {unit}" for value, unit in parts if value) or "none"


def _weights(scenario: Scenario) -> Iterator[str]:
    """Yield what the laws believe, where that is not the plant, and the weights."""
    c, p, w = scenario.controller, scenario.plant, scenario.controller.weights
    if c.mass != p.mass:
        yield f"believes {c.mass:g} kg"
    if not np.array_equal(c.inertia, p.inertia):
        yield "believes another inertia"
    states = (w.port_offset, w.port_velocity, w.attitude, w.angular_velocity)
    yield f"Q = diag({', '.join(f'{value:g}' for value in states)})"
    yield f"R = diag({w.force:g}, {w.moment:g}), three of each"


def _margins(scenario: Scenario) -> Iterator[str]:
    """Yield what the governor is asked for, in words."""
    g = scenario.governor
    away = float(np.linalg.norm(g.target_port_offset))
    turn = math.degrees(np.linalg.norm(g.target_rotation_vector))
    yield "to the docked state" if not away + turn else f"to {away:.4g} m and {turn:.4g} deg off"
    if g.governor == "none":
        return
    yield f"steady states up to {g.steady_share:g} of the bounds"
    margins = ((g.force_margin, "N"), (g.moment_margin, "N m"), (g.distance_margin, "m"))
    kept = [f"{value:g} {unit}" for value, unit in margins if value]
    if kept:
        yield f"margins {', '.join(kept)}"
    if g.aborts:
        hold: Any = g.hold_port_offset.tolist()
        yield f"aborts to ({', '.join(f'{part:g}' for part in hold)}) m"
