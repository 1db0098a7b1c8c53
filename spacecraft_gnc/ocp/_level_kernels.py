"""Kernels that look for the terminal level; `terminal_level` documents them."""

from __future__ import annotations

import math

from spacecraft_gnc._inner_kernels import inner_kernel
from spacecraft_gnc._kernels import kernel
from spacecraft_gnc.dynamics._lgvi_kernels import (
    relative_quaternion,
    rotate_back,
    rotation_of,
    solvable,
)
from spacecraft_gnc.lie._mat3_kernels import EYE, add, dot, load3, mat_mat, scale
from spacecraft_gnc.ocp._data_kernels import D_U, H
from spacecraft_gnc.ocp._terminal_kernels import (
    log_level,
    principal_log,
    rate_cost,
    stage_attitude_cost,
)

BISECTIONS = 40


@inner_kernel
def _exp(Z):
    """Rotation by the vector Z."""
    angle = math.sqrt(dot(Z, Z))
    half = 0.5 * angle
    return rotation_of(math.cos(half), scale(math.sin(half) / angle if angle > 0.0 else 0.5, Z))


@kernel
def excess(body, data, gain, Z, Pi):
    """F(X+) - F(X) + lambda L(X, kappa(X)), relative to F(X); infinite where (4) fails.

    -infinity beyond half a turn, where (Z, Pi) is no logarithm of a state.
    """
    if dot(Z, Z) > math.pi * math.pi:
        return -math.inf
    h = data[H]
    level = log_level(data, Z, Pi)
    q0, q, ok = relative_quaternion(body, h, Pi)
    if not ok or not level > 0.0:
        return math.inf
    T = add(_row_block(gain, 0, Z), _row_block(gain, 3, Pi))
    C, F = _exp(Z), rotation_of(q0, q)
    Pi_next = add(rotate_back(q0, q, Pi), scale(h, T))
    if not solvable(body, h, Pi_next):
        return math.inf
    effort = 0.0
    for i in range(3):
        g = D_U + 3 + 3 * i
        z = dot((data[g], data[g + 1], data[g + 2]), T)
        effort += data[D_U + i] * z * z
    cost = h * (stage_attitude_cost(data, EYE, C) + effort) + rate_cost(data, F)
    change = 0.5 * (log_level(data, principal_log(mat_mat(C, F)), Pi_next) - level)
    return (change + cost) / (0.5 * level)


@inner_kernel
def _row_block(gain, column, x):
    """Product of the 3 x 3 block of ``gain`` from a column with x."""
    a, b, c = load3(gain, 0, column), load3(gain, 1, column), load3(gain, 2, column)
    return (dot(a, x), dot(b, x), dot(c, x))


@inner_kernel
def _excess_at(body, data, gain, ray, radius):
    Z = scale(radius, (ray[0], ray[1], ray[2]))
    return excess(body, data, gain, Z, scale(radius, (ray[3], ray[4], ray[5])))


@inner_kernel
def first_violation(body, data, gain, ray, shells, limit):
    """Smallest radius along a ray at which `excess` is positive, below ``limit``; else ``limit``.

    Looked for on the shells first, by bisection then.
    """
    inside = 0.0
    for shell in shells:
        radius = min(shell, limit)
        if _excess_at(body, data, gain, ray, radius) > 0.0:
            outside = radius
            for _ in range(BISECTIONS):
                middle = 0.5 * (inside + outside)
                if _excess_at(body, data, gain, ray, middle) > 0.0:
                    outside = middle
                else:
                    inside = middle
            return outside
        if shell >= limit:
            break
        inside = radius
    return limit


@kernel
def first_violations(body, data, gain, rays, shells, limit, radii):
    """Fill ``radii`` (n,) with `first_violation` along each of the rays (n, 6)."""
    for i in range(rays.shape[0]):
        radii[i] = first_violation(body, data, gain, rays[i], shells, limit)


@kernel
def count_violations(body, data, gain, points):
    """How many of the points (n, 6) have a positive `excess`."""
    count = 0
    for i in range(points.shape[0]):
        if _excess_at(body, data, gain, points[i], 1.0) > 0.0:
            count += 1
    return count
