"""Governors whose reference moves: a turn at constant rate, and a stored trajectory.

Neither governs: the reference goes its way whatever the state is. With each attitude come the rate
omega, in the reference's own frame, and the torque that keeps a body of inertia J on its way,

    tau = J d(omega)/dt + omega x J omega.

The reference of a control step follows from the number of the step alone, so that a governor that
is started anew in flight goes on where it was.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.arguments import as_limit, require_positive
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors._rotation_spline import RotationSpline
from spacecraft_gnc.types import (
    Array,
    ArrayLike,
    GovernorDecision,
    Matrix3,
    Reference,
    State,
    Vector3,
    as_inertia,
    as_rotation,
    as_vector3,
    read_only,
)


def feedforward_torque(inertia: Matrix3, rate: Vector3, acceleration: Vector3) -> Vector3:
    """Return J d(omega)/dt + omega x J omega (3,) [N m], body frame."""
    return np.asarray(inertia @ acceleration + np.cross(rate, inertia @ rate))


def attitudes_of(rotation_vectors: Array) -> Array:
    """Return the attitudes (n, 3, 3) of the rows of a table (n, 3) [rad]."""
    return np.array([lie.exp(vector) for vector in rotation_vectors]).reshape(-1, 3, 3)


class TurningReference:
    """A reference that turns at a constant rate.

    Parameters
    ----------
    attitude : (3, 3) array
        At step 0, body to inertial.
    angular_velocity : (3,) array
        In the reference's own frame, where as in the inertial one it is constant [rad/s].
    inertia : (3, 3) array
        Of the body that is to follow, body frame [kg m^2].
    period : float
        Control period [s].

    Raises
    ------
    ShapeError, ParameterError
        If an argument is refused.
    """

    name = "turning_reference"
    slow = False
    moves = True

    def __init__(
        self, attitude: ArrayLike, angular_velocity: ArrayLike, inertia: ArrayLike, period: float
    ) -> None:
        self._initial = as_rotation("attitude", attitude)
        self._rate = as_vector3("angular_velocity", angular_velocity)
        self._period = require_positive("period", period)
        moments = as_inertia("inertia", inertia)
        self._torque = read_only(feedforward_torque(moments, self._rate, np.zeros(3)))
        self.reset()

    @property
    def target(self) -> Matrix3:
        """Attitude (3, 3) of the current step, body to inertial."""
        return self._target

    def set_target(self, attitude: Matrix3) -> None:
        """Go on turning from another attitude (3, 3), at the step that is decided next."""
        self._target = self._start = as_rotation("target", attitude)
        self._first = -1

    def warm_up(self) -> None:
        """Nothing to compile."""

    def reset(self) -> None:
        """Return to the first attitude, at step 0."""
        self._target = self._start = self._initial
        self._first = 0

    def memory(self) -> tuple[Any, ...]:
        """Return where the turn started, and the target."""
        return self._target, self._start, self._first

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on as the governor did whose `memory` it is."""
        self._target, self._start, self._first = memory

    def decide(self, state: State) -> GovernorDecision:
        """Return the reference of the state's step, whatever the rest of the state is."""
        if self._first < 0:
            self._first = state.step
        time = (state.step - self._first) * self._period
        self._target = read_only(self._start @ lie.exp(time * self._rate))
        return _decision(Reference(self._target, self._rate, self._torque))


class StoredTrajectory:
    """A reference that follows a table, smoothly from row to row (`RotationSpline`).

    After the last row it goes on at the last rate: at rest, where that is zero.

    Parameters
    ----------
    times : (n,) array
        From 0 on, increasing [s].
    attitudes : (n, 3, 3) array
        Body to inertial.
    angular_velocities : (n, 3) array
        In the reference's own frame [rad/s].
    inertia : (3, 3) array
        Of the body that is to follow, body frame [kg m^2].
    period : float
        Control period [s].
    torques : (n, 3) array, optional
        Torque at each time [N m], own frame, taken linearly between the rows; what the inertia
        needs if absent. It is that of the middle of a control step, over which it is held.
    plant_step : float
        Step [s] of the integrator that is to follow, 0 for a continuous body: it takes a torque in
        at the end of each of its steps, on average so much later.

    Raises
    ------
    ShapeError, ParameterError
        If the table has fewer than two rows, its times do not start at 0 and increase, a row is no
        rotation, the rotations of two rows are half a turn apart, or a rate does not fit them.
    """

    name = "stored_trajectory"
    slow = False
    moves = True

    def __init__(
        self,
        times: ArrayLike,
        attitudes: ArrayLike,
        angular_velocities: ArrayLike,
        inertia: ArrayLike,
        period: float,
        torques: ArrayLike | None = None,
        plant_step: float = 0.0,
    ) -> None:
        self._spline = RotationSpline(times, attitudes, angular_velocities, torques)
        self._period = require_positive("period", period)
        self._middle = 0.5 * (self._period + as_limit("plant_step", plant_step))
        self._inertia = as_inertia("inertia", inertia)
        self.reset()

    @property
    def target(self) -> Matrix3:
        """Attitude (3, 3) of the current step, body to inertial."""
        return self._target

    def set_target(self, attitude: Matrix3) -> None:
        """Refuse: raise ParameterError, for the table says where to go."""
        del attitude
        raise ParameterError(
            "target: received an attitude; required none, since the reference follows a stored "
            "trajectory; fly another governor to slew"
        )

    def warm_up(self) -> None:
        """Nothing to compile."""

    def reset(self) -> None:
        """Return to the first row."""
        self._target = self._spline.attitude(0.0)

    def memory(self) -> tuple[Any, ...]:
        """Return the attitude of the last step; the next one follows from its number."""
        return (self._target,)

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on as the governor did whose `memory` it is."""
        (self._target,) = memory

    def decide(self, state: State) -> GovernorDecision:
        """Return the reference of the state's step, whatever the rest of the state is."""
        time, spline = state.step * self._period, self._spline
        self._target = read_only(spline.attitude(time))
        rate, _ = spline.motion(time)
        middle = time + self._middle
        torque = spline.torque(middle)
        if torque is None:
            torque = feedforward_torque(self._inertia, *spline.motion(middle))
        return _decision(Reference(self._target, read_only(rate), read_only(torque)))


def _decision(reference: Reference) -> GovernorDecision:
    return GovernorDecision(reference, 1.0, True, math.inf, "", 0)
