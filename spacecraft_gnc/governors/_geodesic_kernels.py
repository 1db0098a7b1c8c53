"""Kernels of geodesics on SO(3); `attitude` and `lie` document them."""

from __future__ import annotations

import math

from spacecraft_gnc._inner_kernels import inner_kernel
from spacecraft_gnc._kernels import kernel
from spacecraft_gnc.dynamics._lgvi_kernels import polished, rotation_of
from spacecraft_gnc.lie._mat3_kernels import (
    dot,
    load3,
    load9_rows,
    mat_mat,
    scale,
    store9_rows,
    vee_antisymmetric,
)


@inner_kernel
def exponential(x):
    """Rotation by |x| about x, by the half angle as in `lie.exp`."""
    half = 0.5 * math.sqrt(dot(x, x))
    sinc = math.sin(half) / half if half > 0.0 else 1.0
    return rotation_of(math.cos(half), scale(0.5 * sinc, x))


@inner_kernel
def logarithm(E):
    """Rotation vector of E, for angles well below half a turn."""
    v = vee_antisymmetric(E)
    sine = math.sqrt(dot(v, v))
    angle = math.atan2(sine, 0.5 * (E[0] + E[4] + E[8] - 1.0))
    return scale(angle / sine, v) if sine > 0.0 else v


@kernel
def along(axis, alpha, start, end):
    """Write (11), exp(alpha hat(x)) V, for x in row 0 of ``axis`` and V = ``start``, to ``end``."""
    turn = exponential(scale(alpha, load3(axis, 0)))
    store9_rows(end, 0, polished(mat_mat(turn, load9_rows(start, 0))))
