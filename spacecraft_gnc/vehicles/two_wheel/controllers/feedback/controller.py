"""The feedback law behind the `Controller` protocol."""

from __future__ import annotations

import numpy as np

from spacecraft_gnc.arguments import require_kind, require_positive
from spacecraft_gnc.loop.protocols import Command, Reference, Source
from spacecraft_gnc.vehicles.two_wheel.build import believed_gyrostat
from spacecraft_gnc.vehicles.two_wheel.controllers.feedback.law import WheelFeedback
from spacecraft_gnc.vehicles.two_wheel.scenario import Scenario
from spacecraft_gnc.vehicles.two_wheel.state import WheelState


class FeedbackController:
    """``method: feedback``: the law of `WheelFeedback`.

    Parameters
    ----------
    feedback : WheelFeedback
    period : float
        Control period [s].

    Notes
    -----
    A state or a reference that is not finite gives no acceleration.
    """

    name = "feedback"
    slow = False

    def __init__(self, feedback: WheelFeedback, period: float) -> None:
        self.feedback = require_kind("feedback", feedback, WheelFeedback)
        self.period = require_positive("period", period)

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> FeedbackController:
        """Build the controller of a scenario's section ``nmpc_controller``.

        Raises
        ------
        GncError
            If the axes of the wheels do not span three dimensions.
        """
        c = scenario.controller
        gyrostat = believed_gyrostat(scenario)
        law = WheelFeedback(gyrostat, c.feedback_bandwidth, c.feedback_damping_ratio)
        return cls(law, scenario.period)

    def warm_up(self) -> None:
        """Load the kernel."""
        gyrostat = self.feedback.gyrostat
        still = np.zeros(gyrostat.n_wheels)
        self.feedback.acceleration(
            gyrostat.state_from_rate(np.eye(3), np.zeros(3), still), np.eye(3)
        )

    def reset(self) -> None:
        """Nothing is remembered."""

    def memory(self) -> tuple[()]:
        """Return nothing: a command follows from state and reference alone."""
        return ()

    def recall(self, memory: tuple[()]) -> None:
        """Nothing is remembered."""

    def command(self, state: WheelState, reference: Reference) -> Command:
        """Wheel accelerations (m,) [rad/s^2] for the control step that starts at ``state``."""
        acceleration = self.feedback.acceleration(state, reference.attitude)
        if np.isfinite(acceleration).all():
            return Command(acceleration)
        return Command(np.zeros(self.feedback.gyrostat.n_wheels), Source.ZERO)
