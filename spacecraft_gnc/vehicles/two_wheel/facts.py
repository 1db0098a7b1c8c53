"""Facts of a scenario of a spacecraft with wheels, for ``gnc check``, without kernels."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Final

import numpy as np

from spacecraft_gnc.parameters.parameter import names_of
from spacecraft_gnc.types import Matrix3
from spacecraft_gnc.vehicles.two_wheel.parameters.plant import PlantParameters
from spacecraft_gnc.vehicles.two_wheel.scenario import Scenario
from spacecraft_gnc.vehicles.two_wheel.start import attitude_at, rotation
from spacecraft_gnc.vehicles.vehicle import Facts, Outlook


def facts(scenario: Scenario, expected: Outlook) -> Facts:
    """Return what a scenario would fly."""
    del expected
    p, m = scenario.plant, scenario.plant.wheel_inertias.size
    moments = " ".join(f"{value:g}" for value in np.linalg.eigvalsh(p.inertia))
    error = math.degrees(
        _angle(
            attitude_at(p.initial_euler_321, p.initial_rotation_vector),
            rotation(scenario.governor.target_rotation_vector),
        )
    )
    given = np.isfinite(p.initial_total_momentum).all()
    motion = (
        f"total momentum {np.linalg.norm(p.initial_total_momentum):g} N m s"
        if given
        else f"bus at {np.linalg.norm(p.initial_angular_velocity):g} rad/s"
    )
    speed = float(np.abs(p.initial_wheel_speed).max(initial=0.0))
    limits = (
        ("speed", p.max_wheel_speed, "rad/s"),
        ("acceleration", p.max_wheel_acceleration, "rad/s^2"),
    )
    kept = [f"{what} {value:g} {unit}" for what, value, unit in limits if value]
    lost = [f"{i} at {t:g} s" for i, t in enumerate(p.wheel_lost_at.tolist(), 1) if t >= 0.0]
    return Facts(
        body=f"principal moments {moments} kg m^2, {m} wheels",
        start=f"{error:.4g} deg from the target, {motion}, wheels up to {speed:g} rad/s",
        controller=", ".join(_controller(scenario)),
        rows=(
            ("wheel limits", ", ".join(kept) or "none"),
            ("wheel friction", _friction(p)),
            ("wheels lost", f"{', '.join(lost)}: {_LOSS[p.wheel_loss](p)}" if lost else "none"),
        ),
        numbers={
            "initial_error_deg": error,
            "wheels": m,
            "max_wheel_speed": p.max_wheel_speed,
            "max_wheel_acceleration": p.max_wheel_acceleration,
        },
    )


def _controller(scenario: Scenario) -> Iterator[str]:
    """Yield what the method reads of its section, in words."""
    c = scenario.controller
    names = names_of(scenario.method.parameters) if scenario.method.parameters else frozenset()
    if "prediction_model" in names:
        yield f"two wheels: N = {c.horizon}, model {c.prediction_model}, solver {c.solver}"
        yield f"end {c.terminal}"
    if "torque_horizon" in names:
        yield f"bus: N = {c.torque_horizon}"
    if "feedback_bandwidth" in names:
        yield f"bandwidth {c.feedback_bandwidth:g} rad/s"
        yield f"damping ratio {c.feedback_damping_ratio:g}"


def _friction(p: PlantParameters) -> str:
    parts = (
        ("viscous", p.wheel_viscous_friction, "N m s"),
        ("Coulomb", p.wheel_coulomb_friction, "N m"),
    )
    kept = [f"{what} up to {value.max():g} {unit}" for what, value, unit in parts if value.any()]
    return ", ".join(kept) or "none"


_LOSS: Final[Mapping[str, Callable[[PlantParameters], str]]] = {
    "friction": lambda p: f"braked by {p.lost_wheel_friction:g} N m",
    "spinning": lambda _: "spinning on",
    "partial": lambda p: f"answering {p.lost_wheel_share:g} of each command",
}


def _angle(one: Matrix3, other: Matrix3) -> float:
    """Return the angle between two attitudes [rad], by the length of the chord."""
    chord = float(np.linalg.norm(one - other)) / math.sqrt(8.0)
    return 2.0 * math.asin(min(1.0, chord))
