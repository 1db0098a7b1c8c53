"""Messages that controllers and governor of a formation publish at each step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from spacecraft_gnc.loop.protocols import Command
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.vehicles.formation.decision import FormationDecision
from spacecraft_gnc.vehicles.formation.signals import COMMAND, GOVERNOR_STATUS, REFERENCE
from spacecraft_gnc.vehicles.formation.state import FormationReference, FormationState

Told = list[tuple[Signal, Any]]
"""Signals with their values, in the order in which they are published."""


class Outputs:
    """What the nodes of a formation tell.

    Parameters
    ----------
    scenario
        What flies.
    """

    def __init__(self, scenario: Any) -> None:
        del scenario

    def setup(self) -> Told:
        """Return what a controller tells once, when it starts: nothing."""
        return []

    def controller(
        self,
        state: FormationState,
        reference: FormationReference,
        command: Command,
        wall: tuple[float, float],
    ) -> Told:
        """Return what the controller of one craft tells of a command."""
        del state, reference, wall
        return [(COMMAND, command)]

    def progress(
        self, state: FormationState, reference: FormationReference, command: Command
    ) -> dict[str, Any]:
        """Return what a progress display shows of a step: how far the craft are from formed."""
        del command
        errors = np.linalg.norm(state.position - reference.position, axis=1)
        return {"distance": float(errors.max()), "wall_solve_time": math.nan}

    def governor(self, decision: FormationDecision) -> Told:
        """Return what the governor tells of a decision; the reference first."""
        return [(REFERENCE, decision.reference), (GOVERNOR_STATUS, decision)]
