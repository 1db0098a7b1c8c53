"""Cores of a spacecraft with wheels from a scenario."""

from __future__ import annotations

import math

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.governors.pass_through import PassThroughGovernor
from spacecraft_gnc.parameters.problems import InvalidScenario, Problem
from spacecraft_gnc.types import Array, Matrix3
from spacecraft_gnc.vehicles.two_wheel.dynamics import Gyrostat
from spacecraft_gnc.vehicles.two_wheel.euler import from_euler_321
from spacecraft_gnc.vehicles.two_wheel.parameters.plant import PlantParameters
from spacecraft_gnc.vehicles.two_wheel.plant import GyrostatPlant
from spacecraft_gnc.vehicles.two_wheel.scenario import Scenario
from spacecraft_gnc.vehicles.two_wheel.state import WheelState


def plant(scenario: Scenario) -> GyrostatPlant:
    """Return the plant of a scenario's section ``plant``.

    Raises
    ------
    GncError
        If the wheels do not fit each other, or the start does not fit them.
    """
    p = scenario.plant
    _require_known(scenario, "plant", p.inertia, p.wheel_axes)
    gyrostat = Gyrostat(
        p.inertia,
        p.wheel_axes,
        p.wheel_inertias,
        p.time_step,
        p.max_wheel_speed,
        p.max_wheel_acceleration,
        p.wheel_viscous_friction,
        p.wheel_coulomb_friction,
    )
    return GyrostatPlant(
        gyrostat,
        _start(gyrostat, p),
        scenario.n_steps,
        scenario.substeps,
        _lost_at(p),
        lost_share=p.lost_wheel_share if p.wheel_loss == "partial" else 0.0,
        lost_friction=p.lost_wheel_friction if p.wheel_loss == "friction" else 0.0,
        pose_every=p.pose_every,
    )


def believed_gyrostat(scenario: Scenario) -> Gyrostat:
    """Return what flies on board believes of the spacecraft: section ``nmpc_controller``."""
    c = scenario.controller
    _require_known(scenario, "nmpc_controller", c.inertia, c.wheel_axes)
    return Gyrostat(
        c.inertia,
        c.wheel_axes,
        c.wheel_inertias,
        scenario.period,
        c.max_wheel_speed,
        c.max_wheel_acceleration,
    )


def pass_through(scenario: Scenario) -> PassThroughGovernor:
    """Return the governor ``none`` of a scenario."""
    return PassThroughGovernor(lie.exp(scenario.governor.target_rotation_vector))


def initial_attitude(plant: PlantParameters) -> Matrix3:
    """Return the attitude (3, 3) at the start, body to inertial."""
    if np.isfinite(plant.initial_euler_321).all():
        return from_euler_321(plant.initial_euler_321)
    return lie.exp(plant.initial_rotation_vector)


def _start(gyrostat: Gyrostat, plant: PlantParameters) -> WheelState:
    """Return the state at the start, from the total momentum where that is given."""
    given = plant.initial_wheel_speed
    speed = given if given.size else np.zeros(gyrostat.n_wheels)
    attitude, total = initial_attitude(plant), plant.initial_total_momentum
    if np.isfinite(total).all():
        return gyrostat.state_from_momentum(attitude, total, speed)
    return gyrostat.state_from_rate(attitude, plant.initial_angular_velocity, speed)


def _lost_at(plant: PlantParameters) -> Array | None:
    times = plant.wheel_lost_at
    return np.where(times < 0.0, math.inf, times) if times.size else None


def _require_known(scenario: Scenario, section: str, inertia: Matrix3, axes: Array) -> None:
    """Raise InvalidScenario where a node alone is not told of the bus or the wheels."""
    for name, missing in (("inertia", np.isnan(inertia).any()), ("wheel_axes", not axes.size)):
        if missing:
            problem = Problem(scenario.path, None, f"{section}.{name}", "nothing", "it", "add it")
            raise InvalidScenario([problem])
