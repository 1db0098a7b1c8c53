"""Gyrostat dynamics: a bus with m reaction wheels, with exact momentum and energy balance.

With R the attitude (body to inertial), omega the rate of the bus, nu_i the speed of wheel i about
its axis a_i relative to the bus, A = [a_1 ... a_m], Js = diag(Js_i) the axial inertias and J the
inertia of bus and locked wheels, the total momentum in the inertial frame is

    H = R (J omega + A Js nu),   H' = 0,   R' = R hat(omega),
    nu_i' = u_i - (c_i nu_i + tau_i sign nu_i) / Js_i,

where u is the commanded acceleration, relative to the bus, and c and tau are the viscous and the
Coulomb friction of the bearings, if any. With u held, nu is known in closed form. One stage of
length h is

    omega_m = J^-1 ((Pi_k + Pi_k+1)/2 - A Js (nu_k + nu_k+1)/2),   Pi = R^T H,
    R_k+1 = R_k cay(h omega_m),   cay(x) = (I - hat(x)/2)^-1 (I + hat(x)/2),

implicit in omega_m, symmetric in time and of second order. It keeps H, and changes the kinetic
energy by exactly the work of the motors (docs/two_wheel.md); five stages make a step of fourth
order that inherits both.

Source: Austin, Krishnaprasad and Wang, J. Comput. Phys. 107 (1993), the midpoint rule of the rigid
body, extended here to wheels; Suzuki, Phys. Lett. A 146 (1990), the composition.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.arguments import as_count, as_limit, require_positive
from spacecraft_gnc.arrays import as_finite, as_rows, as_shaped, listed
from spacecraft_gnc.dynamics.rigid_body import pack_inertia
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.types import (
    Array,
    ArrayLike,
    Matrix3,
    Vector3,
    as_inertia,
    as_rotation,
    as_vector3,
    read_only,
)
from spacecraft_gnc.vehicles.two_wheel._gyrostat_kernels import (
    MOMENTUM,
    RATE,
    SPEED,
    advance,
    propagate,
)
from spacecraft_gnc.vehicles.two_wheel.state import WheelState
from spacecraft_gnc.vehicles.two_wheel.wheels import (
    as_axes,
    as_axial,
    as_friction,
    decelerations,
    read_only_mask,
    require_bus,
)


@dataclass(frozen=True, slots=True, eq=False)
class Gyrostat:
    """A bus with m symmetric reaction wheels, free of external torque, and its time step.

    Attributes
    ----------
    inertia : (3, 3) array
        Inertia of the bus with all wheels locked, about the common center of mass, body frame
        [kg m^2].
    wheel_axes : (3, m) array
        Spin axis of each wheel in the body frame, one column each; normalized.
    wheel_inertias : (m,) array
        Inertia of each wheel about its spin axis [kg m^2]; contained in ``inertia``.
    time_step : float
        Integrator step h [s].
    max_speed, max_acceleration : float
        Limits of each wheel's speed [rad/s] and acceleration [rad/s^2] relative to the bus, at
        which they saturate; 0 means none.
    viscous_friction, coulomb_friction : (m,) arrays
        Friction of the bearings, c [N m s] and tau [N m]; (0,) where there is none. A wheel at rest
        sticks as long as abs(Js u) <= tau.

    Raises
    ------
    ShapeError, ParameterError
        If the inertia is no inertia of a body with volume, does not exceed what the wheels have
        about their axes, an axis is zero, a wheel's inertia or the time step is not positive, or
        friction is negative.
    """

    inertia: Matrix3
    wheel_axes: Array
    wheel_inertias: Array
    time_step: float
    max_speed: float = 0.0
    max_acceleration: float = 0.0
    viscous_friction: Array = field(default_factory=partial(np.empty, 0))
    coulomb_friction: Array = field(default_factory=partial(np.empty, 0))
    wheels: Array = field(init=False, repr=False)
    """(3, m) A Js [kg m^2]: momentum of the wheels per speed, body frame."""
    body: Array = field(init=False, repr=False)
    """(30,) inertia and limits, packed for the kernels."""
    friction: Array = field(init=False, repr=False)
    """(2, m) c / Js [1/s] and tau / Js [rad/s^2]; (2, 0): none."""

    def __post_init__(self) -> None:
        inertia = as_inertia("inertia", self.inertia)
        axes = as_axes(self.wheel_axes)
        axial = as_axial(self.wheel_inertias, axes.shape[1])
        require_bus(inertia, axes, axial)
        limits = [as_limit(name, getattr(self, name)) for name in ("max_speed", "max_acceleration")]
        body = np.append(pack_inertia(inertia), [limit or math.inf for limit in limits])
        viscous = as_friction("viscous_friction", self.viscous_friction, axial.size)
        coulomb = as_friction("coulomb_friction", self.coulomb_friction, axial.size)
        for name, value in (
            ("inertia", inertia), ("wheel_axes", axes), ("wheel_inertias", axial),
            ("time_step", require_positive("time_step", self.time_step)),
            ("max_speed", limits[0]), ("max_acceleration", limits[1]),
            ("viscous_friction", viscous), ("coulomb_friction", coulomb),
            ("wheels", read_only(axes * axial)), ("body", read_only(body)),
            ("friction", decelerations(viscous, coulomb, axial)),
        ):  # fmt: skip
            object.__setattr__(self, name, value)

    @property
    def n_wheels(self) -> int:
        """Number of wheels m."""
        return int(self.wheels.shape[1])

    def state_from_rate(
        self, attitude: ArrayLike, angular_velocity: ArrayLike, wheel_speed: ArrayLike
    ) -> WheelState:
        """Return the checked state of step 0 with a given rate of the bus.

        Parameters
        ----------
        attitude : (3, 3) array
            Rotation, body to inertial.
        angular_velocity : (3,) array
            Rate of the bus, body frame [rad/s].
        wheel_speed : (m,) array
            Relative to the bus [rad/s].

        Raises
        ------
        ShapeError, ParameterError
            If an argument is refused, or a wheel turns faster than its limit.
        """
        rotation = as_rotation("attitude", attitude)
        speed = self._as_speed(wheel_speed)
        rate = as_vector3("angular_velocity", angular_velocity)
        momentum = rotation @ (self.inertia @ rate + self.wheels @ speed)
        return WheelState(0, rotation, rate, speed, read_only(momentum), self._all_healthy())

    def state_from_momentum(
        self, attitude: ArrayLike, total_momentum: ArrayLike, wheel_speed: ArrayLike
    ) -> WheelState:
        """Return the checked state of step 0 with a given total momentum.

        As `state_from_rate`, with ``total_momentum`` (3,) in the inertial frame [N m s]; the bus
        then turns at J^-1 (R^T H - A Js nu).
        """
        rotation = as_rotation("attitude", attitude)
        speed = self._as_speed(wheel_speed)
        momentum = as_vector3("total_momentum", total_momentum)
        rate = self.body[9:18].reshape(3, 3) @ (rotation.T @ momentum - self.wheels @ speed)
        return WheelState(0, rotation, read_only(rate), speed, momentum, self._all_healthy())

    def step(self, state: WheelState, acceleration: Array, substeps: int = 1) -> WheelState:
        """Advance by ``substeps`` time steps, with the wheel accelerations held.

        Parameters
        ----------
        state : WheelState
            State at the start.
        acceleration : (m,) array
            Commanded acceleration of each wheel relative to the bus [rad/s^2]; what exceeds a
            limit is cut. A wheel that would exceed its speed limit within a step ends it there.
        substeps : int
            Number of time steps.

        Returns
        -------
        WheelState
            The state of the next control step.

        Raises
        ------
        ShapeError, ParameterError
            If an argument is refused, or the bus turns by about a quarter turn in one time step.
        """
        command = self._as_wheels("acceleration", acceleration, "rad/s^2")
        substeps = as_count("substeps", substeps)
        row = self._row(state)
        body, h = (self.body, self.wheels, self.friction), self.time_step
        done = advance(*body, h, row, 0, command[None], 0, substeps)
        if done != substeps:
            self._fail(state.angular_velocity, state.wheel_speed)
        parts = _parts(read_only(row[0]))
        return WheelState(state.step + 1, *parts, state.total_momentum, state.healthy)

    def simulate(
        self, state: WheelState, accelerations: ArrayLike, n_steps: int | None = None
    ) -> tuple[Array, Array, Array]:
        """Integrate a history of wheel accelerations, one time step each.

        Parameters
        ----------
        state : WheelState
            State at the start.
        accelerations : (n, m) or (m,) array
            Accelerations of each step, or those held throughout, relative to the bus [rad/s^2].
        n_steps : int, optional
            Number of steps; required where they are held, else n.

        Returns
        -------
        attitudes, angular_velocities, wheel_speeds : (n+1, 3, 3), (n+1, 3), (n+1, m) arrays
            States including the initial one, as n calls of `step` give them.

        Raises
        ------
        ShapeError, ParameterError
            As `step`.
        """
        commands = as_rows("accelerations", accelerations, self.n_wheels)
        n = len(commands) if n_steps is None else as_count("n_steps", n_steps)
        if len(commands) not in (1, n) or not np.isfinite(commands).all():
            raise ParameterError(
                f"accelerations: received an array of shape {commands.shape}; required "
                f"({n}, {self.n_wheels}) or ({self.n_wheels},) finite numbers [rad/s^2]; give one "
                "row for each step"
            )
        states = np.empty((n + 1, SPEED + self.n_wheels))
        states[0] = self._row(state)[0]
        body = self.body, self.wheels, self.friction
        done = propagate(*body, self.time_step, states, commands)
        if done != n:
            self._fail(*_parts(states[done])[1:])
        return _parts(states)

    def wheel_momentum(self, wheel_speed: Array) -> Vector3:
        """Return A Js nu (3,), momentum of the wheels relative to the bus, body frame [N m s]."""
        return np.asarray(self.wheels @ as_shaped("wheel_speed", wheel_speed, (self.n_wheels,)))

    def kinetic_energy(self, state: WheelState) -> float:
        """Return (omega . J omega)/2 + omega . A Js nu + (nu . Js nu)/2 [J]."""
        rate, speed = state.angular_velocity, state.wheel_speed
        own = 0.5 * self.inertia @ rate + self.wheel_momentum(speed)
        return float(rate @ own + 0.5 * self.wheel_inertias @ speed**2)

    def _all_healthy(self) -> NDArray[np.bool_]:
        return read_only_mask(np.ones(self.n_wheels, dtype=bool))

    def _as_wheels(self, name: str, value: ArrayLike, unit: str) -> Array:
        return as_finite(name, value, (self.n_wheels,), f"{self.n_wheels} numbers [{unit}]")

    def _as_speed(self, value: ArrayLike) -> Array:
        speed = self._as_wheels("wheel_speed", value, "rad/s")
        if self.max_speed and np.abs(speed).max() > self.max_speed:
            raise ParameterError(
                f"wheel_speed: received {listed(speed)} rad/s; required at most "
                f"{self.max_speed:g} rad/s in size; start within the limit, or raise it"
            )
        return speed

    def _row(self, state: WheelState) -> Array:
        row = np.empty((1, SPEED + self.n_wheels))
        row[0, :RATE] = as_shaped("state.attitude", state.attitude, (3, 3)).ravel()
        row[0, RATE:MOMENTUM] = as_shaped("state.angular_velocity", state.angular_velocity, (3,))
        row[0, MOMENTUM:SPEED] = as_shaped("state.total_momentum", state.total_momentum, (3,))
        row[0, SPEED:] = as_shaped("state.wheel_speed", state.wheel_speed, (self.n_wheels,))
        return row

    def _fail(self, rate: Vector3, speed: Array) -> None:
        raise ParameterError(
            f"state: received angular velocity {listed(rate)} rad/s and wheel speeds "
            f"{listed(speed)} rad/s with time step {self.time_step:g} s; required less than a "
            "quarter turn of the bus in each stage of a step; use a smaller time step"
        )


def _parts(rows: Array) -> tuple[Array, Array, Array]:
    """Split rows (..., 15 + m) into attitude, body rate and wheel speed."""
    attitude = rows[..., :RATE].reshape(*rows.shape[:-1], 3, 3)
    return attitude, rows[..., RATE:MOMENTUM], rows[..., SPEED:]
