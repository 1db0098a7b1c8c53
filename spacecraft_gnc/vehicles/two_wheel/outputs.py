"""Messages that controller and governor of a spacecraft with wheels publish at each step."""

from __future__ import annotations

from typing import Any

from spacecraft_gnc import lie
from spacecraft_gnc.loop.protocols import Command, GovernorDecision, Reference
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.signals.attitude import (
    ACCEPTED_TARGET,
    ATTITUDE_ERROR,
    GOVERNOR_STATUS,
    REFERENCE,
    at_rest,
    error_of,
)
from spacecraft_gnc.types import Matrix3
from spacecraft_gnc.vehicles.two_wheel.signals import COMMAND
from spacecraft_gnc.vehicles.two_wheel.state import WheelState

Told = list[tuple[Signal, Any]]
"""Signals with their values, in the order in which they are published."""


class Outputs:
    """What the nodes of one spacecraft tell.

    Parameters
    ----------
    scenario
        What flies.
    """

    def __init__(self, scenario: Any) -> None:
        del scenario  # nothing that is told depends on it

    def setup(self) -> Told:
        """Return what the controller tells once, when it starts: nothing."""
        return []

    def controller(
        self, state: WheelState, reference: Reference, command: Command, wall: tuple[float, float]
    ) -> Told:
        """Return what the controller tells of a command, which comes first."""
        del wall  # no solve, no deadline that would be missed
        return [(COMMAND, command), (ATTITUDE_ERROR, error_of(state.attitude, reference))]

    def progress(self, state: WheelState, reference: Reference, command: Command) -> dict[str, Any]:
        """Return what a progress display shows of a step."""
        del command
        return {"attitude_error": lie.angle_between(state.attitude, reference.attitude)}

    def governor(self, decision: GovernorDecision) -> Told:
        """Return what the governor tells of a decision; the reference first."""
        return [(REFERENCE, decision.reference), (GOVERNOR_STATUS, decision)]

    def accepted(self, target: Matrix3) -> Told:
        """Return what the governor tells of a target (3, 3) that it took in flight."""
        return [(ACCEPTED_TARGET, at_rest(target))]
