"""Simulated deputy and chief, advanced one control step at a time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.arguments import as_count, as_limit, as_real, require_kind, require_word
from spacecraft_gnc.arrays import as_finite
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.plant.actuators import Actuators, component_limits
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.types import Array, as_rotation, as_vector3, read_only
from spacecraft_gnc.vehicles.docking.dynamics import ALL_THRUSTERS, RelativeMotion
from spacecraft_gnc.vehicles.docking.flight import DockingFlight
from spacecraft_gnc.vehicles.docking.geometry import deputy_center
from spacecraft_gnc.vehicles.docking.navigation import NavigationNoise
from spacecraft_gnc.vehicles.docking.signals import POSE, STATE, Motion, Wrench
from spacecraft_gnc.vehicles.docking.state import DIRECTIONS, Navigation, RelativeState

_IDLE = read_only(np.zeros(6))


class DockingPlant:
    """A deputy that thrusters move beside a rotating chief.

    Parameters
    ----------
    motion : RelativeMotion
        Bodies, chief and control period.
    initial : Navigation
        Motion at the start.
    n_steps : int
        Control steps of the scenario.
    max_force, max_moment : float
        Limit of each component, chief frame [N], [N m].
    saturates : bool
        Whether the thrusters keep to the limits; else they give what is asked for.
    lost : str
        Direction of `DIRECTIONS` that is lost; empty: none.
    lost_at : float
        Time [s] from which on; it takes effect at the first control step that does not start
        before it.
    noise : NavigationNoise, optional
        None: what is measured is the truth.
    pose_every : int
        Control steps between two poses among the `outputs`; 0: none.

    Raises
    ------
    ShapeError, ParameterError
        If an argument is refused.
    """

    flight = DockingFlight

    def __init__(
        self,
        motion: RelativeMotion,
        initial: Navigation,
        n_steps: int,
        max_force: float,
        max_moment: float,
        *,
        saturates: bool = True,
        lost: str = "",
        lost_at: float = 0.0,
        noise: NavigationNoise | None = None,
        pose_every: int = 0,
    ) -> None:
        remedy = "lengthen the duration to one control period or more"
        self.motion = require_kind("motion", motion, RelativeMotion)
        self.period = motion.control_period
        self.n_steps = as_count("n_steps", n_steps, remedy=remedy)
        limits = [as_limit("max_force", max_force), as_limit("max_moment", max_moment)]
        most = np.repeat(limits if saturates else [math.inf] * 2, 3)
        self.actuators = Actuators(component_limits(most), "N, N m")
        self._noise = noise
        self._pose_every = pose_every
        self._lost_from, self._left = self._loss(lost, lost_at)
        self._initial = self._start(initial)
        self._state = self._initial

    @property
    def state(self) -> RelativeState:
        """State at the start of the current control step."""
        return self._state

    @property
    def idle_control(self) -> Array:
        """Force and moment (6,) where no command came: none."""
        return _IDLE

    def step(self, wrench: Array) -> RelativeState:
        """Hold force and moment (6,), chief frame, for one control period; return the new state.

        Raises
        ------
        ShapeError, ParameterError
            If it is not 6 finite numbers.
        """
        command = as_finite("wrench", wrench, (6,), "6 numbers [N], [N m]")
        s = self._state
        given = self.actuators.drive(s.step, command)
        end = self.motion.advance(
            self.period * s.step,
            s.port_offset,
            s.port_velocity,
            s.attitude,
            s.angular_velocity,
            given[:3],
            given[3:],
            s.thrusters,
        )
        truth = Navigation(*end[:4])
        margins = (end.line_of_sight_margin, end.clearance)
        self._state = self._told(s.step + 1, truth, margins, command)
        return self._state

    def outputs(self, applied: tuple[Array, Source]) -> list[tuple[Signal, Any]]:
        """Return what a node publishes at the start of the current step, the state first.

        ``applied``: force and moment (6,) and their source over the step that ended now.
        """
        state = self._state
        chief = self.motion.chief.attitude(self.period * state.step)
        told: list[tuple[Signal, Any]] = [(STATE, Motion(state, Wrench(*applied), chief))]
        if self._pose_every and state.step % self._pose_every == 0:
            told.append((POSE, self._pose(state)))
        return told

    def warm_up(self) -> None:
        """Load the integrator's kernels."""
        self.motion.advance(0.0, *self._initial[1:5], _IDLE[:3], _IDLE[3:])

    def reset(self) -> None:
        """Return to the initial state."""
        self._state = self._initial
        self.actuators.reset()

    def _pose(self, state: RelativeState) -> tuple[Any, ...]:
        """Return the deputy's center of mass and attitude, chief frame."""
        ports = self.motion.chief_body.port, self.motion.deputy.port
        center = deputy_center(*ports, state.port_offset, state.attitude)
        return ([*center.tolist(), *lie.to_quaternion_xyzw(state.attitude).tolist()],)

    def _start(self, initial: Navigation) -> RelativeState:
        truth = Navigation(
            as_vector3("initial.port_offset", initial.port_offset),
            as_vector3("initial.port_velocity", initial.port_velocity),
            as_rotation("initial.attitude", initial.attitude),
            as_vector3("initial.angular_velocity", initial.angular_velocity),
        )
        margins = self.motion.margins(truth.port_offset, truth.attitude)
        return self._told(0, truth, margins, _IDLE)

    def _told(
        self, step: int, truth: Navigation, margins: tuple[float, float], applied: Array
    ) -> RelativeState:
        """Return a state with what is measured of it, and what is true of its thrusters."""
        measured = truth if self._noise is None else self._noise.measure(step, truth)
        thrusters = ALL_THRUSTERS if step < self._lost_from else self._left
        return RelativeState(step, *truth, measured, *margins, thrusters, applied)

    def _loss(self, lost: str, at: float) -> tuple[float, NDArray[np.bool_]]:
        """Return the first step of a loss, infinity: none, and what is then left (6,)."""
        require_word("lost", lost, ("", *DIRECTIONS))
        time = as_real("lost_at", at, lambda x: x >= 0.0, "a time >= 0 s", "give that of the loss")
        if not lost:
            return math.inf, ALL_THRUSTERS
        left = ALL_THRUSTERS.copy()
        left[DIRECTIONS.index(lost)] = False
        left.setflags(write=False)
        # A hair of slack: 15.05 s are 7 periods of 2.15 s whatever the last bit.
        return float(np.ceil(time / self.period * (1.0 - 1e-12))), left
