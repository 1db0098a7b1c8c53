"""Kernels of pointing zones as a governor sees them; `reference_set` documents them.

A row of ``zones`` (n, 8): body axis, inertial axis, half-angle, +1 (exclusion) or -1 (inclusion).
"""

from __future__ import annotations

import math

from spacecraft_gnc._inner_kernels import inlined_inner_kernel
from spacecraft_gnc._kernels import kernel
from spacecraft_gnc.lie._mat3_kernels import dot, load3, load9_rows, mat_vec

ZONE_SIZE = 8


@inlined_inner_kernel
def zone_margin(zones, i, R):
    """Angle from attitude R to the border of zone i; negative where violated."""
    cosine = dot(load3(zones, i, 3), mat_vec(R, load3(zones, i)))
    if cosine > 1.0:  # by rounding; min and max would turn NaN into a number
        cosine = 1.0
    elif cosine < -1.0:
        cosine = -1.0
    return zones[i, 7] * (math.acos(cosine) - zones[i, 6])


@kernel
def nearest_zone(zones, attitude):
    """Smallest margin of an attitude (3, 3), and the zone that it belongs to (-1: no zones)."""
    R = load9_rows(attitude, 0)
    nearest, least = -1, math.inf
    for i in range(zones.shape[0]):
        margin = zone_margin(zones, i, R)
        if not margin >= least:  # NaN counts as the smallest
            nearest, least = i, margin
    return least, nearest
