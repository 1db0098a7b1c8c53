"""Motion of a plan, step by step: what a body on the plan is to do, as a moving reference.

A solver that tracks a `Reference` makes of its rate and torque the momentum Pi and the torque u of
the body on its way (docs/solver.md, "A moving reference"). The reference here is the one of which
it makes those of the plan: with the integrator's step h,

    sin(h |omega|) / (h |omega|) J omega = Pi - h u / 2,
    tau = u + (1 - s^2) omega x J omega,   s = sin(h |omega| / 2) / (h |omega| / 2).

A body that is on the plan gets exactly the torque of the plan.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from spacecraft_gnc.arguments import require_kind
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.ocp.reference import RESTING
from spacecraft_gnc.ocp.transfer import TransferSolution
from spacecraft_gnc.types import Array, Matrix3, Reference, Vector3, read_only

_NO_TORQUE: Final = read_only(np.zeros(3))


def reference_of(
    body: RigidBody, attitude: Matrix3, momentum: Vector3, torque: Vector3
) -> Reference:
    """Return the moving reference on which a body has that momentum, and gets that torque.

    Parameters
    ----------
    body : RigidBody
        Inertia, and the step h of the integrator that carries the body.
    attitude : (3, 3) array
        Body to inertial.
    momentum, torque : (3,) arrays
        Body frame [N m s], [N m].

    Notes
    -----
    Assumption: a step of the body turns by less than a quarter of a turn.
    """
    h, J = body.time_step, body.inertia
    mean: Array = np.asarray(np.linalg.solve(J, momentum - 0.5 * h * torque))
    size = float(np.linalg.norm(mean))
    angle = math.asin(min(h * size, 1.0))
    rate = mean * (angle / (h * size) if size > 0.0 else 0.0)
    half = math.sin(0.5 * angle) / (0.5 * angle) if angle > 0.0 else 1.0
    gyroscopic = np.cross(rate, J @ rate)
    return Reference(attitude, read_only(rate), read_only(torque + (1.0 - half**2) * gyroscopic))


class Waypoint(NamedTuple):
    """What belongs to one control step of a plan."""

    plan_step: int
    """Steps since the plan began, at most its length."""
    attitude: Matrix3
    """(3, 3), body to inertial."""
    momentum: Vector3
    """(3,) body frame [N m s]."""
    torque: Vector3
    """(3,) held over the step, body frame [N m]."""
    reference: Reference
    """What a controller is to track: it makes these of it."""


class PlannedMotion:
    """A plan that begins at some control step; from its end on, rest at the goal.

    Parameters
    ----------
    plan : TransferSolution
    first_step : int
        Control step at which it begins.
    plant_step : float
        Step of the integrator that is to follow [s]. Where it is shorter than that of the plan, the
        motion of the plan is that of the body up to the error of the longer step.
    """

    def __init__(self, plan: TransferSolution, first_step: int, plant_step: float) -> None:
        self.plan = require_kind("plan", plan, TransferSolution)
        self.first_step = first_step
        self._body = RigidBody(plan.problem.body.inertia, plant_step)

    @property
    def goal(self) -> Matrix3:
        """Attitude (3, 3) at which it ends, body to inertial."""
        return self.plan.problem.goal

    @property
    def n_steps(self) -> int:
        """Number of steps."""
        return self.plan.problem.n_steps

    def torques(self, step: int, count: int) -> Array:
        """Return the torques (count, 3) from a control step on [N m]; zero after the end."""
        planned = self.plan.torque[max(0, step - self.first_step) :][:count]
        return np.vstack([planned, np.zeros((count - len(planned), 3))])

    def at(self, step: int) -> Waypoint:
        """Return what belongs to a control step."""
        k = min(max(0, step - self.first_step), self.n_steps)
        if k == self.n_steps:
            momentum = self.plan.problem.goal_momentum
            reference = Reference(self.goal, RESTING[0], RESTING[1])
            return Waypoint(k, self.goal, momentum, _NO_TORQUE, reference)
        parts = (self.plan.attitude[k], self.plan.momentum[k], self.plan.torque[k])
        attitude, momentum, torque = (read_only(part.copy()) for part in parts)
        reference = reference_of(self._body, attitude, momentum, torque)
        return Waypoint(k, attitude, momentum, torque, reference)
