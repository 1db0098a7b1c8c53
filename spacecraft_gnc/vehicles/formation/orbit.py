"""Circular reference orbit: its size, mean motion and period."""

from __future__ import annotations

import math
from typing import Final

GRAVITATIONAL_PARAMETER: Final = 3.986004418e14
"""Of the Earth [m^3/s^2] (WGS 84)."""
EQUATORIAL_RADIUS: Final = 6378137.0
"""Of the Earth [m] (WGS 84)."""
J2: Final = 1.08262668e-3
"""Second zonal harmonic of the Earth, unnormalized."""
SAMPLES: Final = 50
"""Control periods in an orbit unless a scenario says otherwise (report, Table 1)."""


def mean_motion(altitude: float) -> float:
    """Return the mean motion [rad/s] of the circular orbit at an altitude [m]."""
    return math.sqrt(GRAVITATIONAL_PARAMETER / (EQUATORIAL_RADIUS + altitude) ** 3)


def orbital_period(altitude: float) -> float:
    """Return the period [s] of that orbit; 5492.29 s at 350 km."""
    return 2.0 * math.pi / mean_motion(altitude)
