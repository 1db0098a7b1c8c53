"""The NMPC of the bus behind the `Controller` protocol."""

from __future__ import annotations

from spacecraft_gnc.loop.protocols import Command, Reference
from spacecraft_gnc.vehicles.two_wheel.build import believed_gyrostat
from spacecraft_gnc.vehicles.two_wheel.controllers.shooting.pilot import ShootingPilot
from spacecraft_gnc.vehicles.two_wheel.scenario import Scenario
from spacecraft_gnc.vehicles.two_wheel.state import WheelState


class ShootingController:
    """``method: shooting``: `ShootingPilot` with every wheel.

    Parameters
    ----------
    pilot : ShootingPilot
    """

    name = "shooting"
    slow = False

    def __init__(self, pilot: ShootingPilot) -> None:
        self.pilot = pilot
        self.period = pilot.gyrostat.time_step

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> ShootingController:
        """Build the controller of a scenario's section ``nmpc_controller``.

        Raises
        ------
        GncError
            If the axes of the wheels do not span three dimensions.
        """
        return cls(pilot_of(scenario))

    def warm_up(self) -> None:
        """Load the kernels."""
        self.pilot.warm_up()

    def reset(self) -> None:
        """Forget the warm start."""
        self.pilot.reset()

    def command(self, state: WheelState, reference: Reference) -> Command:
        """Wheel accelerations (m,) [rad/s^2] for the control step that starts at ``state``."""
        return self.pilot.command(state, reference.attitude)


def pilot_of(scenario: Scenario) -> ShootingPilot:
    """Return the pilot of a scenario's section ``nmpc_controller``, with every wheel."""
    c = scenario.controller
    return ShootingPilot(
        believed_gyrostat(scenario),
        c.feedback_bandwidth,
        c.feedback_damping_ratio,
        c.torque_horizon,
    )
