"""State of a deputy relative to a rotating chief, its reference, and its thruster directions."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array, Matrix3, Vector3

DIRECTIONS: Final = ("+x", "+y", "+z", "-x", "-y", "-z")
"""Thruster directions of the deputy, in its own frame, in the order of ``thrusters``."""


class Navigation(NamedTuple):
    """What the controllers are told of the relative motion; the arrays are read-only."""

    port_offset: Vector3
    """(3,) deputy port minus chief port, chief frame [m]."""
    port_velocity: Vector3
    """(3,) its rate of change seen in the chief frame [m/s]."""
    attitude: Matrix3
    """(3, 3) rotation, deputy to chief."""
    angular_velocity: Vector3
    """(3,) of the deputy relative to the chief, chief frame [rad/s]."""


class RelativeState(NamedTuple):
    """State at the start of control step ``step``; the arrays are read-only."""

    step: int
    port_offset: Vector3
    """(3,) deputy port minus chief port, chief frame [m]."""
    port_velocity: Vector3
    """(3,) its rate of change seen in the chief frame [m/s]."""
    attitude: Matrix3
    """(3, 3) rotation, deputy to chief."""
    angular_velocity: Vector3
    """(3,) of the deputy relative to the chief, chief frame [rad/s]."""
    measured: Navigation
    """The same as navigation tells it, with its noise."""
    line_of_sight_margin: float
    """Least over the control step that ended here, positive inside the pyramid [m]."""
    clearance: float
    """Least over that step of a deputy vertex from the plane of the docking face [m]."""
    thrusters: NDArray[np.bool_]
    """(6,) whether each of `DIRECTIONS` answers in this step: the truth, which no law reads."""
    applied: Array
    """(6,) force [N] and moment [N m], chief frame, asked for over the step that ended here; zero
    at step 0."""


class RelativeReference(NamedTuple):
    """Port offset and relative attitude to track."""

    port_offset: Vector3
    """(3,) deputy port minus chief port, chief frame [m]."""
    rotation_vector: Vector3
    """(3,) rotation vector of the deputy relative to the chief [rad]."""

    @property
    def vector(self) -> Array:
        """(6,) both, as the linear laws read them."""
        return np.concatenate([self.port_offset, self.rotation_vector])

    @classmethod
    def of(cls, vector: Array) -> RelativeReference:
        """Return the reference of a vector (6,), which is copied."""
        both = np.array(vector, dtype=np.float64)
        both.setflags(write=False)
        return cls(both[:3], both[3:])
