"""Pointing zones of a scenario."""

from __future__ import annotations

import math

from spacecraft_gnc.ocp.zones import PointingZone
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario


def zones_of(scenario: Scenario) -> tuple[PointingZone, ...]:
    """Return the zones of a scenario's section ``nmpc_controller``."""
    return tuple(
        PointingZone(
            "inclusion" if zone.kind == "inclusion" else "exclusion",
            zone.body_axis,
            zone.inertial_axis,
            math.radians(zone.half_angle_deg),
            zone.penalty,
        )
        for zone in scenario.controller.zones
    )
