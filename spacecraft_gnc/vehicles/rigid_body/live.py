"""What the live page draws of a rigid body all along a flight."""

from __future__ import annotations

from typing import Any

from spacecraft_gnc import lie
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario


def constants(scenario: Scenario) -> dict[str, Any]:
    """Return ``torque_limit`` [N m] (0: none), ``target`` (3, 3) and ``zones`` of a scenario."""
    governor, controller = scenario.governor, scenario.controller
    governed = governor.governor != "none"
    return {
        "torque_limit": controller.max_torque or (governor.max_torque if governed else 0.0),
        "target": lie.exp(governor.target_rotation_vector),
        "zones": controller.zones,
    }
