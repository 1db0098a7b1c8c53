"""Coupled translation and rotation of a deputy relative to a rotating chief.

With r and R_ND position of the deputy's center of mass relative to the chief's, and attitude of the
deputy, both in a frame N that stands still, and H its angular momentum there,

    m r'' = m g(r) + R_NC F,   R_ND' = hat(J_N^-1 H) R_ND,   H' = R_NC M,   J_N = R_ND J R_ND^T,

where g is the attraction at r less that at the chief, and force F and moment M are held in the
chief frame. With p and c the ports of deputy and chief, in their own frames, the published state is

    rho = R_NC^T r + R_CD p - c,   R_CD = R_NC^T R_ND,   R_CD' = hat(w) R_CD,

its rate rho' as seen in the chief frame, and w. N is Hill's frame at the start of each control
step; docs/docking.md derives the equations in the chief frame.

Integrator: Runge-Kutta-Munthe-Kaas of fourth order on SO(3) x R^9: R_ND stays a rotation, and H of
free motion stays as it is. Source: Munthe-Kaas, BIT 38 (1998).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.arguments import as_count, as_limit, require_kind, require_positive
from spacecraft_gnc.arrays import as_shaped
from spacecraft_gnc.types import Array, Matrix3, Vector3, as_inertia, read_only
from spacecraft_gnc.vehicles.docking._motion_kernels import (
    ANGULAR,
    ATTITUDE,
    CHIEF_PORT,
    RADIUS,
    ROW,
    VELOCITY,
    advance,
    margins,
)
from spacecraft_gnc.vehicles.docking.chief import ChiefMotion
from spacecraft_gnc.vehicles.docking.geometry import Cuboid

ALL_THRUSTERS: NDArray[np.bool_] = np.ones(6, dtype=bool)
ALL_THRUSTERS.setflags(write=False)


class Advanced(NamedTuple):
    """State at the end of a control step, and the least margins within it; arrays read-only."""

    port_offset: Vector3
    """(3,) deputy port minus chief port, chief frame [m]."""
    port_velocity: Vector3
    """(3,) its rate of change seen in the chief frame [m/s]."""
    attitude: Matrix3
    """(3, 3) rotation, deputy to chief."""
    angular_velocity: Vector3
    """(3,) of the deputy relative to the chief, chief frame [rad/s]."""
    line_of_sight_margin: float
    """Least after each integrator step [m]."""
    clearance: float
    """Likewise [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class RelativeMotion:
    """A deputy, the chief that it moves relative to, and the control period.

    Attributes
    ----------
    mass : float
        Of the deputy [kg].
    inertia : (3, 3) array
        Of the deputy about its center of mass, deputy frame [kg m^2].
    deputy, chief_body : Cuboid
        Sizes and ports.
    chief : ChiefMotion
        Motion of the chief.
    control_period : float
        Time for which force and moment are held [s].
    substeps : int
        Integrator steps in it.
    line_of_sight : tuple of float
        Tangent of the half angle of the pyramid, and its slack [m].
    two_body : bool
        Whether relative gravity is the exact difference of two attractions; else it is linear in r.
    gravity_gradient : bool
        Whether the moment 3 n^2 e x J e acts on the deputy, e the outward direction at the chief.

    Raises
    ------
    ShapeError, ParameterError
        If an argument is refused.
    """

    mass: float
    inertia: Matrix3
    deputy: Cuboid
    chief_body: Cuboid
    chief: ChiefMotion
    control_period: float
    substeps: int
    line_of_sight: tuple[float, float] = (math.tan(math.radians(30.0)), 0.05)
    two_body: bool = True
    gravity_gradient: bool = False
    packed: tuple[Array, Array, Array] = field(init=False, repr=False)
    """Deputy, chief and bounds for `_motion_kernels`."""

    def __post_init__(self) -> None:
        mass, inertia = require_positive("mass", self.mass), as_inertia("inertia", self.inertia)
        deputy = require_kind("deputy", self.deputy, Cuboid)
        body = require_kind("chief_body", self.chief_body, Cuboid)
        packed = require_kind("chief", self.chief, ChiefMotion).packed
        packed[RADIUS] = self.chief.orbit_radius if self.two_body else 0.0
        packed[CHIEF_PORT:] = body.port
        moments = [*inertia.ravel(), *np.linalg.inv(inertia).ravel()]
        parts = [mass, *moments, *deputy.port, *(0.5 * deputy.size), float(self.gravity_gradient)]
        sight = [as_limit("line_of_sight", bound) for bound in self.line_of_sight]
        bounds = np.array([*sight, 0.5 * body.size[0]])
        arrays = tuple(map(read_only, (np.array(parts), packed, bounds)))
        for name, value in (
            ("mass", mass), ("inertia", inertia), ("packed", arrays),
            ("control_period", require_positive("control_period", self.control_period)),
            ("substeps", as_count("substeps", self.substeps)),
        ):  # fmt: skip
            object.__setattr__(self, name, value)

    def advance(
        self,
        time: float,
        port_offset: Vector3,
        port_velocity: Vector3,
        attitude: Matrix3,
        angular_velocity: Vector3,
        force: Vector3,
        moment: Vector3,
        thrusters: NDArray[np.bool_] = ALL_THRUSTERS,
    ) -> Advanced:
        """Advance by one control period with force and moment held in the chief frame.

        Parameters
        ----------
        time : float
            Time at the start of the period, on which the attitude of the chief depends [s].
        port_offset, port_velocity, attitude, angular_velocity : arrays
            State, as in `Advanced`.
        force, moment : (3,) arrays
            About the deputy's center of mass, chief frame [N], [N m].
        thrusters : (6,) array of bool, optional
            Which of `state.DIRECTIONS` answer; where one does not, the force has no component in
            that direction of the deputy frame.

        Returns
        -------
        Advanced

        Raises
        ------
        ShapeError
            If an array has another shape.
        """
        row = _row(port_offset, port_velocity, attitude, angular_velocity)
        wrench = np.empty(6)
        wrench[:3] = as_shaped("force", force, (3,))
        wrench[3:] = as_shaped("moment", moment, (3,))
        h = self.control_period / self.substeps
        least = advance(*self.packed, time, h, self.substeps, row, 0, wrench, thrusters)
        read_only(row)
        return Advanced(
            row[0, :VELOCITY],
            row[0, VELOCITY:ATTITUDE],
            row[0, ATTITUDE:ANGULAR].reshape(3, 3),
            row[0, ANGULAR:],
            *least,
        )

    def margins(self, port_offset: Vector3, attitude: Matrix3) -> tuple[float, float]:
        """Return line-of-sight margin and clearance of one state [m]."""
        zero = np.zeros(3)
        sight, clear = margins(*self.packed, _row(port_offset, zero, attitude, zero), 0)
        return float(sight), float(clear)


def _row(offset: Vector3, velocity: Vector3, attitude: Matrix3, angular: Vector3) -> Array:
    row = np.empty((1, ROW))
    row[0, :VELOCITY] = as_shaped("port_offset", offset, (3,))
    row[0, VELOCITY:ATTITUDE] = as_shaped("port_velocity", velocity, (3,))
    row[0, ATTITUDE:ANGULAR] = as_shaped("attitude", attitude, (3, 3)).ravel()
    row[0, ANGULAR:] = as_shaped("angular_velocity", angular, (3,))
    return row
