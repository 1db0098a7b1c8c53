"""The NMPC of the bus behind the `Controller` protocol."""

from __future__ import annotations

from spacecraft_gnc.vehicles.two_wheel.build import believed_gyrostat
from spacecraft_gnc.vehicles.two_wheel.controllers.piloted import PilotedController
from spacecraft_gnc.vehicles.two_wheel.controllers.shooting.pilot import ShootingPilot
from spacecraft_gnc.vehicles.two_wheel.scenario import Scenario


class ShootingController(PilotedController[ShootingPilot]):
    """``method: shooting``: `ShootingPilot` with every wheel.

    Parameters
    ----------
    pilot : ShootingPilot
    """

    name = "shooting"
    slow = False

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> ShootingController:
        """Build the controller of a scenario's section ``nmpc_controller``.

        Raises
        ------
        GncError
            If the axes of the wheels do not span three dimensions.
        """
        return cls(pilot_of(scenario))


def pilot_of(scenario: Scenario) -> ShootingPilot:
    """Return the pilot of a scenario's section ``nmpc_controller``, with every wheel."""
    c = scenario.controller
    return ShootingPilot(
        believed_gyrostat(scenario),
        c.feedback_bandwidth,
        c.feedback_damping_ratio,
        c.torque_horizon,
    )
