"""Neighboring extremals along a stored flight: the study of Bagherzadeh et al. 2023, section 6.

A nominal closed-loop run is flown and stored once, with the gain of every step. From other initial
conditions the torque is then that of the run plus the gain times the deviation from it, (59) and
(66), cut to the torque limit; nothing is solved. `loop.neighboring` flies it, with an exact solve
every so many steps if asked.

Measured (docs/reproduce.md): fed with the true state, this does not drift. A drift as in the paper
comes out where the deviation is itself propagated linearly and its torques are flown open loop.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spacecraft_gnc.arguments import as_count, require_kind
from spacecraft_gnc.arrays import as_shaped
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.ocp._neighboring_kernels import feed_back
from spacecraft_gnc.ocp.linearization import linearize
from spacecraft_gnc.ocp.reference import Tracked, is_moving
from spacecraft_gnc.ocp.shooting import ShootingSolver
from spacecraft_gnc.ocp.solution import Solution
from spacecraft_gnc.types import (
    Array,
    ArrayLike,
    Matrix3,
    Reference,
    Vector3,
    as_rotation,
    as_vector3,
)


@dataclass(frozen=True, slots=True)
class NominalRun:
    """A closed-loop flight, with the first gain of every solve along it.

    Attributes
    ----------
    attitudes : (n, 3, 3) array
        Rotation at each step, body to inertial.
    momenta : (n, 3) array
        Angular momentum, body frame [N m s].
    torques : (n, 3) array
        Torque of each step [N m].
    gains : (n, 3, 6) array
        Derivative of that torque to (eta, delta Pi).
    """

    attitudes: Array
    momenta: Array
    torques: Array
    gains: Array

    def __len__(self) -> int:
        return len(self.torques)

    def torque(self, step: int, attitude: Matrix3, momentum: Vector3) -> Vector3:
        """Return the torque (3,) [N m] of a step from a neighboring state, not yet limited.

        The state lies less than half a turn from the run's. Raises ShapeError or ParameterError if
        an argument is refused.
        """
        if as_count("step", step, least=0) >= len(self):
            raise ParameterError(
                f"step: received {step}; required less than {len(self)}, the steps of the run; fly "
                "a longer one"
            )
        state, torque = np.empty((4, 3)), np.empty(3)
        state[:3] = as_shaped("attitude", attitude, (3, 3))
        state[3] = as_shaped("momentum", momentum, (3,))
        feed_back(self.attitudes, self.momenta, self.torques, self.gains, step, state, torque)
        return torque


def fly_nominal(
    solver: ShootingSolver,
    attitude: ArrayLike,
    momentum: ArrayLike,
    n_steps: int,
    reference: Tracked | None = None,
) -> NominalRun:
    """Fly the closed loop of exact solves and store it with its gains.

    Raises
    ------
    ParameterError
        If a solve along the run does not converge, or the reference moves.
    """
    require_kind("solver", solver, ShootingSolver)
    if isinstance(reference, Reference) and is_moving(reference):
        raise ParameterError(
            "reference: received one that moves; required one at rest, which a stored run can "
            "lead to; use `NeighboringExtremal`"
        )
    n_steps = as_count("n_steps", n_steps)
    R, Pi = as_rotation("attitude", attitude), as_vector3("momentum", momentum)
    run = NominalRun(
        np.empty((n_steps, 3, 3)), np.empty((n_steps, 3)), np.empty((n_steps, 3)),
        np.empty((n_steps, 3, 6)),
    )  # fmt: skip
    warm_start: Array | None = None
    for k in range(n_steps):
        solution: Solution = solver.solve(R, Pi, reference, warm_start)
        if not solution.converged:
            raise ParameterError(
                f"nominal run: received a start from which step {k} is not solved "
                f"({solution.status.name}); required a start that flies; choose another one"
            )
        run.attitudes[k], run.momenta[k], run.torques[k] = R, Pi, solution.torques[0]
        run.gains[k] = linearize(solution).gains[0]
        warm_start = solution.warm_start
        R, Pi = solver.ocp.body.step(R, Pi, solution.torques[0])
    return run
