"""Kernels that predict the nominal loop; `feedback_loop` and `tail` document them.

``limits``: torque, momentum (infinity: none), level of W, momentum up to which (4) always holds.
``tail`` (7, 6): the set x . P x <= c with x = (log E, Pi); P in rows 0 to 5, then c (0: no tail is
asked for) and the largest angle where x . P x = 1.
"""

from __future__ import annotations

import math

from spacecraft_gnc._inner_kernels import inlined_inner_kernel, inner_kernel
from spacecraft_gnc._kernels import inlined_kernel, kernel
from spacecraft_gnc.dynamics._lgvi_kernels import held, solvable
from spacecraft_gnc.governors._feedback_kernels import feedback_torque, lyapunov
from spacecraft_gnc.governors._geodesic_kernels import logarithm
from spacecraft_gnc.governors._zone_kernels import zone_margin
from spacecraft_gnc.lie._mat3_kernels import dot, load3, load9_rows, mat_mat, mat_t_mat, transpose

TORQUE, MOMENTUM, SOLVABLE, INVARIANT, CONVERGENCE, FIRST_ZONE = range(6)
NOTHING = -1


@inlined_inner_kernel
def quadratic_form(tail, eta, Pi):
    """Value x . P x at x = (eta, Pi)."""
    x = (eta[0], eta[1], eta[2], Pi[0], Pi[1], Pi[2])
    value = 0.0
    for i in range(6):
        row = 0.0
        for j in range(6):
            row += tail[i, j] * x[j]
        value += x[i] * row
    return value


@inlined_inner_kernel
def cosine_of(tail, c):
    """Cosine of the largest angle of the tail set of level c, at most 1 rad."""
    return math.cos(tail[6, 1] * math.sqrt(c))


@inlined_inner_kernel
def in_tail(tail, c, cosine, E, Pi):
    """Whether (E, Pi) lies in the tail set of level c; cheap where E alone is too far."""
    if not 0.5 * (E[0] + E[4] + E[8] - 1.0) >= cosine:
        return False
    return quadratic_form(tail, logarithm(E), Pi) <= c


@inner_kernel
def tail_level(tail, zones, V, reserve):
    """Level of the tail set around reference V: no zone is nearer than the ellipsoid is wide."""
    c = tail[6, 0]
    for i in range(zones.shape[0]):
        room = max(0.0, zone_margin(zones, i, V) - reserve) / tail[6, 1]
        c = min(c, room * room)
    return c


@inlined_kernel
def nearest(limits, law, body, h, zones, C, Pi, E, T, reserve):
    """Constraint nearest to its bound at one step: relative slack, margin beyond reserve, index."""
    slack, margin, which = math.inf, math.inf, NOTHING
    if limits[0] < math.inf:
        m = limits[0] * (1.0 - reserve) - math.sqrt(dot(T, T))
        slack, margin, which = m / limits[0], m, TORQUE
    if limits[1] < math.inf:
        m = limits[1] * (1.0 - reserve) - math.sqrt(dot(Pi, Pi))
        if not m / limits[1] >= slack:
            slack, margin, which = m / limits[1], m, MOMENTUM
    m = limits[2] * (1.0 - reserve) - lyapunov(law, body, E, Pi)
    if not m / limits[2] >= slack:
        slack, margin, which = m / limits[2], m, INVARIANT
    for i in range(zones.shape[0]):
        m = zone_margin(zones, i, C) - reserve
        if not m / zones[i, 6] >= slack:
            slack, margin, which = m / zones[i, 6], m, FIRST_ZONE + i
    if not solvable(body, h, Pi):  # (4); else far from its bound in all ordinary flight
        m = limits[3] - math.sqrt(dot(Pi, Pi))
        slack, margin, which = -math.inf, m, SOLVABLE
    return slack, margin, which


@kernel
def predict(body, h, substeps, law, limits, zones, tail, states, horizon, reserve):
    """Fly ``states`` (7, 3), rows C, Pi, V, with V held: constraint, step or -1, margin.

    Names the constraint violated first, and where none is, the one that came nearest to its bound.
    """
    C, Pi, V = load9_rows(states, 0), load3(states, 3), load9_rows(states, 4)
    V_t = transpose(V)
    c = tail_level(tail, zones, V, reserve)
    cosine = cosine_of(tail, c)
    least, margin, which = math.inf, math.inf, NOTHING
    for t in range(horizon):
        E = mat_mat(V_t, C)
        T = feedback_torque(law, E, Pi)
        slack, m, i = nearest(limits, law, body, h, zones, C, Pi, E, T, reserve)
        if not slack >= 0.0:  # NaN violates
            return i, t, m
        if slack < least:
            least, margin, which = slack, m, i
        if c > 0.0 and in_tail(tail, c, cosine, E, Pi):
            return which, NOTHING, margin
        C, Pi, done = held(body, h, C, Pi, T, substeps)
        if done != substeps:
            return SOLVABLE, t, limits[3] - math.sqrt(dot(Pi, Pi))
    if tail[6, 0] > 0.0:
        E = mat_t_mat(V, C)
        eta = logarithm(E)
        return CONVERGENCE, horizon - 1, -math.sqrt(dot(eta, eta))
    return which, NOTHING, margin
