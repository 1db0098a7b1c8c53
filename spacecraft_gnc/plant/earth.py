"""The Earth, as the vehicles on an orbit share it."""

from __future__ import annotations

from typing import Final

GRAVITATIONAL_PARAMETER: Final = 3.986004418e14
"""[m^3/s^2] (IERS Conventions 2010, WGS 84)."""
EQUATORIAL_RADIUS: Final = 6378137.0
"""[m] (WGS 84)."""
J2: Final = 1.08262668e-3
"""Second zonal harmonic, unnormalized (EGM 96)."""
