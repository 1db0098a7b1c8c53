"""Simulated spacecraft with reaction wheels, advanced one control step at a time."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.arguments import as_count, require_kind
from spacecraft_gnc.arrays import as_finite, as_float, as_shaped, listed
from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.plant.actuators import Actuators, component_limits
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.signals.attitude import POSE, pose_of
from spacecraft_gnc.types import Array, ArrayLike, Invariants, Vector3
from spacecraft_gnc.vehicles.two_wheel.dynamics import Gyrostat
from spacecraft_gnc.vehicles.two_wheel.flight import WheelFlight
from spacecraft_gnc.vehicles.two_wheel.signals import STATE, Accelerations, Motion
from spacecraft_gnc.vehicles.two_wheel.state import WheelState
from spacecraft_gnc.vehicles.two_wheel.wheels import as_loss, read_only_mask


class GyrostatPlant:
    """A bus with m reaction wheels, driven by their accelerations.

    Parameters
    ----------
    gyrostat : Gyrostat
        Inertias, axes, limits and integrator step.
    initial : WheelState
        State at the start, from `Gyrostat.state_from_rate` or `Gyrostat.state_from_momentum`.
    n_steps : int
        Control steps of the scenario.
    substeps : int
        Integrator steps in one control period, over which the accelerations are held.
    lost_at : (m,) array, optional
        Time [s] from which on a wheel is lost; infinity: never. It takes effect at the first
        control step that does not start before it.
    lost_share : float
        Share of the commanded acceleration that a lost wheel still gives, 0 to 1.
    lost_friction : float
        Coulomb friction of a lost wheel beside that of its bearing [N m].
    pose_every : int
        Control steps between two poses among the `outputs`; 0: none.

    Raises
    ------
    ShapeError, ParameterError
        If an argument is refused.
    """

    flight = WheelFlight

    def __init__(
        self,
        gyrostat: Gyrostat,
        initial: WheelState,
        n_steps: int,
        substeps: int = 1,
        lost_at: ArrayLike | None = None,
        *,
        lost_share: float = 0.0,
        lost_friction: float = 0.0,
        pose_every: int = 0,
    ) -> None:
        remedy = "lengthen the duration to one control period or more"
        self.gyrostat = require_kind("gyrostat", gyrostat, Gyrostat)
        self.substeps = as_count("substeps", substeps)
        self.period = self.substeps * gyrostat.time_step
        self.n_steps = as_count("n_steps", n_steps, remedy=remedy)
        most = gyrostat.max_acceleration or math.inf
        self.actuators = Actuators(component_limits(most), "rad/s^2")
        require_kind("initial", initial, WheelState)
        as_shaped("initial.wheel_speed", initial.wheel_speed, (gyrostat.n_wheels,))
        self._pose_every = pose_every
        self._lost_share, self._lost_friction = as_loss(lost_share, lost_friction)
        self._after_loss: dict[bytes, Gyrostat] = {}
        self._lost_from = self._loss_steps(lost_at)
        self._last_loss = max((k for k in self._lost_from if math.isfinite(k)), default=-1.0)
        self._initial = self._told(initial)
        self._state = self._initial

    @property
    def state(self) -> WheelState:
        """State at the start of the current control step."""
        return self._state

    @property
    def healthy(self) -> NDArray[np.bool_]:
        """Whether each wheel (m,) answers its command in the current control step."""
        return self._state.healthy

    @property
    def idle_control(self) -> Array:
        """Accelerations (m,) [rad/s^2] where no command came: every wheel keeps its speed."""
        return np.zeros(self.gyrostat.n_wheels)

    def step(self, acceleration: Array) -> WheelState:
        """Hold wheel accelerations (m,) [rad/s^2] for one control period; return the new state.

        Raises
        ------
        ShapeError, ParameterError
            If it is not m finite numbers, or the bus has come to turn too fast for the time step.
        """
        m = self.gyrostat.n_wheels
        command = as_finite("acceleration", acceleration, (m,), f"{m} numbers [rad/s^2]")
        given = self.actuators.drive(self._state.step, command)
        self._state = self._told(self.advance(self._state, given)._replace(applied=command))
        return self._state

    def advance(self, state: WheelState, acceleration: Array) -> WheelState:
        """Return the state a control period after ``state``, whose health counts.

        Parameters
        ----------
        state : WheelState
            Any state of these wheels.
        acceleration : (m,) array
            Commanded, relative to the bus [rad/s^2].
        """
        healthy, most = state.healthy, self.gyrostat.max_acceleration or math.inf
        left = self._lost_share * np.clip(acceleration, -most, most)
        driven = np.where(healthy, acceleration, left)
        return self._as_flown(healthy).step(state, driven, self.substeps)

    def _as_flown(self, healthy: NDArray[np.bool_]) -> Gyrostat:
        """Return the gyrostat with the friction of lost wheels."""
        if healthy.all() or not self._lost_friction:
            return self.gyrostat
        key = healthy.tobytes()
        if key not in self._after_loss:
            bearings = self.gyrostat.coulomb_friction
            least = bearings if bearings.size else np.zeros(self.gyrostat.n_wheels)
            coulomb = np.where(healthy, least, least + self._lost_friction)
            self._after_loss[key] = replace(self.gyrostat, coulomb_friction=coulomb)
        return self._after_loss[key]

    def outputs(self, applied: tuple[Array, Source]) -> list[tuple[Signal, Any]]:
        """Return what a node publishes at the start of the current step, the state first.

        ``applied``: accelerations (m,) [rad/s^2] and their source over the step that ended now.
        """
        state = self._state
        motion = Motion(state, Accelerations(*applied), self.gyrostat.kinetic_energy(state))
        told: list[tuple[Signal, Any]] = [(STATE, motion)]
        if self._pose_every and state.step % self._pose_every == 0:
            told.append((POSE, pose_of(state.attitude)))
        return told

    def invariants(self) -> Invariants:
        """Energy, total inertial momentum and orthogonality error of the current state."""
        defect = self._state.attitude.T @ self._state.attitude - np.eye(3)
        return Invariants(
            self.gyrostat.kinetic_energy(self._state),
            self._state.total_momentum,
            float(np.linalg.norm(defect)),
        )

    def angular_velocity(self) -> Vector3:
        """Rate of the bus (3,) in the current state, body frame [rad/s]."""
        return self._state.angular_velocity

    def warm_up(self) -> None:
        """Load the integrator's kernels."""
        self.gyrostat.step(self._initial, np.zeros(self.gyrostat.n_wheels))

    def reset(self) -> None:
        """Return to the initial state."""
        self._state = self._initial
        self.actuators.reset()

    def _told(self, state: WheelState) -> WheelState:
        """Return a state with what is true of its wheels."""
        if state.step > self._last_loss:  # as in the step before
            return state
        return state._replace(healthy=read_only_mask(state.step < self._lost_from))

    def _loss_steps(self, lost_at: ArrayLike | None) -> Array:
        """Return the first step (m,) of which each wheel is lost; infinity: none."""
        n_wheels = self.gyrostat.n_wheels
        if lost_at is None:
            return np.full(n_wheels, math.inf)
        times = as_float("lost_at", lost_at, f"{n_wheels} times [s]")
        if times.shape != (n_wheels,):
            raise ShapeError(
                f"lost_at: received an array of shape {times.shape}; required ({n_wheels},), one "
                "time for each wheel; use infinity for a wheel that is not lost"
            )
        if not (times >= 0.0).all():
            raise ParameterError(
                f"lost_at: received {listed(times)}; required times >= 0 s; use infinity for a "
                "wheel that is not lost"
            )
        # A hair of slack: 15.05 s are 7 periods of 2.15 s whatever the last bit.
        return np.ceil(times / self.period * (1.0 - 1e-12))
