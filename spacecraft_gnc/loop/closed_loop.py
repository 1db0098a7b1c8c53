"""Closed loop without ROS: the cores that the nodes host, in one thread."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

from spacecraft_gnc.arguments import require_members
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.loop.flight import End, Flight, Step
from spacecraft_gnc.loop.flight_log import FlightLog
from spacecraft_gnc.loop.protocols import Controller, Governor, Plant, Stretch

_OF_A_CORE: Final = ("warm_up", "reset")
_OF_A_PLANT: Final = ("period", "n_steps", "flight", "state", *_OF_A_CORE, "step")
_MOST_AT_ONCE: Final = 1000  # steps in compiled code, which no signal interrupts
Progress = Callable[[int, int], None]
"""Called with (step, n_steps) after every step."""


class ClosedLoop:
    """Plant, controller and governor, flown step by step.

    Parameters
    ----------
    plant, controller, governor : Plant, Controller, Governor
        Cores; the controller's period must equal the plant's.

    Raises
    ------
    ParameterError
        If the periods differ.
    """

    def __init__(
        self,
        plant: Plant[Any, Any],
        controller: Controller[Any, Any],
        governor: Governor[Any, Any],
    ) -> None:
        for name, core, members in (
            ("plant", plant, _OF_A_PLANT),
            ("controller", controller, ("period", *_OF_A_CORE, "command")),
            ("governor", governor, ("target", *_OF_A_CORE, "decide")),
        ):
            require_members(name, core, members, name.capitalize())
        if not math.isclose(plant.period, controller.period, rel_tol=1e-12):
            raise ParameterError(
                f"controller.period: received {controller.period} s; required the plant's control "
                f"period {plant.period} s; set the plant's substeps accordingly"
            )
        self.plant = plant
        self.controller = controller
        self.governor = governor

    def run(self, progress: Progress | None = None) -> Flight:
        """Fly the whole scenario from its initial state.

        Plants that can (`loop.protocols.Stretch`) fly many steps at once: the flight is the same,
        bit for bit, but for its wall times.

        Parameters
        ----------
        progress : callable, optional
            Called with (step, n_steps) after every step, or after all that are flown at once.

        Returns
        -------
        Flight
            Of the plant's own class.
        """
        for core in (self.plant, self.controller, self.governor):
            core.warm_up()
            core.reset()
        plant, controller, governor = self.plant, self.controller, self.governor
        log = FlightLog(plant.flight, plant.n_steps, plant.period)
        stretch = self._stretch()
        actuators = getattr(plant, "actuators", None)
        state, reference, k = plant.state, None, 0
        step = Step(state, None, None, None)  # one for all, since making it takes time
        while k < plant.n_steps:
            step.state = state
            step.decision = decision = governor.decide(state)
            reference, flown = decision.reference, None
            if stretch is not None:
                flown = stretch.fly(state, reference, min(plant.n_steps - k, _MOST_AT_ONCE))
            if flown is None:
                step.command = command = controller.command(state, reference)
                step.target, control = governor.target, command.control
                step.applied = control if actuators is None else actuators.given(control)
                log.add(k, step)
                state = plant.step(control)
                log.add_outcome(k, plant)
                k += 1
            else:
                step.command, step.target = flown.command, governor.target
                step.applied = flown.command.control
                log.hold(k, step, plant, flown.columns)
                state = plant.state
                k += flown.n_steps
            if progress is not None:
                progress(k, plant.n_steps)
        if reference is None:
            raise ParameterError("plant.n_steps: received 0; required at least 1 control step")
        if getattr(self.governor, "moves", False):
            reference = self.governor.decide(state).reference
        return log.finish(End(state, reference))

    def _stretch(self) -> Stretch | None:
        """Return what flies many steps of this loop at once; None: nothing does."""
        make = getattr(self.plant, "stretch", None)
        return None if make is None else make(self.controller, self.governor, _MOST_AT_ONCE)
