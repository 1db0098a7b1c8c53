"""Kernels of the motion of craft about an oblate Earth; `two_body` documents the equations.

The frame N is inertial, z along the axis of the Earth. ``row`` (n + 1, 6) holds position R and
velocity V of the chief in row 0, then a row of each craft with the same less the chief's, d and w.
``earth`` (2,) holds mu and 1.5 J2 R_E^2.
"""

from __future__ import annotations

import math

import numpy as np

from spacecraft_gnc._inner_kernels import inner_kernel
from spacecraft_gnc._kernels import kernel
from spacecraft_gnc.lie._mat3_kernels import (
    add,
    cross,
    dot,
    load3,
    mat_t_vec,
    mat_vec,
    scale,
    store3,
    sub,
)

VELOCITY = 3  # first column of the velocity

# Kahan and Li, Math. Comp. 66 (1997): shares of the step in their composition of order 8 in 17
# stages, up to the middle one.
_HALF = (
    0.13020248308889008088,
    0.56116298177510838456,
    -0.38947496264484728641,
    0.15884190655515560090,
    -0.39590389413323757734,
    0.18453964097831570709,
    0.25837438768632204729,
    0.29501172360931029887,
)
SHARES = np.array([*_HALF, -0.60550853383003451170, *_HALF[::-1]])


@kernel
def oblateness(earth, r):
    """Acceleration by the second zonal harmonic."""
    x, y, z = r
    r2 = dot(r, r)
    f = -earth[0] * earth[1] / (r2 * r2 * math.sqrt(r2))
    s = 5.0 * z * z / r2
    return (f * (1.0 - s) * x, f * (1.0 - s) * y, f * (3.0 - s) * z)


@kernel
def attraction(earth, r):
    """Acceleration of the chief."""
    r2 = dot(r, r)
    return add(scale(-earth[0] / (r2 * math.sqrt(r2)), r), oblateness(earth, r))


@inner_kernel
def relative_attraction(earth, R, d):
    """Acceleration at R + d less that at R."""
    # With q = |R + d|^2 / |R|^2 - 1: -mu/|R|^3 ((R + d)(1 + q)^-1.5 - R), without cancellation.
    R2 = dot(R, R)
    q = dot(d, add(d, scale(2.0, R))) / R2
    f = math.expm1(-1.5 * math.log1p(q))
    kepler = scale(-earth[0] / (R2 * math.sqrt(R2)), add(scale(1.0 + f, d), scale(f, R)))
    return add(kepler, sub(oblateness(earth, add(R, d)), oblateness(earth, R)))


@kernel
def drift(row, h):
    """Move chief and craft on at constant velocity for a time h, in place."""
    for k in range(row.shape[0]):
        store3(row, k, add(load3(row, k), scale(h, load3(row, k, VELOCITY))))


@kernel
def kick(earth, row, h):
    """Change the velocities by the attraction over a time h, in place."""
    R = load3(row, 0)
    change = scale(h, attraction(earth, R))
    store3(row, 0, add(load3(row, 0, VELOCITY), change), VELOCITY)
    for k in range(1, row.shape[0]):
        change = scale(h, relative_attraction(earth, R, load3(row, k)))
        store3(row, k, add(load3(row, k, VELOCITY), change), VELOCITY)


@kernel
def propagate(earth, row, h, n):
    """Advance chief and craft in place by n steps of the composition of drift, kick and drift."""
    for _ in range(n):
        before = 0.0
        for share in SHARES:
            drift(row, 0.5 * h * (before + share))
            kick(earth, row, h * share)
            before = share
        drift(row, 0.5 * h * before)


@inner_kernel
def hill_frame(earth, R, V):
    """Axes of Hill's frame as rows of C_HN, and its angular velocity, in it."""
    momentum = cross(R, V)
    h, r = math.sqrt(dot(momentum, momentum)), math.sqrt(dot(R, R))
    x, z = scale(1.0 / r, R), scale(1.0 / h, momentum)
    pull = dot(z, oblateness(earth, R))  # which turns the orbital plane about the radius
    return (*x, *cross(z, x), *z), (r * pull / h, 0.0, h / (r * r))


@kernel
def to_inertial(earth, row):
    """Turn the craft's states from Hill's frame of the chief to N, in place."""
    C, omega = hill_frame(earth, load3(row, 0), load3(row, 0, VELOCITY))
    for k in range(1, row.shape[0]):
        rho = load3(row, k)
        w = add(load3(row, k, VELOCITY), cross(omega, rho))
        store3(row, k, mat_t_vec(C, rho))
        store3(row, k, mat_t_vec(C, w), VELOCITY)


@kernel
def to_hill(earth, row):
    """Turn the craft's states from N to Hill's frame of the chief, in place."""
    C, omega = hill_frame(earth, load3(row, 0), load3(row, 0, VELOCITY))
    for k in range(1, row.shape[0]):
        rho = mat_vec(C, load3(row, k))
        w = mat_vec(C, load3(row, k, VELOCITY))
        store3(row, k, rho)
        store3(row, k, sub(w, cross(omega, rho)), VELOCITY)
