"""Kernels of the gyrostat's energy-momentum integrator; `dynamics` documents the equations.

``body`` (30,) is the packed inertia of `rigid_body.pack_inertia`, then the limits of wheel speed
and wheel acceleration (infinity: none). ``wheels`` (3, m) is A Js, the axes times the axial
inertias. ``friction`` (2, m) is c / Js [1/s] and tau / Js [rad/s^2] of each wheel, (2, 0) without
any. A row of ``states`` (n, 15 + m) holds R (9), omega (3), H (3) and the wheel speeds nu (m).
"""

from __future__ import annotations

import math

from spacecraft_gnc._inner_kernels import inner_kernel
from spacecraft_gnc._kernels import kernel
from spacecraft_gnc.dynamics._lgvi_kernels import (
    LAST_CORRECTION_SQUARED,
    MAX_NEWTON_STEPS,
    body_inertia,
    body_inverse_inertia,
    polished,
    rotate_rows,
)
from spacecraft_gnc.lie._mat3_kernels import (
    add,
    cross,
    dot,
    hat,
    hat_mat,
    inverse,
    load3,
    load9_flat,
    mat_add,
    mat_sub,
    mat_t_vec,
    mat_vec,
    scale,
    store3,
    store9_flat,
    sub,
)

RATE, MOMENTUM, SPEED = 9, 12, 15  # first columns of omega, H and nu in a row of states
# Suzuki's fourth-order composition of a symmetric second-order step; their sum is 1.
_OUTER = 1.0 / (4.0 - 4.0 ** (1.0 / 3.0))
STAGES = (_OUTER, _OUTER, 1.0 - 4.0 * _OUTER, _OUTER, _OUTER)
NODES = (_OUTER, 2.0 * _OUTER, 1.0 - 2.0 * _OUTER, 1.0 - _OUTER, 1.0)  # ends of the stages


@kernel
def midpoint_turn(body, h, Pi, g):
    """Solve n + f x n = h Pi / 2, n = J f + h g / 2, for the turn f; returns q0, q, ok.

    (q0, q) is the unit quaternion of cay(2 f): f is half of h times the mean rate.
    """
    J = body_inertia(body)
    p = scale(0.5 * h, Pi)
    s = scale(0.5 * h, g)
    f = mat_vec(body_inverse_inertia(body), sub(p, s))
    for _ in range(MAX_NEWTON_STEPS):
        n = add(mat_vec(J, f), s)
        e = sub(add(n, cross(f, n)), p)
        D_inverse, det = inverse(mat_sub(mat_add(J, hat_mat(f, J)), hat(n)))
        if det == 0.0:
            break
        d = scale(-1.0, mat_vec(D_inverse, e))
        f = add(f, d)
        if dot(d, d) <= LAST_CORRECTION_SQUARED:
            q0 = 1.0 / math.sqrt(1.0 + dot(f, f))
            return q0, scale(q0, f), dot(f, f) < 1.0  # less than a quarter turn
    return 1.0, f, False


@kernel
def wheel_momentum(wheels, states, row):
    """A Js nu of a row: momentum of the wheels relative to the bus, body frame."""
    g = (0.0, 0.0, 0.0)
    for i in range(wheels.shape[1]):
        g = add(g, scale(states[row, SPEED + i], (wheels[0, i], wheels[1, i], wheels[2, i])))
    return g


@kernel
def spin(body, h, states, row, accelerations, j):
    """Advance the wheel speeds of a row by one step, within the limits."""
    for i in range(accelerations.shape[1]):
        nu = states[row, SPEED + i]
        a = min(max(accelerations[j, i], -body[29]), body[29])
        top = max(body[28], abs(nu))  # a wheel that is too fast already gets no faster
        states[row, SPEED + i] = min(max(nu + h * a, -top), top)


@kernel
def coasted(t, nu, a, k, d):
    """Speed at time t of nu' = a - k nu - d sign(nu), which sticks at zero where |a| <= d."""
    if nu == 0.0 and abs(a) <= d:
        return 0.0
    sign = math.copysign(1.0, a if nu == 0.0 else nu)
    b = a - sign * d
    if sign * b < 0.0:
        stop = -nu / b
        if k > 0.0:
            stop = math.log1p(k * stop) / k
        if t >= stop:
            if abs(a) <= d:
                return 0.0
            t, nu, b = t - stop, 0.0, a + sign * d
    if k == 0.0:
        return nu + b * t
    return nu * math.exp(-k * t) - b * math.expm1(-k * t) / k


@inner_kernel
def rubbed(body, friction, states, row, accelerations, j, i, t):
    """Speed of wheel i of a row after time t with friction, within the limits."""
    nu = states[row, SPEED + i]
    a = min(max(accelerations[j, i], -body[29]), body[29])
    top = max(body[28], abs(nu))
    return min(max(coasted(t, nu, a, friction[0, i], friction[1, i]), -top), top)


@inner_kernel
def rubbed_momentum(body, wheels, friction, states, row, accelerations, j, t):
    """A Js nu of a row after time t with friction, within the limits."""
    g = (0.0, 0.0, 0.0)
    for i in range(wheels.shape[1]):
        nu = rubbed(body, friction, states, row, accelerations, j, i, t)
        g = add(g, scale(nu, (wheels[0, i], wheels[1, i], wheels[2, i])))
    return g


@kernel
def advance(body, wheels, friction, h, states, row, accelerations, j, n):
    """Advance a row in place by n steps of the held accelerations of row j; returns the steps made.

    H stays as it is. To compute it anew from omega, or to turn R^T H by itself, would let rounding
    add up: to 1e-11 of H over 1e6 steps.
    """
    R, H = load9_flat(states, row), load3(states, row, MOMENTUM)
    after = wheel_momentum(wheels, states, row)
    rubs = friction.shape[1] > 0
    for k in range(n):
        before, change, t = after, after, 0.0
        if not rubs:
            spin(body, h, states, row, accelerations, j)
            after = wheel_momentum(wheels, states, row)
            change = sub(after, before)
        for s in range(5):
            c = STAGES[s]
            if rubs:  # the mean over the stage is that of its ends
                start, t = after, NODES[s] * h
                after = rubbed_momentum(body, wheels, friction, states, row, accelerations, j, t)
                g = scale(0.5, add(start, after))
            else:
                g = add(before, scale(t + 0.5 * c, change))
                t += c
            q0, q, ok = midpoint_turn(body, c * h, mat_t_vec(R, H), g)
            if not ok:
                return k
            R = rotate_rows(q0, q, R)
        if rubs:
            for i in range(wheels.shape[1]):
                nu = rubbed(body, friction, states, row, accelerations, j, i, h)
                states[row, SPEED + i] = nu
        R = polished(R)
    omega = mat_vec(body_inverse_inertia(body), sub(mat_t_vec(R, H), after))
    store9_flat(states, row, R)
    store3(states, row, omega, RATE)
    return n


@kernel
def propagate(body, wheels, friction, h, states, accelerations):
    """Fill rows 1 on of ``states`` under accelerations (n, m), or (1, m) held; returns steps."""
    held = accelerations.shape[0] == 1
    steps = states.shape[0] - 1
    for k in range(steps):
        states[k + 1] = states[k]
        j = 0 if held else k
        if advance(body, wheels, friction, h, states, k + 1, accelerations, j, 1) != 1:
            return k
    return steps
