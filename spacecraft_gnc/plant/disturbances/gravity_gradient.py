"""Gravity-gradient torque on a body in a circular orbit."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from spacecraft_gnc.arguments import require_positive
from spacecraft_gnc.arrays import listed
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.parameters.parameter import WITHIN, Kind, NodeParameters, parameter
from spacecraft_gnc.types import (
    ArrayLike,
    Matrix3,
    Vector3,
    as_inertia,
    read_only,
    unit_vector,
)

PERPENDICULAR = 1e-6
"""Largest cosine between the orbit normal and the position: room for printed digits."""

if TYPE_CHECKING:
    from spacecraft_gnc.plant.disturbances.torques import Motion


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class GravityGradientParameters(NodeParameters):
    """What ``gravity_gradient`` reads of the section of the plant, beside the inertia."""

    orbit_rate: float = parameter(
        Kind.DOUBLE,
        0.0,
        "gravity_gradient: rate sqrt(mu / a^3) of the circular orbit",
        unit="rad/s",
        minimum=0.0,
        maximum=1e3,
        is_neutral=True,
    )
    orbit_normal: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [0.0, 0.0, 1.0],
        "gravity_gradient: direction of the orbital angular momentum, inertial frame",
        shape=(3,),
        nonzero=True,
        **WITHIN,
        is_neutral=True,
    )
    orbit_position: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [1.0, 0.0, 0.0],
        "gravity_gradient: direction from the attracting center to the spacecraft at time 0, "
        "inertial frame, perpendicular to orbit_normal",
        shape=(3,),
        nonzero=True,
        **WITHIN,
        is_neutral=True,
    )


class GravityGradient:
    """Torque 3 n^2 r x J r of a point mass on a rigid body in a circular orbit.

    r is the unit vector, in the body frame, from the attracting center to the spacecraft. It starts
    at ``orbit_position`` and turns about ``orbit_normal`` at the rate n = sqrt(mu / a^3) of an
    orbit of radius a.

    Parameters
    ----------
    inertia : (3, 3) array
        Inertia of the whole spacecraft, body frame [kg m^2].
    orbit_rate : float
        n [rad/s].
    orbit_normal : (3,) array
        Direction of the orbital angular momentum, inertial frame; need not be of length 1.
    orbit_position : (3,) array
        Direction of the position at time 0, inertial frame, perpendicular to the normal.

    Raises
    ------
    ShapeError, ParameterError
        If an argument is refused.

    Notes
    -----
    Assumptions: a circular Kepler orbit that the attitude does not change, a spherical attracting
    body, and a spacecraft small beside the radius; the next term is smaller by the ratio of its
    size to the radius. Signs of r do not matter.

    Source: Hughes, Spacecraft Attitude Dynamics, 1986, section 8.1.
    """

    def __init__(
        self,
        inertia: ArrayLike,
        orbit_rate: float,
        orbit_normal: ArrayLike = (0.0, 0.0, 1.0),
        orbit_position: ArrayLike = (1.0, 0.0, 0.0),
    ) -> None:
        self.inertia = as_inertia("inertia", inertia)
        self.orbit_rate = require_positive("orbit_rate", orbit_rate)
        self.orbit_normal = unit_vector("orbit_normal", orbit_normal)
        self.orbit_position = _in_plane(self.orbit_normal, orbit_position)
        self._quarter_later = read_only(np.cross(self.orbit_normal, self.orbit_position))

    @classmethod
    def from_parameters(
        cls, parameters: GravityGradientParameters, inertia: Matrix3
    ) -> GravityGradient:
        """Build it from ``orbit_rate``, ``orbit_normal`` and ``orbit_position``."""
        if parameters.orbit_rate == 0.0:
            raise ParameterError(
                "orbit_rate: received 0.0 rad/s; required a positive rate for the disturbance "
                "'gravity_gradient'; add it, such as 1.1e-3 for a low orbit of the Earth"
            )
        return cls(
            inertia, parameters.orbit_rate, parameters.orbit_normal, parameters.orbit_position
        )

    def position(self, time: float) -> Vector3:
        """Return the unit vector (3,) from the attracting center at ``time`` [s], inertial."""
        phase = self.orbit_rate * time
        position = math.cos(phase) * self.orbit_position + math.sin(phase) * self._quarter_later
        return np.asarray(position)

    def torque(self, motion: Motion) -> Vector3:
        """Return the torque (3,), body frame [N m]."""
        # Products and sums one by one: the linear algebra library differs between processors.
        r = (self.position(motion.time)[:, None] * motion.attitude).sum(axis=0)
        x, y, z = r.tolist()
        a, b, c = (self.inertia * r).sum(axis=1).tolist()
        curl = np.array([y * c - z * b, z * a - x * c, x * b - y * a])
        return np.asarray(3.0 * self.orbit_rate**2 * curl)


def _in_plane(normal: Vector3, orbit_position: ArrayLike) -> Vector3:
    """Return the direction of a position in the orbit's plane, freed of printed digits."""
    position = unit_vector("orbit_position", orbit_position)
    cosine = float(position @ normal)
    inside = position - cosine * normal
    length = float(np.linalg.norm(inside))
    if abs(cosine) > PERPENDICULAR:
        remedy = f"give {listed(inside / length)}" if length > PERPENDICULAR else "turn it"
        angle = math.degrees(math.atan2(length, cosine))
        raise ParameterError(
            f"orbit_position: received {listed(position)}, at {angle:.6g} deg to orbit_normal "
            f"{listed(normal)}; required a direction perpendicular to it; {remedy}"
        )
    return read_only(inside / length)
