"""Rigid-body plant behind the `Plant` protocol."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.arguments import as_count, as_limit, require_kind
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.loop.protocols import Source, Stretch
from spacecraft_gnc.plant.actuators import Actuators, component_limits
from spacecraft_gnc.plant.disturbances.registry import build
from spacecraft_gnc.plant.disturbances.torques import Disturbances, Motion
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.signals.attitude import POSE, pose_of
from spacecraft_gnc.types import (
    ArrayLike,
    Invariants,
    State,
    Vector3,
    as_rotation,
    as_vector3,
    read_only,
)
from spacecraft_gnc.vehicles.rigid_body.flight import RigidBodyFlight
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario, known_inertia
from spacecraft_gnc.vehicles.rigid_body.signals import INVARIANTS, STATE, StateAndRate

_NO_TORQUE: Final = read_only(np.zeros(3))


class RigidBodyPlant:
    """A rigid spacecraft driven by a body torque, integrated by the LGVI.

    Parameters
    ----------
    body : RigidBody
        Inertia and integrator step.
    attitude : (3, 3) array
        Initial rotation, body to inertial.
    momentum : (3,) array
        Initial angular momentum, body frame [N m s].
    n_steps : int
        Control steps of the scenario.
    substeps : int
        Integrator steps in one control period, over which the torque is held.
    disturbances : Disturbances, optional
        External torques, whose sum is held over the control period like the torque.
    pose_every : int
        Control steps between two poses for viewers; 0: none.
    max_torque : float
        What the actuators give at most about each axis of the body [N m]; 0: no limit.

    Raises
    ------
    ShapeError, ParameterError
        If an argument is refused, or the first step does not exist (Kalabic (3)).
    """

    flight = RigidBodyFlight

    def __init__(
        self,
        body: RigidBody,
        attitude: ArrayLike,
        momentum: ArrayLike,
        n_steps: int,
        substeps: int = 1,
        disturbances: Disturbances | None = None,
        pose_every: int = 0,
        *,
        max_torque: float = 0.0,
    ) -> None:
        remedy = "lengthen the duration to one control period or more"
        self.body = require_kind("body", body, RigidBody)
        self.inertia = body.inertia
        self.substeps = as_count("substeps", substeps)
        self.period = self.substeps * body.time_step
        self._pose_every = pose_every
        self.n_steps = as_count("n_steps", n_steps, remedy=remedy)
        initial = State(0, as_rotation("attitude", attitude), as_vector3("momentum", momentum))
        body.require_solvable("momentum", initial.momentum)
        self.disturbances = Disturbances() if disturbances is None else disturbances
        self._is_disturbed = bool(self.disturbances)
        most = as_limit("max_torque", max_torque) or math.inf
        self.actuators = Actuators(component_limits(most), "N m")
        self._initial = initial
        self._state, self._external = initial, _NO_TORQUE

    @classmethod
    def from_scenario(cls, scenario: Scenario, *, is_disturbed: bool = True) -> RigidBodyPlant:
        """Build the plant of a scenario's sections ``plant`` and ``nmpc_controller``.

        Unless it ``is_disturbed``, without the disturbances that the scenario lists.
        """
        p = scenario.plant
        inertia = known_inertia(scenario, "plant", p.inertia)
        return cls(
            RigidBody(inertia, p.time_step),
            lie.exp(p.initial_rotation_vector),
            p.initial_momentum,
            scenario.n_steps,
            scenario.substeps,
            build(p, inertia) if is_disturbed else None,
            pose_every=p.pose_every,
            max_torque=p.max_torque,
        )

    @property
    def idle_control(self) -> Vector3:
        """Torque (3,) where no command came [N m]."""
        return np.zeros(3)

    @property
    def state(self) -> State:
        """State at the start of the current control step."""
        return self._state

    @property
    def external_torque(self) -> Vector3:
        """Torque of the disturbances (3,) [N m] over the last control step; zero at step 0."""
        return self._external

    def step(self, torque: Vector3) -> State:
        """Hold ``torque`` (3,) [N m] for one control period and return the new state.

        What exceeds the limit of the actuators is cut.

        Raises
        ------
        ParameterError
            If the momentum has grown so large that a step does not exist (Kalabic (3)).
        """
        k, attitude, momentum = self._state
        torque, external = self.actuators.drive(k, torque), self._external
        if self._is_disturbed:
            external = self.disturbances.torque(*self._middle(torque))
            torque = torque + external
        attitude, momentum = self.body.step(attitude, momentum, torque, self.substeps)
        self._state = State(k + 1, read_only(attitude), read_only(momentum))
        self._external = external
        return self._state

    def _middle(self, torque: Vector3) -> Iterator[Motion]:
        """Yield the motion at the ends of the one or two integrator steps in the middle.

        Impulses come at the ends of integrator steps, so that this is where those of the control
        step are centered. For a single one, it is the end of the step, which no torque changes.
        """
        (k, attitude, momentum), n, done = self._state, self.substeps, 0
        for j in range((n + 1) // 2, n // 2 + 2):
            attitude, momentum = self.body.step(attitude, momentum, torque, j - done)
            done, time = j, (k * n + j) * self.body.time_step
            yield Motion(k, time, attitude, self.body.angular_velocity(momentum))

    def invariants(self) -> Invariants:
        """Energy, inertial momentum and orthogonality error of the current state."""
        _, attitude, momentum = self._state
        defect = float(np.linalg.norm(attitude.T @ attitude - np.eye(3)))
        return Invariants(self.body.kinetic_energy(momentum), attitude @ momentum, defect)

    def angular_velocity(self) -> Vector3:
        """Body rate (3,) of the current state [rad/s]."""
        return self.body.angular_velocity(self._state.momentum)

    def outputs(self, applied: tuple[Vector3, Source]) -> Iterator[tuple[Signal, Any]]:
        """Yield what is published at the start of the current step.

        The state comes first, and nothing else is computed before it is taken: the others wait.
        ``applied``: torque (3,) [N m] that was asked for over the step that ended now, and its
        source; what the actuators gave of it is told.
        """
        state, (asked, source) = self._state, applied
        torque = self.actuators.given(asked)
        yield STATE, StateAndRate(state, self.angular_velocity())
        yield INVARIANTS, (*self.invariants(), torque, int(source), self._external)
        if self._pose_every and state.step % self._pose_every == 0:
            yield POSE, pose_of(state.attitude)

    def warm_up(self) -> None:
        """Load the integrator's kernels."""
        zero = np.zeros(3)
        self.body.step(np.eye(3), zero, zero, self.substeps)

    def stretch(self, controller: Any, governor: Any, most: int) -> Stretch | None:
        """Return what flies up to ``most`` steps at once, undisturbed; see `loop.protocols`.

        Actuators with a limit are asked step by step.
        """
        is_ours = type(self) is RigidBodyPlant and type(self.body) is RigidBody
        if self._is_disturbed or self.actuators.are_limited or not is_ours:
            return None
        from spacecraft_gnc.vehicles.rigid_body.stretch import stretch_of  # loads the solvers

        return stretch_of(self, controller, governor, most)

    def take_over(self, state: State) -> None:
        """Go on from a state to which the body was advanced elsewhere, undisturbed."""
        self._state, self._external = state, _NO_TORQUE

    def reset(self) -> None:
        """Return to the initial state."""
        self._state, self._external = self._initial, _NO_TORQUE
        self.actuators.reset()
