"""Almost globally stabilizing attitude feedback for three or more wheels.

    E = V^T R,   hat(e) = w^2 (Jd E - E^T Jd),   Jd = tr(J)/2 I - J,
    T = -2 zeta w J omega - e,
    u = -(A Js)^+ (T + omega x (J omega + A Js nu)),

with attitude R, reference V, bandwidth w and damping ratio zeta. It is the law of Kalabic (8)-(10)
with A = w^2 Jd and K = 2 zeta w I, so that e = w^2 J eta near the target: every axis then obeys
eta'' + 2 zeta w eta' + w^2 eta = 0. The gyroscopic torque is canceled, so that the loop does not
depend on the momentum that the wheels hold. In continuous time, within the limits, the Lyapunov
function omega . J omega / 2 + w^2 tr(Jd (I - E)) falls by 2 zeta w omega . J omega, and E = I is
approached from all but a set of measure zero.

Source: Kalabic et al. 2014, (8)-(10); the gains and the allocation are ours.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike as AnyArray
from numpy.typing import NDArray

from spacecraft_gnc.arguments import require_kind, require_positive, shown
from spacecraft_gnc.errors import ShapeError
from spacecraft_gnc.governors.feedback import AttitudeFeedback
from spacecraft_gnc.types import Array, Matrix3, State, read_only
from spacecraft_gnc.vehicles.two_wheel.dynamics import Gyrostat
from spacecraft_gnc.vehicles.two_wheel.state import WheelState
from spacecraft_gnc.vehicles.two_wheel.wheels import read_only_mask, require_span


@dataclass(frozen=True, slots=True, eq=False)
class WheelFeedback:
    """Wheel accelerations that turn the bus to a reference attitude and stop it there.

    Attributes
    ----------
    gyrostat : Gyrostat
        What the law believes of the spacecraft; its ``max_acceleration`` limits the command.
    bandwidth : float
        Natural frequency w of the loop near the target [rad/s]; well below 1 over the period.
    damping_ratio : float
        zeta [-].
    healthy : (m,) bools, optional
        Wheels that take commands; the others are commanded nothing. None: all.

    Raises
    ------
    ShapeError, ParameterError
        If an argument is refused, or the axes of the healthy wheels do not span three dimensions.
    """

    gyrostat: Gyrostat
    bandwidth: float
    damping_ratio: float = 1.0
    healthy: AnyArray | None = None
    law: AttitudeFeedback = field(init=False, repr=False)
    allocation: Array = field(init=False, repr=False)
    """(m, 3) accelerations [rad/s^2] per body torque [N m]."""

    def __post_init__(self) -> None:
        gyrostat = require_kind("gyrostat", self.gyrostat, Gyrostat)
        bandwidth = require_positive("bandwidth", self.bandwidth)
        damping = require_positive("damping_ratio", self.damping_ratio)
        healthy = _as_healthy(self.healthy, gyrostat.n_wheels)
        require_span(gyrostat.wheel_axes[:, healthy])
        nonstandard = 0.5 * np.trace(gyrostat.inertia) * np.eye(3) - gyrostat.inertia
        law = AttitudeFeedback(
            bandwidth**2 * nonstandard, 2.0 * damping * bandwidth, gyrostat.inertia
        )
        allocation = np.zeros((gyrostat.n_wheels, 3))
        allocation[healthy] = -np.linalg.pinv(gyrostat.wheels[:, healthy])
        for name, value in (
            ("bandwidth", bandwidth), ("damping_ratio", damping), ("healthy", healthy),
            ("law", law), ("allocation", read_only(allocation)),
        ):  # fmt: skip
            object.__setattr__(self, name, value)

    def acceleration(self, state: WheelState, reference: Matrix3) -> Array:
        """Return the accelerations (m,) [rad/s^2] at ``state`` toward ``reference`` (3, 3).

        Where one exceeds the limit, all are scaled by one factor, which keeps the direction of the
        torque; the Lyapunov function may then grow for a while.
        """
        rate = state.angular_velocity
        own = self.gyrostat.inertia @ rate
        torque = self.law.torque(State(state.step, state.attitude, own), reference)
        total = own + self.gyrostat.wheel_momentum(state.wheel_speed)
        command = self.allocation @ (torque + np.cross(rate, total))
        limit, size = self.gyrostat.max_acceleration, float(np.abs(command).max())
        return np.asarray(command * (limit / size) if limit and size > limit else command)


def _as_healthy(value: AnyArray | None, n_wheels: int) -> NDArray[np.bool_]:
    """Return a read-only mask (m,)."""
    mask = np.ones(n_wheels, dtype=bool) if value is None else np.array(value)
    if mask.shape != (n_wheels,) or mask.dtype != bool:
        raise ShapeError(
            f"healthy: received {shown(value)}; required {n_wheels} bools; give one for each wheel"
        )
    return read_only_mask(mask)
