"""The NMPC with two wheels behind the `Controller` protocol."""

from __future__ import annotations

from spacecraft_gnc.vehicles.two_wheel.build import believed_gyrostat
from spacecraft_gnc.vehicles.two_wheel.controllers.piloted import PilotedController
from spacecraft_gnc.vehicles.two_wheel.controllers.underactuated.pilot import TwoWheelPilot
from spacecraft_gnc.vehicles.two_wheel.scenario import Scenario


class UnderactuatedController(PilotedController[TwoWheelPilot]):
    """``method: underactuated``: `TwoWheelPilot` with the two wheels that there are.

    Parameters
    ----------
    pilot : TwoWheelPilot
    """

    name = "underactuated"
    slow = True

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> UnderactuatedController:
        """Build the controller of a scenario's section ``nmpc_controller``.

        Raises
        ------
        GncError
            If there are not two wheels, or they turn the bus about one axis only.
        """
        return cls(TwoWheelPilot(believed_gyrostat(scenario), scenario.controller))
