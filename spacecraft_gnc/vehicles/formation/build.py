"""Cores of the formation from a scenario, and what they share."""

from __future__ import annotations

import math

from spacecraft_gnc.plant.earth import J2
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation import admissible, hill
from spacecraft_gnc.vehicles.formation.dynamics import FormationMotion
from spacecraft_gnc.vehicles.formation.lqr import formation_gain
from spacecraft_gnc.vehicles.formation.orbit import mean_motion, samples_of_orbit
from spacecraft_gnc.vehicles.formation.plant import FormationPlant
from spacecraft_gnc.vehicles.formation.scenario import Scenario
from spacecraft_gnc.vehicles.formation.trajectory import NaturalTrajectory
from spacecraft_gnc.vehicles.formation.two_body import TwoBodyMotion


def plant(scenario: Scenario) -> FormationPlant:
    """Return the plant of a scenario's section ``plant``.

    Raises
    ------
    GncError
        If orbit or start are refused.
    """
    p = scenario.plant
    states = initial_states(scenario)
    return FormationPlant(
        motion(scenario),
        states[:, :3],
        states[:, 3:],
        scenario.n_steps,
        p.max_delta_v,
        saturates=p.saturates,
        lost=[i for i, name in enumerate(p.spacecraft) if name == p.spacecraft_lost],
        lost_at=p.spacecraft_lost_at,
    )


def motion(scenario: Scenario) -> FormationMotion:
    """Return the relative motion that a scenario flies."""
    p, exact = scenario.plant, None
    if p.motion != "hill":
        exact = TwoBodyMotion(
            p.altitude,
            scenario.period,
            math.radians(p.inclination_deg),
            math.radians(p.argument_of_latitude_deg),
            J2 if p.motion == "two_body_j2" else 0.0,
        )
    return FormationMotion(p.altitude, scenario.period, exact)


def initial_states(scenario: Scenario) -> Array:
    """Return the states (n, 6) at the start."""
    return admissible.start(scenario.plant, samples(scenario))


def samples(scenario: Scenario) -> int:
    """Return the control periods p of an orbit."""
    return samples_of_orbit(scenario.plant.altitude, scenario.period)


def trajectory(scenario: Scenario) -> NaturalTrajectory:
    """Return the natural trajectory on which the craft of a scenario form up."""
    p = scenario.plant
    states = hill.natural_states(mean_motion(p.altitude), p.radial_semi_axis, samples(scenario))
    return NaturalTrajectory(states, scenario.governor.phase)


def transition(scenario: Scenario) -> Array:
    """Return A (6, 6) of Hill's equations over one control step."""
    return hill.transition(mean_motion(scenario.plant.altitude), scenario.period)


def gain(scenario: Scenario) -> Array:
    """Return the gain K (3, 6) of every craft's law."""
    w = scenario.controller.weights
    return formation_gain(transition(scenario), w.position, w.velocity, w.delta_v)
