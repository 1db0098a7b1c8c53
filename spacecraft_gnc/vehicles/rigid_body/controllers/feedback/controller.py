"""Nominal feedback controller behind the `Controller` protocol."""

from __future__ import annotations

import math

import numpy as np

from spacecraft_gnc.arguments import require_kind, require_positive
from spacecraft_gnc.governors.feedback import AttitudeFeedback
from spacecraft_gnc.loop.protocols import Command, Reference, Source, State
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario, known_inertia


class FeedbackController:
    """``method: feedback``: the law of `AttitudeFeedback`, Kalabic et al. 2014, (8)-(10).

    Parameters
    ----------
    feedback : AttitudeFeedback
    period : float
        Control period [s].

    Notes
    -----
    A state or a reference that is not finite gives zero torque.
    """

    name = "feedback"
    slow = False

    def __init__(self, feedback: AttitudeFeedback, period: float) -> None:
        self.feedback = require_kind("feedback", feedback, AttitudeFeedback)
        self.period = require_positive("period", period)

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> FeedbackController:
        """Build the controller of a scenario's section ``nmpc_controller``."""
        c = scenario.controller
        inertia = known_inertia(scenario, "nmpc_controller", c.inertia)
        gains = c.feedback_attitude_gain, c.feedback_momentum_gain
        step = scenario.plant.time_step
        return cls(AttitudeFeedback(*gains, inertia, c.max_torque, step), scenario.period)

    def warm_up(self) -> None:
        """Load the kernel."""
        self.feedback.torque(State(0, np.eye(3), np.zeros(3)), np.eye(3))

    def reset(self) -> None:
        """Nothing is remembered."""

    def memory(self) -> tuple[()]:
        """Return nothing: a command follows from state and reference alone."""
        return ()

    def recall(self, memory: tuple[()]) -> None:
        """Nothing is remembered."""

    def command(self, state: State, reference: Reference) -> Command:
        """Torque for the control step that starts at ``state``."""
        torque = self.feedback.torque(state, reference)
        if math.isfinite(float(torque @ torque)):
            return Command(torque)
        return Command(np.zeros(3), Source.ZERO)
