"""LQ feedback of each craft's state error, and the craft's controllers together."""

from __future__ import annotations

from typing import Final

import numpy as np

from spacecraft_gnc.loop.protocols import Command, Source
from spacecraft_gnc.types import Array, read_only
from spacecraft_gnc.vehicles.formation.build import gain
from spacecraft_gnc.vehicles.formation.scenario import Scenario
from spacecraft_gnc.vehicles.formation.state import FormationReference, FormationState

_NAME: Final = "lqr"
_ZERO: Final = read_only(np.zeros(3))


class CraftController:
    """Change of velocity of one craft, linear in the error of its state.

    Parameters
    ----------
    craft : int
        Row of the craft in state and reference.
    gain : (3, 6) array
        K of dv = K (x - x_d), Kolmanovsky (16).
    period : float
        Control period [s].
    """

    name = _NAME
    slow = False

    def __init__(self, craft: int, gain: Array, period: float) -> None:
        self.period = period
        self._craft = craft
        self._gain = gain

    def warm_up(self) -> None:
        """Nothing to load."""

    def reset(self) -> None:
        """Nothing to forget: a command follows from state and reference alone."""

    def memory(self) -> tuple[()]:
        """Return nothing."""
        return ()

    def recall(self, memory: tuple[()]) -> None:
        """Nothing to remember."""

    def command(self, state: FormationState, reference: FormationReference) -> Command:
        """Return the change of velocity (3,) at the start of a control step, Hill's frame [m/s].

        Where it is no finite numbers, the thrusters rest.
        """
        i = self._craft
        with np.errstate(all="ignore"):
            error = np.concatenate(
                [
                    state.position[i] - reference.position[i],
                    state.velocity[i] - reference.velocity[i],
                ]
            )
            delta_v = self._gain @ error
        if not np.isfinite(delta_v).all():
            return Command(_ZERO, Source.ZERO)
        return Command(read_only(delta_v), Source.METHOD)


class FormationController:
    """The controllers of all craft, each of which its own node can host.

    Parameters
    ----------
    craft : tuple of CraftController
        In the order of the vehicle's craft.
    """

    name = _NAME
    slow = False

    def __init__(self, craft: tuple[CraftController, ...]) -> None:
        self.craft = craft
        self.period = craft[0].period

    def warm_up(self) -> None:
        """Nothing to load."""

    def reset(self) -> None:
        """Nothing to forget."""

    def memory(self) -> tuple[()]:
        """Return nothing."""
        return ()

    def recall(self, memory: tuple[()]) -> None:
        """Nothing to remember."""

    def command(self, state: FormationState, reference: FormationReference) -> Command:
        """Return the changes of velocity (n, 3); their source is the worst of the craft's."""
        commands = [one.command(state, reference) for one in self.craft]
        source = Source.ZERO if any(c.is_fallback for c in commands) else Source.METHOD
        return Command(read_only(np.stack([c.control for c in commands])), source)


def lqr(scenario: Scenario) -> FormationController:
    """Return the method ``lqr`` of a scenario."""
    k = gain(scenario)
    count = len(scenario.plant.spacecraft)
    return FormationController(tuple(CraftController(i, k, scenario.period) for i in range(count)))
