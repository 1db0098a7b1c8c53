"""The NMPC with two wheels behind the `Controller` protocol."""

from __future__ import annotations

from spacecraft_gnc.loop.protocols import Command, Reference
from spacecraft_gnc.vehicles.two_wheel.build import believed_gyrostat
from spacecraft_gnc.vehicles.two_wheel.controllers.underactuated.pilot import TwoWheelPilot
from spacecraft_gnc.vehicles.two_wheel.scenario import Scenario
from spacecraft_gnc.vehicles.two_wheel.state import WheelState


class UnderactuatedController:
    """``method: underactuated``: `TwoWheelPilot` with the two wheels that there are.

    Parameters
    ----------
    pilot : TwoWheelPilot
    """

    name = "underactuated"
    slow = True

    def __init__(self, pilot: TwoWheelPilot) -> None:
        self.pilot = pilot
        self.period = pilot.gyrostat.time_step

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> UnderactuatedController:
        """Build the controller of a scenario's section ``nmpc_controller``.

        Raises
        ------
        GncError
            If there are not two wheels, or they turn the bus about one axis only.
        """
        return cls(TwoWheelPilot(believed_gyrostat(scenario), scenario.controller))

    def warm_up(self) -> None:
        """Compile or load the kernels."""
        self.pilot.warm_up()

    def reset(self) -> None:
        """Forget the last plan."""
        self.pilot.reset()

    def command(self, state: WheelState, reference: Reference) -> Command:
        """Wheel accelerations (2,) [rad/s^2] for the control step that starts at ``state``."""
        return self.pilot.command(state, reference.attitude)
