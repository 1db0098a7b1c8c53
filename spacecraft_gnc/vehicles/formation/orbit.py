"""Circular reference orbit: its size, mean motion and period."""

from __future__ import annotations

import math
from typing import Final

from spacecraft_gnc.plant.earth import EQUATORIAL_RADIUS, GRAVITATIONAL_PARAMETER

SAMPLES: Final = 50
"""Control periods in an orbit unless a scenario says otherwise (report, Table 1)."""


def mean_motion(altitude: float) -> float:
    """Return the mean motion [rad/s] of the circular orbit at an altitude [m]."""
    return math.sqrt(GRAVITATIONAL_PARAMETER / (EQUATORIAL_RADIUS + altitude) ** 3)


def orbital_period(altitude: float) -> float:
    """Return the period [s] of that orbit; 5492.29 s at 350 km."""
    return 2.0 * math.pi / mean_motion(altitude)


def samples_of_orbit(altitude: float, control_period: float) -> int:
    """Return the control periods [s] of that orbit, to the nearest whole number."""
    return round(orbital_period(altitude) / control_period)
