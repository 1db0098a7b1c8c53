"""Motion of the craft of a formation over one control step: impulses, then free motion."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.arguments import require_kind, require_positive
from spacecraft_gnc.arrays import as_shaped
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.types import Array, read_only
from spacecraft_gnc.vehicles.formation import hill
from spacecraft_gnc.vehicles.formation.orbit import mean_motion
from spacecraft_gnc.vehicles.formation.two_body import TwoBodyMotion


@dataclass(frozen=True, slots=True, eq=False)
class FormationMotion:
    """Craft relative to a circular orbit, by Hill's equations or by the exact ones.

    Attributes
    ----------
    altitude : float
        Of the orbit, above the equatorial radius [m].
    control_period : float
        Time of one control step [s].
    exact : TwoBodyMotion, optional
        What is flown instead of Hill's equations; of the same orbit and control period.
    transition : (6, 6) array
        A of Hill's equations over one control step.

    Raises
    ------
    ParameterError
        If an argument is refused, or ``exact`` is of another orbit or control period.
    """

    altitude: float
    control_period: float
    exact: TwoBodyMotion | None = None
    transition: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        altitude = require_positive("altitude", self.altitude)
        period = require_positive("control_period", self.control_period)
        if self.exact is not None:
            exact = require_kind("exact", self.exact, TwoBodyMotion)
            if (exact.altitude, exact.control_period) != (altitude, period):
                raise ParameterError(
                    f"exact: received a motion at {exact.altitude!r} m, sampled every "
                    f"{exact.control_period!r} s; required {altitude!r} m and {period!r} s, the "
                    "altitude and the control period beside it; construct it with these"
                )
        matrix = hill.transition(mean_motion(altitude), period)
        values = {"altitude": altitude, "control_period": period, "transition": matrix}
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def advance(
        self,
        step: int,
        position: Array,
        velocity: Array,
        delta_v: Array,
        healthy: NDArray[np.bool_] | None = None,
    ) -> tuple[Array, Array]:
        """Return positions and velocities (n, 3), (n, 3) one control step later; read-only.

        Parameters
        ----------
        step : int
            Control step, on which the place of the chief over the Earth depends.
        position, velocity : (n, 3) arrays
            At its start, before the impulses, Hill's frame [m], [m/s].
        delta_v : (n, 3) array
            Changes of velocity at its start, Hill's frame [m/s].
        healthy : (n,) array of bool, optional
            Which craft make them; the others move freely.

        Raises
        ------
        ShapeError
            If an array has another shape.
        """
        shape = (len(position), 3)
        given = as_shaped("delta_v", delta_v, shape)
        if healthy is not None:
            given = np.where(healthy[:, None], given, 0.0)
        states = np.empty((shape[0], 6))
        states[:, :3] = as_shaped("position", position, shape)
        states[:, 3:] = as_shaped("velocity", velocity, shape) + given
        exact = self.exact
        after = states @ self.transition.T if exact is None else exact.advance(step, states)
        read_only(after)
        return after[:, :3], after[:, 3:]
