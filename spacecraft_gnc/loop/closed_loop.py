"""The closed loop without ROS: the same cores as the nodes host, in one thread."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

import numpy as np

from spacecraft_gnc.arguments import require_members
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.loop.protocols import (
    Command,
    Controller,
    Governor,
    GovernorDecision,
    Plant,
    Reference,
    State,
)
from spacecraft_gnc.loop.trajectory import Trajectory
from spacecraft_gnc.types import Matrix3

_OF_A_CORE: Final = ("warm_up", "reset")
_OF_A_PLANT: Final = ("period", "n_steps", "state", *_OF_A_CORE, "step")
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

    def __init__(self, plant: Plant, controller: Controller, governor: Governor) -> None:
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

    def run(self, progress: Progress | None = None) -> Trajectory:
        """Fly the whole scenario from its initial state.

        Parameters
        ----------
        progress : callable, optional
            Called with (step, n_steps) after every step.

        Returns
        -------
        Trajectory
        """
        for core in (self.plant, self.controller, self.governor):
            core.warm_up()
            core.reset()
        log = FlightLog(self.plant.n_steps, self.plant.period)
        state = self.plant.state
        reference = None
        for k in range(self.plant.n_steps):
            decision = self.governor.decide(state)
            reference = decision.reference
            command = self.controller.command(state, reference)
            log.add(k, state, self.governor.target, decision, command)
            state = self.plant.step(command.torque)
            if progress is not None:
                progress(k + 1, self.plant.n_steps)
        if reference is None:
            raise ParameterError("plant.n_steps: received 0; required at least 1 control step")
        return log.finish(state, reference)


class FlightLog:
    """Preallocated arrays of a `Trajectory` of ``n`` control steps of ``period`` [s]."""

    def __init__(self, n: int, period: float) -> None:
        self.period = period
        self.attitude, self.reference, self.target = (np.empty((n, 3, 3)) for _ in range(3))
        self.momentum, self.torque = np.empty((n, 3)), np.empty((n, 3))
        self.residual, self.cost, self.solve_time = (np.full(n, math.nan) for _ in range(3))
        self.alpha, self.margin = np.empty(n), np.empty(n)
        self.iterations, self.status = np.zeros(n, np.int64), np.full(n, -1, np.int64)
        self.source = np.zeros(n, np.int64)

    def add(
        self, k: int, state: State, target: Matrix3, decision: GovernorDecision, command: Command
    ) -> None:
        """Store control step k."""
        self.attitude[k], self.momentum[k] = state.attitude, state.momentum
        self.target[k], self.reference[k] = target, decision.reference.attitude
        self.torque[k] = command.torque
        self.alpha[k], self.margin[k] = decision.alpha, decision.margin
        self.source[k] = command.source
        solution, status = command.solution, command.status
        if status is not None:
            self.status[k] = status
        if solution is not None:
            self.iterations[k], self.solve_time[k] = solution.iterations, solution.solve_time
            self.residual[k], self.cost[k] = solution.residual, solution.cost

    def finish(self, state: State, reference: Reference) -> Trajectory:
        """Close the record with the state after the last step."""
        return Trajectory(
            period=self.period,
            time=np.asarray(self.period * np.arange(len(self.cost)), dtype=np.float64),
            attitude=self.attitude,
            momentum=self.momentum,
            torque=self.torque,
            reference=self.reference,
            target=self.target,
            iterations=self.iterations,
            residual=self.residual,
            cost=self.cost,
            solve_time=self.solve_time,
            status=self.status,
            source=self.source,
            alpha=self.alpha,
            governor_margin=self.margin,
            final_attitude=state.attitude,
            final_momentum=state.momentum,
            final_reference=reference.attitude,
        )
