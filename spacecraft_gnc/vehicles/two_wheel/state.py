"""State of a spacecraft with reaction wheels."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array, Matrix3, Vector3


class WheelState(NamedTuple):
    """State at the start of control step ``step``; the arrays are read-only.

    It holds the total momentum beside the rate that follows from it: the momentum is conserved to
    the last bit, whereas one recomputed from the rate in each step would drift with the rounding.
    """

    step: int
    attitude: Matrix3
    """(3, 3) rotation, body to inertial."""
    angular_velocity: Vector3
    """(3,) rate of the bus relative to the inertial frame, body frame [rad/s]."""
    wheel_speed: Array
    """(m,) spin of each wheel about its axis relative to the bus [rad/s]."""
    total_momentum: Vector3
    """(3,) of bus and wheels about the center of mass, inertial frame [N m s]."""
    healthy: NDArray[np.bool_]
    """(m,) whether each wheel answers its command in this step: the truth, which no law reads."""
    applied: Array | None = None
    """(m,) accelerations that the wheels were told over the step before, whether they answered or
    not [rad/s^2]; None: not known."""
