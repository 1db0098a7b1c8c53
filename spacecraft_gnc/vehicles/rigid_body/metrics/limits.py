"""Limits that a flight exceeded, and by what factor."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from spacecraft_gnc.audit.limits import Exceedance, beyond
from spacecraft_gnc.drawing.zones import pointing_margin_deg
from spacecraft_gnc.types import Array, as_actuators
from spacecraft_gnc.vehicles.rigid_body.planner.transfer import plans, real_limits

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario


def limits_exceeded(
    scenario: Scenario, attitudes: Array, momenta: Array, torques: Array
) -> tuple[Exceedance, ...]:
    """Return the limits that a flight exceeded by more than 0.1 %.

    Those of the controller on the norm of its controls, of a governor on torque and momentum, of a
    plan on their components, and of the pointing zones.

    Parameters
    ----------
    scenario : Scenario
        What flew.
    attitudes, momenta : (n, 3, 3), (n, 3) arrays
        States, body to inertial and body frame [N m s]; rows that are not known are NaN.
    torques : (m, 3) array
        Body torques [N m].
    """
    return beyond(_exceedances(scenario, attitudes, momenta, torques))


def _exceedances(
    scenario: Scenario, attitudes: Array, momenta: Array, torques: Array
) -> Iterator[Exceedance]:
    controller, governor = scenario.controller, scenario.governor
    controls = torques
    if controller.actuators.size:
        controls = torques @ np.linalg.pinv(as_actuators(controller.actuators)).T
    is_governed = governor.governor != "none"
    for name, vectors, bound, unit in (
        ("torque", controls, controller.max_torque, "N m"),
        ("governed torque", torques, governor.max_torque if is_governed else 0.0, "N m"),
        ("momentum", momenta, governor.max_momentum if is_governed else 0.0, "N m s"),
    ):
        value = _largest(np.linalg.norm(vectors, axis=1))
        if bound > 0.0:
            yield Exceedance(name, value / bound, value, bound, unit)
    if plans(scenario):
        yield from _of_plan(scenario, torques, momenta)
    for zone in controller.zones:
        depth = _largest(-pointing_margin_deg(attitudes, zone))
        half_angle = zone.half_angle_deg
        yield Exceedance(f"zone {zone.name}", 1.0 + depth / half_angle, depth, half_angle, "deg")


def _of_plan(scenario: Scenario, torques: Array, momenta: Array) -> Iterator[Exceedance]:
    """Return what became of the bounds of a plan, on components: ``torque x``, ``torque -x``..."""
    bounds = real_limits(scenario)
    for name, vectors, pair, unit in (
        ("torque", torques, bounds[:2], "N m"),
        ("momentum", momenta, bounds[2:], "N m s"),
    ):
        for (side, sign), axis in product((("-", -1.0), ("", 1.0)), range(3)):
            bound = sign * float(pair[int(sign > 0.0), axis])
            if math.isfinite(bound):
                value = _largest(sign * vectors[:, axis])
                yield Exceedance(f"{name} {side}{'xyz'[axis]}", value / bound, value, bound, unit)


def _largest(values: Array) -> float:
    """Return the largest value that is known; 0 where none is."""
    known = values[np.isfinite(values)]
    return float(known.max()) if known.size else 0.0
