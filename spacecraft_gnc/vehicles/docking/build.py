"""Cores of the docking vehicle from a scenario, and what they share."""

from __future__ import annotations

import math

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.ocp.periodic_lqr import periodic_lqr
from spacecraft_gnc.parameters.problems import InvalidScenario, Problem
from spacecraft_gnc.types import Matrix3
from spacecraft_gnc.vehicles.docking.admissible import WHOLE
from spacecraft_gnc.vehicles.docking.chief import ChiefMotion
from spacecraft_gnc.vehicles.docking.dynamics import RelativeMotion
from spacecraft_gnc.vehicles.docking.geometry import Cuboid
from spacecraft_gnc.vehicles.docking.law import FeedbackLaw
from spacecraft_gnc.vehicles.docking.linear import LinearMotion, linearize
from spacecraft_gnc.vehicles.docking.navigation import NavigationNoise
from spacecraft_gnc.vehicles.docking.plant import DockingPlant
from spacecraft_gnc.vehicles.docking.scenario import Scenario
from spacecraft_gnc.vehicles.docking.state import Navigation


def plant(scenario: Scenario) -> DockingPlant:
    """Return the plant of a scenario's section ``plant``.

    Raises
    ------
    GncError
        If bodies, chief or start are refused.
    """
    p = scenario.plant
    return DockingPlant(
        relative_motion(scenario, p.mass, p.inertia),
        initial_motion(scenario),
        scenario.n_steps,
        p.max_force,
        p.max_moment,
        saturates=p.saturates,
        lost=p.thruster_lost,
        lost_at=p.thruster_lost_at,
        noise=navigation_noise(scenario),
        pose_every=p.pose_every,
    )


def relative_motion(scenario: Scenario, mass: float, inertia: Matrix3) -> RelativeMotion:
    """Return the relative motion of a scenario for a deputy of some mass [kg] and inertia (3, 3).

    Raises
    ------
    GncError
        If bodies or chief are refused.
    """
    p = scenario.plant
    if np.isnan(inertia).any():
        problem = Problem(scenario.path, None, "plant.inertia", "nothing", "it", "add it")
        raise InvalidScenario([problem])
    chief = ChiefMotion(
        p.mean_motion,
        p.chief_spin_rate,
        p.chief_spin_axis,
        lie.exp(p.chief_initial_rotation_vector),
    )
    return RelativeMotion(
        mass,
        inertia,
        Cuboid(p.deputy_size, p.deputy_port),
        Cuboid(p.chief_size, p.chief_port),
        chief,
        scenario.period,
        scenario.substeps,
        (math.tan(math.radians(p.line_of_sight_half_angle_deg)), p.line_of_sight_slack),
        two_body=p.two_body,
        gravity_gradient=p.gravity_gradient,
    )


def initial_motion(scenario: Scenario) -> Navigation:
    """Return the motion at the start."""
    p = scenario.plant
    return Navigation(
        p.initial_port_offset,
        p.initial_port_velocity,
        lie.exp(p.initial_rotation_vector),
        p.initial_angular_velocity,
    )


def navigation_noise(scenario: Scenario) -> NavigationNoise | None:
    """Return the noise of navigation; None: there is none."""
    p = scenario.plant
    deviations = (p.position_noise, p.velocity_noise, p.attitude_noise, p.rate_noise)
    if not any(deviations):
        return None
    position, velocity, attitude, rate = deviations
    return NavigationNoise(
        position=position,
        velocity=velocity,
        attitude=attitude,
        rate=rate,
        seed=p.seed,
        run=p.run,
    )


def believed_motion(scenario: Scenario) -> RelativeMotion:
    """Return what flies on board believes of the motion: the deputy is the controller's."""
    c = scenario.controller
    return relative_motion(scenario, c.mass or scenario.plant.mass, c.inertia)


def steps_of_period(scenario: Scenario) -> int:
    """Return the control steps p of a rotation of the chief; 1 where it does not rotate.

    Raises
    ------
    InvalidScenario
        If it is no whole number of them.
    """
    rate = scenario.plant.chief_spin_rate
    if not rate:
        return 1
    steps = 2.0 * math.pi / rate / scenario.period
    if abs(steps - round(steps)) > WHOLE * steps or round(steps) < 1:
        nearest = 2.0 * math.pi / scenario.period / max(1, round(steps))
        problem = Problem(
            scenario.path,
            None,
            "plant.chief_spin_rate",
            f"{rate!r} rad/s, a rotation in {steps:.9g} control periods",
            "a whole number of control periods",
            f"give {nearest!r}",
        )
        raise InvalidScenario([problem])
    return round(steps)


def periodic_model(scenario: Scenario) -> LinearMotion:
    """Return the linear model of the motion as believed, over a rotation of the chief."""
    return linearize(believed_motion(scenario), steps_of_period(scenario))


def periodic_law(scenario: Scenario) -> FeedbackLaw:
    """Return the periodic LQ feedback of a scenario."""
    return _with_gains(periodic_model(scenario), scenario)


def mean_law(scenario: Scenario) -> FeedbackLaw:
    """Return the LQ feedback of the mean model of a period."""
    return _with_gains(periodic_model(scenario).averaged(), scenario)


def _with_gains(model: LinearMotion, scenario: Scenario) -> FeedbackLaw:
    w = scenario.controller.weights
    states = np.repeat([w.port_offset, w.port_velocity, w.attitude, w.angular_velocity], 3)
    controls = np.repeat([w.force, w.moment], 3)
    arrays = (model.transition, model.control, np.diag(states), np.diag(controls))
    return FeedbackLaw(model, periodic_lqr(*arrays).gains)
