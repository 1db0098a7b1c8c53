"""Closed loop without ROS: the cores that the nodes host, in one thread."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

from spacecraft_gnc.arguments import require_members
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.loop.flight import End, Flight, Step
from spacecraft_gnc.loop.flight_log import FlightLog
from spacecraft_gnc.loop.protocols import Controller, Governor, Plant

_OF_A_CORE: Final = ("warm_up", "reset")
_OF_A_PLANT: Final = ("period", "n_steps", "flight", "state", *_OF_A_CORE, "step")
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

        Parameters
        ----------
        progress : callable, optional
            Called with (step, n_steps) after every step.

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
        state, reference = plant.state, None
        step = Step(state, None, None, None)  # one for all, since making it takes time
        for k in range(plant.n_steps):
            step.state = state
            step.decision = decision = governor.decide(state)
            reference = decision.reference
            step.command = command = controller.command(state, reference)
            step.target = governor.target
            log.add(k, step)
            state = plant.step(command.control)
            log.add_outcome(k, plant)
            if progress is not None:
                progress(k + 1, self.plant.n_steps)
        if reference is None:
            raise ParameterError("plant.n_steps: received 0; required at least 1 control step")
        if getattr(self.governor, "moves", False):
            reference = self.governor.decide(state).reference
        return log.finish(End(state, reference))
