"""What the live page draws of a rigid body all along a flight."""

from __future__ import annotations

from typing import Any, Final

from spacecraft_gnc import lie
from spacecraft_gnc.types import State, Vector3
from spacecraft_gnc.vehicles.rigid_body.flight import RigidBodyFlight
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario


class RigidBodyLive:
    """Implements `vehicles.live.VehicleLive`."""

    def constants(self, scenario: Scenario) -> dict[str, Any]:
        """Return ``torque_limit`` [N m] (0: none), ``target`` (3, 3) and ``zones``.

        ``target`` is None where the reference moves by itself.
        """
        governor, controller = scenario.governor, scenario.controller
        governed = scenario.law.looks_ahead
        return {
            "torque_limit": controller.max_torque or (governor.max_torque if governed else 0.0),
            "target": None if scenario.law.moves else lie.exp(governor.target_rotation_vector),
            "zones": controller.zones,
        }

    def row(self, flight: RigidBodyFlight, step: int) -> dict[str, Vector3]:
        """Return momentum, torque and external torque of a recorded step."""
        names = ("momentum", "torque", "external_torque")
        return {name: getattr(flight, name)[step] for name in names}

    def step(self, state: State, control: Vector3 | None) -> dict[str, Vector3 | None]:
        """Return momentum and torque of a step that flies."""
        return {"momentum": state.momentum, "torque": control}


LIVE: Final = RigidBodyLive()
