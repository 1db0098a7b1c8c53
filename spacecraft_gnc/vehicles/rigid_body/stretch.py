"""Control steps of a rigid body under ``method: shooting``, flown at once in compiled code.

A step is flown here where it is an ordinary one: the solve converges from the multipliers of the
last one, within the patience of the continuation, and the loop has not stopped away from its
target. What comes then (a second solve, a continuation, the fallback ladder, a standstill, a step
of the plant that does not exist) the controller and the plant deal with themselves. The numbers are
the same: the same kernels with the same inputs.
"""

from __future__ import annotations

from typing import Any, Final, Protocol

import numpy as np

from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.governors.pass_through import PassThroughGovernor
from spacecraft_gnc.loop.protocols import Flown
from spacecraft_gnc.ocp import ShootingSolver, Solution
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Reference, State, read_only
from spacecraft_gnc.vehicles.rigid_body._stretch_kernels import fly_steps
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import ShootingController

_KEPT_FACTORS: Final = "chord"
"""Step rule that carries more from one solve to the next than multipliers."""


class FreePlant(Protocol):
    """What is read of a `RigidBodyPlant` that nothing disturbs."""

    body: RigidBody
    substeps: int
    n_steps: int

    def take_over(self, state: State) -> None:
        """Go on from a state."""


class ShootingStretch:
    """Flies steps of `ShootingController` and an undisturbed plant under a reference at rest.

    Parameters
    ----------
    plant : FreePlant
    controller : ShootingController
    solver : ShootingSolver
        The controller's.
    most : int
        Largest number of steps to fly at once.
    """

    def __init__(
        self,
        plant: FreePlant,
        controller: ShootingController,
        solver: ShootingSolver,
        most: int,
    ) -> None:
        self._plant, self._controller, self._solver = plant, controller, solver
        ocp = solver.ocp
        n, m = ocp.horizon, min(most, plant.n_steps)
        self._inputs, self._warm = np.zeros((7, 3)), np.empty((n, 6))
        self._plans = np.empty((2, solver.layout.size))
        self._room = np.empty((5, 3))
        self._rows = (
            np.empty((m, 3, 3)), np.empty((m, 3)), np.empty((m, 3)), np.empty(m, np.int64),
            np.empty((m, 3)),
        )  # fmt: skip

    def fly(self, state: State, reference: Reference, most: int) -> Flown | None:
        """Fly up to ``most`` steps from ``state``; None where the first is not an ordinary one."""
        self._inputs[:3], self._inputs[3] = state.attitude, state.momentum
        self._inputs[4:] = reference.attitude
        guess = self._controller.warm_start
        self._warm[...] = 0.0 if guess is None else guess
        body, rows = self._plant.body, tuple(row[:most] for row in self._rows)
        n = fly_steps(
            self._inputs, self._warm, self._plans, *self._solver.work,
            body.packed, body.time_step, self._plant.substeps, self._controller.patience,
            self._controller.rest, self._room, *rows,
        )  # fmt: skip
        if n == 0:
            return None
        attitudes, momenta, torques, iterations, values = (row[:n] for row in rows)
        last = State(state.step + n - 1, attitudes[-1].copy(), momenta[-1].copy())
        plan, took = self._plans[(n - 1) % 2].copy(), float(values[-1, 2])
        solution = Solution.of_plan(plan, self._solver.layout, Status.CONVERGED, took)
        attitude, momentum = self._inputs[:3].copy(), self._inputs[3].copy()
        self._plant.take_over(State(state.step + n, read_only(attitude), read_only(momentum)))
        return Flown(
            n,
            self._controller.conclude(last, reference, solution),
            {
                "attitude": attitudes,
                "momentum": momenta,
                "torque": torques,
                "iterations": iterations,
                "residual": values[:, 0],
                "cost": values[:, 1],
                "solve_time": values[:, 2],
            },
        )


def stretch_of(
    plant: FreePlant, controller: Any, governor: Any, most: int
) -> ShootingStretch | None:
    """Return what flies up to ``most`` steps of this loop at once; None: nothing does.

    A class derived from one of ours may do anything, and flies step by step.
    """
    if type(controller) is not ShootingController or type(governor) is not PassThroughGovernor:
        return None
    solver = controller.solver
    if type(solver) is not ShootingSolver or solver.options.step_rule == _KEPT_FACTORS:
        return None
    if controller.rest is None:
        return None
    return ShootingStretch(plant, controller, solver, most)
