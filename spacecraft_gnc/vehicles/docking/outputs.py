"""Messages that controller and governor of the docking vehicle publish at each step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.loop.protocols import Command
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.vehicles.docking.decision import DockingDecision
from spacecraft_gnc.vehicles.docking.signals import (
    ACCEPTED_TARGET,
    COMMAND,
    GOVERNOR_STATUS,
    REFERENCE,
)
from spacecraft_gnc.vehicles.docking.state import RelativeReference, RelativeState

Told = list[tuple[Signal, Any]]
"""Signals with their values, in the order in which they are published."""


class Outputs:
    """What the nodes of one deputy tell.

    Parameters
    ----------
    scenario
        What flies.
    """

    def __init__(self, scenario: Any) -> None:
        del scenario

    def setup(self) -> Told:
        """Return what the controller tells once, when it starts: nothing."""
        return []

    def controller(
        self,
        state: RelativeState,
        reference: RelativeReference,
        command: Command,
        wall: tuple[float, float],
    ) -> Told:
        """Return what the controller tells of a command."""
        del state, reference, wall
        return [(COMMAND, command)]

    def progress(
        self, state: RelativeState, reference: RelativeReference, command: Command
    ) -> dict[str, Any]:
        """Return what a progress display shows of a step: how far it is from being docked."""
        del reference, command
        return {
            "distance": float(np.linalg.norm(state.port_offset)),
            "attitude_error": float(np.linalg.norm(lie.log(state.attitude))),
            "wall_solve_time": math.nan,
        }

    def governor(self, decision: DockingDecision) -> Told:
        """Return what the governor tells of a decision; the reference first."""
        return [(REFERENCE, decision.reference), (GOVERNOR_STATUS, decision)]

    def accepted(self, target: RelativeReference) -> Told:
        """Return what the governor tells of a target that it took in flight."""
        return [(ACCEPTED_TARGET, target)]
