"""Kernels of the relative motion of a deputy; `dynamics` documents the equations.

The frame N stands still: it is Hill's frame as it is at the start of the control step, and s is the
time since then. ``deputy`` (26,) holds mass, J (9), J^-1 (9), port (3), half edges (3) and 1 where
the gravity gradient acts. ``chief`` (18,) holds n, the radius of the orbit (0: linear gravity), the
axis (3) and the rate w of the rotation in Hill's frame, R_HC at time zero (9) and the port (3).
``bounds`` (3,) holds tangent and slack of the pyramid, and x of the docking face.
"""

from __future__ import annotations

import math

from spacecraft_gnc._inner_kernels import inner_kernel
from spacecraft_gnc._kernels import kernel
from spacecraft_gnc.dynamics._lgvi_kernels import polished
from spacecraft_gnc.lie._mat3_kernels import (
    add,
    cross,
    dot,
    hat_mat,
    load3,
    load9_flat,
    mat_add,
    mat_mat,
    mat_scale,
    mat_t_mat,
    mat_t_vec,
    mat_vec,
    scale,
    store3,
    store9_flat,
    sub,
)

INERTIA, INVERSE, PORT, HALF, GRADIENT = 1, 10, 19, 22, 25  # first entries in ``deputy``
RADIUS, AXIS, RATE, START, CHIEF_PORT = 1, 2, 5, 6, 15  # first entries in ``chief``
VELOCITY, ATTITUDE, ANGULAR, ROW = 3, 6, 15, 18  # first columns of a row of states; its length


@inner_kernel
def vector(a, i):
    """Read three entries of a 1-D array."""
    return (a[i], a[i + 1], a[i + 2])


@inner_kernel
def matrix(a, i):
    """Read nine entries of a 1-D array."""
    return (a[i], a[i + 1], a[i + 2], a[i + 3], a[i + 4], a[i + 5], a[i + 6], a[i + 7], a[i + 8])


@kernel
def turn(q0, q, A):
    """Product of the rotation with the quaternion (q0, q) and a matrix."""
    B = hat_mat(q, A)
    return mat_add(A, mat_add(mat_scale(2.0 * q0, B), mat_scale(2.0, hat_mat(q, B))))


@inner_kernel
def turn_about(axis, angle, A):
    """Product of the rotation by an angle about a unit vector and a matrix."""
    return turn(math.cos(0.5 * angle), scale(math.sin(0.5 * angle), axis), A)


@inner_kernel
def exp_times(u, A):
    """Product exp(hat(u)) A."""
    angle = math.sqrt(dot(u, u))
    sinc = math.sin(0.5 * angle) / angle if angle > 0.0 else 0.5
    return turn(math.cos(0.5 * angle), scale(sinc, u), A)


@kernel
def chief_attitude(chief, t):
    """R_HC at time t."""
    return turn_about(vector(chief, AXIS), chief[RATE] * t, matrix(chief, START))


@kernel
def chief_rate(chief, R_HC):
    """Inertial angular velocity of the chief, chief frame."""
    w = chief[RATE]
    return mat_t_vec(R_HC, (w * chief[AXIS], w * chief[AXIS + 1], w * chief[AXIS + 2] + chief[0]))


@inner_kernel
def relative_gravity(chief, e, r):
    """Attraction at r beyond the chief, which is in the direction e, less that at the chief."""
    n, a = chief[0], chief[RADIUS]
    if a == 0.0:
        return scale(-n * n, sub(r, scale(3.0 * dot(e, r), e)))
    # With q = |e + d|^2 - 1, d = r/a: -n^2 a ((e + d)(1 + q)^-1.5 - e), without cancellation.
    d = scale(1.0 / a, r)
    q = dot(d, add(d, scale(2.0, e)))
    f = math.expm1(-1.5 * math.log1p(q))
    return scale(-n * n * a, add(scale(1.0 + f, d), scale(f, e)))


@inner_kernel
def applied_force(F, thrusters, R_CD):
    """Force F, chief frame, without its components in lost directions of the deputy frame."""
    f = mat_t_vec(R_CD, F)
    x, y, z = f
    if (x > 0.0 and not thrusters[0]) or (x < 0.0 and not thrusters[3]):
        x = 0.0
    if (y > 0.0 and not thrusters[1]) or (y < 0.0 and not thrusters[4]):
        y = 0.0
    if (z > 0.0 and not thrusters[2]) or (z < 0.0 and not thrusters[5]):
        z = 0.0
    # What the deputy frame takes away is subtracted: an intact force keeps its bits.
    return sub(F, mat_vec(R_CD, (f[0] - x, f[1] - y, f[2] - z)))


@inner_kernel
def slopes(deputy, chief, t, s, r, R, H, F, M, thrusters):
    """Acceleration, angular velocity and rate of the angular momentum in N at time t + s."""
    ns = chief[0] * s
    R_NC = turn_about((0.0, 0.0, 1.0), ns, chief_attitude(chief, t + s))
    e = (math.cos(ns), math.sin(ns), 0.0)
    force = mat_vec(R_NC, applied_force(F, thrusters, mat_t_mat(R_NC, R)))
    moment = mat_vec(R_NC, M)
    if deputy[GRADIENT] != 0.0:
        e_D = mat_t_vec(R, e)
        gradient = cross(e_D, mat_vec(matrix(deputy, INERTIA), e_D))
        moment = add(moment, scale(3.0 * chief[0] ** 2, mat_vec(R, gradient)))
    omega = mat_vec(R, mat_vec(matrix(deputy, INVERSE), mat_t_vec(R, H)))
    a = add(relative_gravity(chief, e, r), scale(1.0 / deputy[0], force))
    return a, omega, moment


@inner_kernel
def dexp_inverse(u, omega):
    """Rate of u at which exp(hat(u)) turns at omega, to third order in u."""
    c = cross(u, omega)
    return add(omega, add(scale(-0.5, c), scale(1.0 / 12.0, cross(u, c))))


@inner_kernel
def mean_slope(k1, k2, k3, k4):
    """Weighted mean of the four slopes."""
    return scale(1.0 / 6.0, add(add(k1, k4), scale(2.0, add(k2, k3))))


@inner_kernel
def substep(deputy, chief, t, s, h, r, v, R, H, F, M, thrusters):
    """One step of Runge, Kutta and Munthe-Kaas, fourth order, in N."""
    d = 0.5 * h
    a1, w1, m1 = slopes(deputy, chief, t, s, r, R, H, F, M, thrusters)
    r2, v2, H2, u = add(r, scale(d, v)), add(v, scale(d, a1)), add(H, scale(d, m1)), scale(d, w1)
    a2, w, m2 = slopes(deputy, chief, t, s + d, r2, exp_times(u, R), H2, F, M, thrusters)
    w2 = dexp_inverse(u, w)
    r3, v3, H3, u = add(r, scale(d, v2)), add(v, scale(d, a2)), add(H, scale(d, m2)), scale(d, w2)
    a3, w, m3 = slopes(deputy, chief, t, s + d, r3, exp_times(u, R), H3, F, M, thrusters)
    w3 = dexp_inverse(u, w)
    r4, v4, H4, u = add(r, scale(h, v3)), add(v, scale(h, a3)), add(H, scale(h, m3)), scale(h, w3)
    a4, w, m4 = slopes(deputy, chief, t, s + h, r4, exp_times(u, R), H4, F, M, thrusters)
    w4 = dexp_inverse(u, w)
    return (
        add(r, scale(h, mean_slope(v, v2, v3, v4))),
        add(v, scale(h, mean_slope(a1, a2, a3, a4))),
        polished(exp_times(scale(h, mean_slope(w1, w2, w3, w4)), R)),
        add(H, scale(h, mean_slope(m1, m2, m3, m4))),
    )


@kernel
def to_standing(deputy, chief, t, row, k):
    """Position and velocity of the deputy's center of mass, R_ND and H in N of a row, at s = 0."""
    R_HC = chief_attitude(chief, t)
    Omega = chief_rate(chief, R_HC)
    R_CD, w = load9_flat(row, k, ATTITUDE), load3(row, k, ANGULAR)
    arm = mat_vec(R_CD, vector(deputy, PORT))
    r = sub(add(vector(chief, CHIEF_PORT), load3(row, k)), arm)
    v = add(sub(load3(row, k, VELOCITY), cross(w, arm)), cross(Omega, r))
    R = mat_mat(R_HC, R_CD)
    rate = mat_t_vec(R_CD, add(Omega, w))
    H = mat_vec(R, mat_vec(matrix(deputy, INERTIA), rate))
    return mat_vec(R_HC, r), mat_vec(R_HC, v), R, H


@kernel
def to_chief(deputy, chief, t, s, r, v, R, H, row, k):
    """Write the row of a state in N at time t + s: the inverse of `to_standing`."""
    R_HC = chief_attitude(chief, t + s)
    R_NC = turn_about((0.0, 0.0, 1.0), chief[0] * s, R_HC)
    Omega = chief_rate(chief, R_HC)
    R_CD = mat_t_mat(R_NC, R)
    rate = mat_vec(matrix(deputy, INVERSE), mat_t_vec(R, H))
    w = sub(mat_vec(R_CD, rate), Omega)
    arm = mat_vec(R_CD, vector(deputy, PORT))
    r_C = mat_t_vec(R_NC, r)
    store3(row, k, sub(add(r_C, arm), vector(chief, CHIEF_PORT)))
    store3(row, k, add(sub(mat_t_vec(R_NC, v), cross(Omega, r_C)), cross(w, arm)), VELOCITY)
    store9_flat(row, k, R_CD, ATTITUDE)
    store3(row, k, w, ANGULAR)


@kernel
def margins(deputy, chief, bounds, row, k):
    """Line-of-sight margin and clearance of a row; `geometry` documents them."""
    width = bounds[0] * row[k, 0] + bounds[1]
    sight = width - max(abs(row[k, 1]), abs(row[k, 2]))
    x = row[k, 0] + chief[CHIEF_PORT] - bounds[2]
    for j in range(3):
        a = row[k, ATTITUDE + j]
        x -= a * deputy[PORT + j] + abs(a) * deputy[HALF + j]
    return sight, x


@kernel
def advance(deputy, chief, bounds, t, h, n, row, k, wrench, thrusters):
    """Advance a row in place by n steps from time t; least margins after each of them."""
    r, v, R, H = to_standing(deputy, chief, t, row, k)
    F, M = vector(wrench, 0), vector(wrench, 3)
    sight, clear = math.inf, math.inf
    for i in range(n):
        r, v, R, H = substep(deputy, chief, t, i * h, h, r, v, R, H, F, M, thrusters)
        to_chief(deputy, chief, t, (i + 1) * h, r, v, R, H, row, k)
        a, b = margins(deputy, chief, bounds, row, k)
        sight, clear = min(sight, a), min(clear, b)
    return sight, clear
