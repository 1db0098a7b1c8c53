"""``method: neighboring_extremal``: on line, or along a stored nominal run as in the paper."""

from __future__ import annotations

from typing import Any

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.loop.protocols import Command, Reference, Source, State
from spacecraft_gnc.ocp import NominalRun, ShootingSolver, Solution, fly_nominal
from spacecraft_gnc.ocp.reference import is_moving
from spacecraft_gnc.types import Array, Matrix3, Vector3
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import (
    OnlineNeighboringController,
    ShootingController,
    keeps_chord,
    monitor_of,
    options_of,
    problem_of,
)
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario


class NominalRunController:
    """Neighboring extremals along a stored run, with an exact solve every so many steps.

    Parameters
    ----------
    exact : ShootingController
        Flies the nominal run once, and answers the exact steps and those beyond the run's end.
    attitude, momentum : (3, 3), (3,) arrays
        Start of the nominal run.
    n_steps : int
        Length of the nominal run.
    exact_every : int
        Every that many steps the problem is solved exactly; 0: never.
    """

    name = "neighboring_extremal"
    slow = False

    def __init__(
        self,
        exact: ShootingController,
        solver: ShootingSolver,
        attitude: Matrix3,
        momentum: Vector3,
        n_steps: int,
        exact_every: int,
    ) -> None:
        self._exact = exact
        self._solver = solver
        self._start = (attitude, momentum)
        self._n_steps = n_steps
        self._exact_every = exact_every
        self.period = exact.period
        self._run: NominalRun | None = None
        self._run_reference = np.empty(0)

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> NominalRunController:
        """Build the controller of a scenario's section ``nmpc_controller``."""
        c, ocp, options = scenario.controller, problem_of(scenario), options_of(scenario)
        exact = ShootingController(ShootingSolver(ocp, options=options), monitor_of(scenario, ocp))
        solver = ShootingSolver(ocp, options=options)  # a chord must not carry one into the other
        start = lie.exp(c.nominal_rotation_vector)
        return cls(exact, solver, start, c.nominal_momentum, scenario.n_steps, c.exact_every)

    def warm_up(self) -> None:
        """Compile or load the kernels."""
        self._exact.warm_up()
        fly_nominal(self._solver, *self._start, 1).torque(0, *self._start)

    def reset(self) -> None:
        """Forget the past; the nominal run stays."""
        self._exact.reset()

    def memory(self) -> tuple[Any, ...] | None:
        """Return that of the exact solves; None: a chord, which the run leaves behind as well."""
        return None if keeps_chord(self._solver) else self._exact.memory()

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on as the controller did whose `memory` it is; the run is flown again."""
        self._exact.recall(memory)

    def command(self, state: State, reference: Reference) -> Command:
        """Return the torque of the run, corrected for where the body is, or an exact solve's."""
        run = self._nominal(reference)
        due = self._exact_every > 0 and state.step % self._exact_every == 0
        if run is None or due or state.step >= len(run):
            return self._exact.command(state, reference)
        torque = run.torque(state.step, state.attitude, state.momentum)
        if not np.isfinite(torque).all():
            return self._exact.command(state, reference)
        torque = self._solver.ocp.realizable(torque)
        return Command(torque, Source.NEIGHBORING_EXTREMAL)

    def solve(
        self, state: State, reference: Reference, warm_start: Array | None
    ) -> Solution | None:
        """Try everything that an exact step tries: see `SolverController.solve`."""
        return self._exact.solve(state, reference, warm_start)

    def _nominal(self, reference: Reference) -> NominalRun | None:
        """Return the run toward this reference, flown once; None where it cannot be flown.

        A run leads to rest: none leads to a moving reference, which the exact solves track.
        """
        if is_moving(reference):
            return None
        target = reference.attitude
        if not np.array_equal(target, self._run_reference):
            self._run_reference = target
            try:
                self._run = fly_nominal(self._solver, *self._start, self._n_steps, target)
            except GncError:  # no exception in flight: the exact solves go on without it
                self._run = None
        return self._run


def from_scenario(scenario: Scenario) -> NominalRunController | OnlineNeighboringController:
    """Return the controller along a nominal run where one is given, else the on-line one."""
    if np.isnan(scenario.controller.nominal_rotation_vector).any():
        return OnlineNeighboringController.from_scenario(scenario)
    return NominalRunController.from_scenario(scenario)
