"""Governors of a rigid body from a scenario.

What flies on board knows its belief only: every prediction flies the body that the controller
believes (``nmpc_controller.inertia``), whatever the plant is.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.governors.moving import StoredTrajectory, TurningReference, attitudes_of
from spacecraft_gnc.governors.pass_through import PassThroughGovernor
from spacecraft_gnc.types import State
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario, known_inertia

if TYPE_CHECKING:  # numba takes 64 MB, which a node without a governor law spares
    from spacecraft_gnc.governors.attitude import AttitudeGovernor
    from spacecraft_gnc.governors.planned.governor import PlannedGovernor
    from spacecraft_gnc.governors.prediction import Planner
    from spacecraft_gnc.governors.reference_set import ReferenceSet


def pass_through(scenario: Scenario) -> PassThroughGovernor:
    """Return the governor ``none`` of a scenario."""
    return PassThroughGovernor(lie.exp(scenario.governor.target_rotation_vector))


def attitude_governor(scenario: Scenario) -> AttitudeGovernor:
    """Return the governor ``attitude`` of a scenario.

    Raises
    ------
    GncError
        If a parameter is refused, or the loop violates a constraint from its start even while the
        initial reference is held.
    """
    from spacecraft_gnc.governors.attitude import AttitudeGovernor
    from spacecraft_gnc.vehicles.rigid_body.governors.predictors import predictor_of

    known_inertia(scenario, "nmpc_controller", scenario.controller.inertia)
    g, references = scenario.governor, reference_set_of(scenario)
    given = bool(np.isfinite(g.initial_reference_rotation_vector).all())
    governor = AttitudeGovernor(
        predictor_of(scenario, references),
        references,
        lie.exp(g.target_rotation_vector),
        planner=_planner_of(scenario, references),
        initial_reference=lie.exp(g.initial_reference_rotation_vector) if given else None,
        alpha_tolerance=g.alpha_tolerance,
        cut_point_shift=g.cut_point_shift,
    )
    if "plant" in scenario.sections:
        p = scenario.plant
        start = State(0, lie.exp(p.initial_rotation_vector), np.array(p.initial_momentum))
        governor.require_start(start)
    return governor


def turning_reference(scenario: Scenario) -> TurningReference:
    """Return the governor ``turning_reference`` of a scenario.

    Raises
    ------
    GncError
        If a parameter is refused.
    """
    g, c = scenario.governor, scenario.controller
    inertia = known_inertia(scenario, "nmpc_controller", c.inertia)
    return TurningReference(
        lie.exp(g.target_rotation_vector), g.reference_rate, inertia, scenario.period
    )


def stored_trajectory(scenario: Scenario) -> StoredTrajectory:
    """Return the governor ``stored_trajectory`` of a scenario.

    Raises
    ------
    GncError
        If a parameter is refused.
    """
    table, c = scenario.governor.trajectory, scenario.controller
    return StoredTrajectory(
        table.times,
        attitudes_of(table.rotation_vectors),
        table.angular_velocities,
        known_inertia(scenario, "nmpc_controller", c.inertia),
        scenario.period,
        plant_step=scenario.plant.time_step,
    )


def planned(scenario: Scenario) -> PlannedGovernor:
    """Return the governor ``planned`` of a scenario.

    Raises
    ------
    GncError
        If a parameter is refused, or no plan is found from the start to the target.
    """
    from spacecraft_gnc.governors.planned.governor import PlannedGovernor
    from spacecraft_gnc.vehicles.rigid_body.planner.keeper import guard_of, keeper_of

    return PlannedGovernor(keeper_of(scenario, guard_of(scenario)))


def reference_set_of(scenario: Scenario) -> ReferenceSet:
    """Return the set of a scenario's zones and ``reference_governor.steady_margin_deg``."""
    from spacecraft_gnc.governors.reference_set import ReferenceSet
    from spacecraft_gnc.vehicles.rigid_body.zones import zones_of  # imports the solvers, slow

    names = tuple(zone.name for zone in scenario.controller.zones)
    margin = math.radians(scenario.governor.steady_margin_deg)
    return ReferenceSet(zones_of(scenario), margin, names)


def _planner_of(scenario: Scenario, references: ReferenceSet) -> Planner | None:
    if not scenario.governor.route or not references.zones:
        return None
    from spacecraft_gnc.governors.route import RoutePlanner

    return RoutePlanner(references, math.radians(scenario.governor.route_clearance_deg))
