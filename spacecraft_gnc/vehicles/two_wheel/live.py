"""What the live page draws of a spacecraft with wheels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from spacecraft_gnc import lie
from spacecraft_gnc.types import Array

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.two_wheel.flight import WheelFlight
    from spacecraft_gnc.vehicles.two_wheel.scenario import Scenario
    from spacecraft_gnc.vehicles.two_wheel.state import WheelState


class WheelLive:
    """Implements `vehicles.live.VehicleLive`: the speeds of the wheels over time."""

    def constants(self, scenario: Scenario) -> dict[str, Any]:
        """Return the target (3, 3), and how the wheels are called."""
        m = scenario.plant.wheel_inertias.size
        names = tuple(f"wheel {i + 1}" for i in range(m))
        return {
            "target": lie.exp(scenario.governor.target_rotation_vector),
            "strip": ("Wheel speeds", "rad/s", names),
        }

    def row(self, flight: WheelFlight, step: int) -> dict[str, Array]:
        """Return the wheel speeds (m,) of a recorded step."""
        return {"strip": flight.wheel_speed[step]}

    def step(self, state: WheelState, control: Array | None) -> dict[str, Array]:
        """Return the wheel speeds (m,) of a step that flies."""
        del control
        return {"strip": state.wheel_speed}


LIVE: Final = WheelLive()
