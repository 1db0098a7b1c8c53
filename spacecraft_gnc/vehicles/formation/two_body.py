"""Motion of craft about an oblate Earth, relative to a chief that feels the same gravity.

In an inertial frame, z along the axis of the Earth, chief and craft move by

    r'' = -mu r / |r|^3 + g(r),   s = 5 z^2 / |r|^2,
    g(r) = -(3/2) J2 mu R_E^2 / |r|^5 ((1 - s) x, (1 - s) y, (3 - s) z).

The chief is a point, not one of the craft. It starts with the state of the circular reference
orbit, and then feels J2 itself. Hill's frame is attached to it, x along its radius and z along its
momentary angular momentum h; it turns at (r g_z / h, 0, h / r^2), where g_z is the component of g
along its own z axis. So the craft feel, in this frame, only how J2 differs between two places: over
an orbit at 350 km Hill's equations miss the 2x1 km ellipse by 10 to 93 m, whatever inclination and
start. Against a chief that stayed on the circular orbit, all craft together would fall away by 9 to
154 km (docs/formation.md).

Integrator: symmetric composition of drift, kick and drift, order 8. It is symplectic, and keeps the
angular momentum about the axis of the Earth. It integrates differences to the chief, for which the
difference of attractions is formed without cancellation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from spacecraft_gnc.arguments import as_count, as_limit, as_real, require_positive
from spacecraft_gnc.arrays import as_shaped
from spacecraft_gnc.plant.earth import EQUATORIAL_RADIUS, GRAVITATIONAL_PARAMETER, J2
from spacecraft_gnc.types import Array, read_only
from spacecraft_gnc.vehicles.formation import _motion_kernels as kernels
from spacecraft_gnc.vehicles.formation.orbit import mean_motion, orbital_period

_STEPS_OF_ORBIT: Final = 100  # integrator steps, at least: the errors are then of rounding


@dataclass(frozen=True, slots=True, eq=False)
class TwoBodyMotion:
    """Chief and craft about an oblate Earth, sampled once in each control period.

    Attributes
    ----------
    altitude : float
        Of the orbit on which the chief starts, above the equatorial radius [m].
    control_period : float
        Time between two samples [s].
    inclination : float, optional
        Of that orbit, 0 to pi [rad].
    argument_of_latitude : float, optional
        Of the chief at the start, from the ascending node [rad].
    j2 : float, optional
        Second zonal harmonic; 0: the attraction of a point.

    Raises
    ------
    ParameterError
        If an argument is refused.
    """

    altitude: float
    control_period: float
    inclination: float = 0.0
    argument_of_latitude: float = 0.0
    j2: float = J2
    _earth: Array = field(init=False, repr=False)
    _steps: int = field(init=False, repr=False)
    _chief: list[Array] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        altitude = require_positive("altitude", self.altitude)
        period = require_positive("control_period", self.control_period)
        steps = math.ceil(_STEPS_OF_ORBIT * period / orbital_period(altitude))
        j2 = as_limit("j2", self.j2)
        for name, value in (
            ("altitude", altitude),
            ("control_period", period),
            ("inclination", _angle("inclination", self.inclination, 0.0, math.pi)),
            ("argument_of_latitude", _angle("argument_of_latitude", self.argument_of_latitude)),
            ("j2", j2),
            ("_earth", np.array([GRAVITATIONAL_PARAMETER, 1.5 * j2 * EQUATORIAL_RADIUS**2])),
            ("_steps", as_count("control_period / 0.01 orbits", steps)),
        ):
            object.__setattr__(self, name, value)
        object.__setattr__(self, "_chief", [read_only(self._start())])

    def chief(self, step: int) -> Array:
        """Return position and velocity of the chief (6,) at a control step, inertial [m], [m/s].

        The x axis is along the ascending node of the start, z along the axis of the Earth.
        """
        while len(self._chief) <= step:  # the earlier steps are kept
            self._advance(len(self._chief) - 1, np.empty((0, 6)))
        return self._chief[step]

    def to_inertial(self, step: int, states: Array) -> Array:
        """Return states (n, 6) of craft less that of the chief, in the inertial axes [m], [m/s].

        ``states`` (n, 6): in Hill's frame at a control step.
        """
        row = self._row(step, states)
        kernels.to_inertial(self._earth, row)
        return row[1:]

    def to_hill(self, step: int, states: Array) -> Array:
        """Return states (n, 6) in Hill's frame at a control step: the inverse of `to_inertial`."""
        row = self._row(step, states)
        kernels.to_hill(self._earth, row)
        return row[1:]

    def advance(self, step: int, states: Array) -> Array:
        """Return states (n, 6) in Hill's frame one control period later.

        Parameters
        ----------
        step : int
            Control step from which on.
        states : (n, 6) array
            At its start, after the impulses, Hill's frame [m], [m/s].

        Raises
        ------
        ShapeError
            If the array has another shape.
        """
        self.chief(step)
        return self._advance(step, states)

    def _advance(self, step: int, states: Array) -> Array:
        """Do so, and keep where the chief then is."""
        row = self._row(step, states)
        kernels.to_inertial(self._earth, row)
        kernels.propagate(self._earth, row, self.control_period / self._steps, self._steps)
        if len(self._chief) == step + 1:
            self._chief.append(read_only(row[0].copy()))
        kernels.to_hill(self._earth, row)
        return row[1:]

    def _row(self, step: int, states: Array) -> Array:
        """Return a copy (n + 1, 6) of the chief's state and those of the craft."""
        row = np.empty((1 + len(states), 6))
        row[0] = self.chief(step)
        row[1:] = as_shaped("states", states, (len(states), 6))
        return row

    def _start(self) -> Array:
        """Return the chief's state (6,) at the start."""
        u, i = self.argument_of_latitude, self.inclination
        radius = EQUATORIAL_RADIUS + self.altitude
        speed = radius * mean_motion(self.altitude)
        outward = [math.cos(u), math.sin(u) * math.cos(i), math.sin(u) * math.sin(i)]
        forward = [-math.sin(u), math.cos(u) * math.cos(i), math.cos(u) * math.sin(i)]
        return np.concatenate([radius * np.array(outward), speed * np.array(forward)])


def _angle(name: str, value: float, least: float = -math.inf, most: float = math.inf) -> float:
    need = "an angle [rad]" + (f", {least:g} to {most:.6g}" if math.isfinite(most) else "")
    return as_real(name, value, lambda x: least <= x <= most, need, "convert degrees to radians")
