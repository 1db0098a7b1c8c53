"""Periodic LQ feedback of the relative state, and the same from the mean model of a period."""

from __future__ import annotations

from typing import Final

import numpy as np

from spacecraft_gnc.loop.protocols import Command, Source
from spacecraft_gnc.types import read_only
from spacecraft_gnc.vehicles.docking.build import mean_law, periodic_law
from spacecraft_gnc.vehicles.docking.law import FeedbackLaw
from spacecraft_gnc.vehicles.docking.linear import coordinates
from spacecraft_gnc.vehicles.docking.scenario import Scenario
from spacecraft_gnc.vehicles.docking.state import RelativeReference, RelativeState

_ZERO: Final = read_only(np.zeros(6))


class LqrController:
    """Wrench of a linear law from the measured state.

    Parameters
    ----------
    name : str
        Method, as in the scenario.
    law : FeedbackLaw
    period : float
        Control period [s].
    """

    slow = False

    def __init__(self, name: str, law: FeedbackLaw, period: float) -> None:
        self.name = name
        self.law = law
        self.period = period

    def warm_up(self) -> None:
        """Nothing to load."""

    def reset(self) -> None:
        """Nothing to forget: a command follows from state and reference alone."""

    def memory(self) -> tuple[()]:
        """Return nothing."""
        return ()

    def recall(self, memory: tuple[()]) -> None:
        """Nothing to remember."""

    def command(self, state: RelativeState, reference: RelativeReference) -> Command:
        """Return force and moment (6,) for the control step that starts at ``state``.

        Where they are no finite numbers, the thrusters rest.
        """
        with np.errstate(all="ignore"):
            x = coordinates(*state.measured)
            wrench = self.law.wrench(state.step, x, reference.vector)
        if not np.isfinite(wrench).all():
            return Command(_ZERO, Source.ZERO)
        return Command(read_only(wrench), Source.METHOD)


def periodic(scenario: Scenario) -> LqrController:
    """Return the method ``periodic_lqr`` of a scenario."""
    return LqrController("periodic_lqr", periodic_law(scenario), scenario.period)


def time_invariant(scenario: Scenario) -> LqrController:
    """Return the method ``time_invariant_lqr`` of a scenario."""
    return LqrController("time_invariant_lqr", mean_law(scenario), scenario.period)
