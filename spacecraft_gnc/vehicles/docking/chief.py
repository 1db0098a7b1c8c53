"""Motion of the chief: constant rotation in Hill's frame, on a circular orbit."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.arguments import as_limit, require_positive
from spacecraft_gnc.plant.earth import GRAVITATIONAL_PARAMETER
from spacecraft_gnc.types import (
    Array,
    Matrix3,
    Vector3,
    as_rotation,
    as_vector3,
    read_only,
    unit_vector,
)

_NORMAL: Final = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True, eq=False)
class ChiefMotion:
    """A chief whose center of mass is on a circular orbit, rotating steadily in Hill's frame.

    Hill's frame: x outward, y along the track, z along the orbit normal; it turns at n about z.
    R_HC(t) = exp(w t hat(axis)) R_HC(0). The inertial angular velocity of the chief in its own
    frame is Omega = R_HC^T (w axis + n z), which changes unless the axis is the normal.

    Attributes
    ----------
    mean_motion : float
        n [rad/s].
    spin_rate : float
        w >= 0 [rad/s].
    spin_axis : (3,) array
        Axis in Hill's frame; normalized.
    initial_attitude : (3, 3) array
        R_HC(0), chief to Hill's frame.

    Raises
    ------
    ShapeError, ParameterError
        If the mean motion is not positive, the rate is negative, the axis zero, or the attitude no
        rotation.
    """

    mean_motion: float
    spin_rate: float
    spin_axis: Vector3 = field(default_factory=_NORMAL.copy)
    initial_attitude: Matrix3 = field(default_factory=lambda: np.eye(3))

    def __post_init__(self) -> None:
        for name, value in (
            ("mean_motion", require_positive("mean_motion", self.mean_motion)),
            ("spin_rate", as_limit("spin_rate", self.spin_rate)),
            ("spin_axis", unit_vector("spin_axis", self.spin_axis)),
            ("initial_attitude", as_rotation("initial_attitude", self.initial_attitude)),
        ):
            object.__setattr__(self, name, value)

    @property
    def period(self) -> float:
        """Time of one rotation in Hill's frame [s]; infinite at rest."""
        return 2.0 * math.pi / self.spin_rate if self.spin_rate else math.inf

    @property
    def orbit_radius(self) -> float:
        """Radius of the orbit around the Earth that has this mean motion [m]."""
        return float(np.cbrt(GRAVITATIONAL_PARAMETER / self.mean_motion**2))

    @property
    def packed(self) -> Array:
        """(18,) for `_motion_kernels`, with a port at the origin and linear gravity."""
        numbers = [self.mean_motion, 0.0, *self.spin_axis, self.spin_rate]
        return np.array([*numbers, *self.initial_attitude.ravel(), 0.0, 0.0, 0.0])

    def attitude(self, time: float) -> Matrix3:
        """Return R_HC (3, 3), chief to Hill's frame, at a time [s]."""
        turn = lie.exp(as_vector3("axis", self.spin_axis) * (self.spin_rate * time))
        return read_only(turn @ self.initial_attitude)

    def attitudes(self, times: Array) -> Array:
        """Return R_HC (n, 3, 3) at times (n,) [s]."""
        return turns(self.spin_axis, self.spin_rate * times) @ self.initial_attitude

    def angular_velocity(self, time: float) -> Vector3:
        """Return Omega (3,), inertial, chief frame [rad/s], at a time [s]."""
        rate = self.spin_rate * self.spin_axis + self.mean_motion * _NORMAL
        return read_only(self.attitude(time).T @ rate)

    def angular_acceleration(self, time: float) -> Vector3:
        """Return Omega' (3,), its derivative in the chief frame [rad/s^2], at a time [s].

        R_HC' = hat(w axis) R_HC gives Omega' = -R_HC^T (w axis x n z).
        """
        change = np.cross(self.spin_rate * self.spin_axis, self.mean_motion * _NORMAL)
        return read_only(-self.attitude(time).T @ change)


def turns(axis: Vector3, angles: Array) -> Array:
    """Return the rotations (n, 3, 3) about a unit axis by angles (n,) [rad], all at once."""
    turned, hat = angles[:, None, None], lie.hat(axis)
    return np.asarray(np.eye(3) + np.sin(turned) * hat + (1.0 - np.cos(turned)) * (hat @ hat))
