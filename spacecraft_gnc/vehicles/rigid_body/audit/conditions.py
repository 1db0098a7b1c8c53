"""Cost, costates and first-order conditions of plans, many at once, from the printed equations.

Nothing here is shared with the solvers: what a plan is worth is worked out by NumPy from its own
numbers and those of the problem. Arrays have the plans first, then the stages. The costates are
half the true ones, as the pairing of Gupta et al. (2015) makes them; docs/notation.md.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.lie import hat
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.audit import logarithm
from spacecraft_gnc.vehicles.rigid_body.audit.matrices import (
    exp,
    hats,
    times,
    trace_minus,
    transposed,
    vee,
)
from spacecraft_gnc.vehicles.rigid_body.audit.problem import Problem, nonstandard

ROUNDED: Final = 16.0 * 2.0**-52
"""Of an attitude, and relative to momentum and torque: what rounding leaves between two motions."""
ON_LIMIT: Final = 1e-12
"""Relative distance of |u|^2 from its bound within which the bound counts as touched."""


class Track(NamedTuple):
    """What plans (m) are weighed against."""

    attitudes: Array
    """(m, N+1, 3, 3)"""
    momenta: Array
    """(m, N+1, 3)"""
    controls: Array
    """(m, n)"""
    exists: NDArray[np.bool_]
    """(m,) whether the reference can move so."""


class Stages(NamedTuple):
    """Stages of plans: R, Pi, u and what the integrator makes of them, Facts 1 and 2."""

    R: Array
    """(m, N+1, 3, 3)"""
    Pi: Array
    """(m, N+1, 3)"""
    u: Array
    """(m, N, n) controls."""
    F: Array
    M: Array
    A: Array
    """(m, N, 3, 3) each: M = h F^T (tr(F Jd) I - F Jd)^-1, A = F^T + hat(F^T Pi) M."""
    p: Array
    """(m, N, 3) F^T Pi."""
    track: Track


class Limit(NamedTuple):
    """What (38) leaves of the stages, and the multiplier of the limit."""

    sigma: Array
    """(m, N)"""
    left: Array
    """(m, N, 3) in the units of lambda2."""
    radius_defect: Array
    """(m,) largest difference of |u| from what sigma says where the limit acts [N m]."""


def stages_of(problem: Problem, R: Array, Pi: Array, u: Array, track: Track, F: Array) -> Stages:
    """Return the stages of plans whose relative rotations F (m, N, 3, 3) are known."""
    h, Jd = problem.ocp.time_step, nonstandard(problem)
    Ft = transposed(F)
    with np.errstate(all="ignore"):
        M = h * Ft @ np.linalg.inv(trace_minus(F @ Jd))
    p = times(Ft, Pi[:, :-1])
    return Stages(R, Pi, u, F, M, Ft + hats(p) @ M, p, track)


def track_of(problem: Problem, references: Array, feedforward: Array) -> Track:
    """Return what plans track: a reference (m, 3, 3) that moves by its rate and torque (m, 2, 3).

    It moves as the integrator carries it on, with the torque held: docs/solver.md.
    """
    m, n, h = len(references), problem.ocp.horizon, problem.ocp.time_step
    R = np.repeat(references[:, None], n + 1, axis=1)
    Pi, u, exists = np.zeros((m, n + 1, 3)), np.zeros((m, 3)), np.ones(m, dtype=bool)
    if feedforward.any():
        Pi[:, 0], u = _start_of(problem, feedforward[:, 0], feedforward[:, 1])
        for k in range(n):
            F, there = problem.turns(Pi[:, k])
            exists &= there
            R[:, k + 1] = R[:, k] @ F
            Pi[:, k + 1] = times(transposed(F), Pi[:, k]) + h * u
    return Track(R, Pi, u @ problem.ocp.allocation.T, exists)


def _start_of(problem: Problem, omega: Array, tau: Array) -> tuple[Array, Array]:
    """Return momentum and torque (m, 3) of a body that the plant's integrator carries along."""
    h, J_omega = float(problem.ocp.plant_step or 0.0), omega @ np.asarray(problem.ocp.inertia).T
    gyroscopic = np.cross(omega, J_omega)
    Pi, needed = J_omega, gyroscopic
    if h > 0.0:
        F, Jd = exp(h * omega), nonstandard(problem)
        Pi = vee(F @ Jd - Jd @ transposed(F)) / h
        needed = (Pi - times(transposed(F), Pi)) / h
    beyond = tau - gyroscopic
    return np.asarray(Pi + 0.5 * h * beyond), np.asarray(needed + beyond)


def sweep(problem: Problem, s: Stages, share: Array) -> Array:
    """Sweep (34)-(37) backward: costates (m, N, 6); ``share`` (m,) multiplies the terminal P."""
    h, track = problem.ocp.time_step, s.track
    l1, l2 = _end(problem, s, share)
    found = np.empty((*s.u.shape[:2], 6))
    for k in range(s.u.shape[1] - 1, -1, -1):
        found[:, k, :3], found[:, k, 3:] = l1, l2
        if k > 0:
            g = _attitude_gradient(problem, s.R[:, k], track.attitudes[:, k])
            pushed = l1 - vee(problem.rate @ s.F[:, k])
            swept = times(transposed(s.A[:, k]), l2) + times(transposed(s.M[:, k]), pushed)
            off = s.Pi[:, k] - track.momenta[:, k]
            l1, l2 = times(s.F[:, k], l1) - g, swept - h * off @ problem.momentum
    return found


def limit_of(problem: Problem, s: Stages, lam: Array) -> Limit:
    """Return what (38), (W + sigma I) u = B^T lambda2 + W u_ref, leaves of each stage.

    sigma is fitted where the limit is touched, since |u|^2 - max_torque^2 of rounded numbers has
    lost it; how far |u| is from what that sigma says is kept apart.
    """
    fed = s.track.controls @ problem.control
    left = lam[..., 3:] @ problem.ocp.torque_map + fed[:, None] - s.u @ problem.control
    square, bound = np.sum(s.u * s.u, axis=2), problem.limit**2
    sigma, radius = np.zeros(square.shape), np.zeros(len(square))
    if bound > 0.0:
        touched = square >= bound * (1.0 - ON_LIMIT)
        along = np.maximum(0.0, np.sum(s.u * left, axis=2) / np.where(touched, square, 1.0))
        sigma = np.where(touched, along, 0.0)
        off = np.sqrt(square) - np.sqrt(bound + sigma / (2.0 * problem.penalty))
        counted = touched & ((sigma > 0.0) | (off > 0.0))
        radius = np.where(counted, np.abs(off), 0.0).max(axis=1)
    left = (left - sigma[..., None] * s.u) @ problem.back.T
    return Limit(sigma, left, radius)


def cost_of(problem: Problem, s: Stages, sigma: Array) -> Array:
    """Return the (m,) costs (27) + (28) + penalties, or (24)-(26) of Kalabic et al."""
    h, (ref, mom, con, _) = problem.ocp.time_step, s.track
    R, off = s.R[:, :-1], s.Pi[:, :-1] - mom[:, :-1]
    D = R - ref[:, :-1]
    state = _weighed(problem.attitude, D if problem.end is None else transposed(D))
    state += np.einsum("...i,ij,...j->...", off, problem.momentum, off)
    u = s.u - con[:, None]
    state += np.einsum("...i,ij,...j->...", u, problem.control, u)
    total = h * state + _weighed(problem.rate, s.F - np.eye(3))
    for v, d, cosine, sign, weight in _each(problem.zones):
        excess, _ = _excess(R, v, d, cosine, sign)
        total += h * weight * excess**2
    if math.isfinite(problem.penalty):
        total += h * problem.penalty * (sigma / (2.0 * problem.penalty)) ** 2
    return np.asarray(total.sum(axis=1) + _end_cost(problem, s))


def least_cost(problem: Problem, s: Stages) -> Array:
    """Return the (m,) costs of plans that are off what they track by nothing but rounding."""
    h, n = problem.ocp.time_step, s.u.shape[1]
    fastest = np.linalg.norm(s.Pi, axis=2).max(axis=1)
    strongest = np.linalg.norm(s.u, axis=2).max(axis=1) + fastest / h
    state = 4.5 * np.linalg.norm(problem.attitude)
    state = state + np.linalg.norm(problem.momentum) * fastest**2
    total = h * n * (state + np.linalg.norm(problem.control) * strongest**2)
    if problem.end is None:
        total += 4.5 * np.linalg.norm(problem.end_attitude)
        total += np.linalg.norm(problem.end_momentum) * fastest**2
    else:
        total += 0.5 * np.linalg.norm(problem.end) * (1.0 + fastest**2)
    return np.asarray(total * ROUNDED**2)


def made_of(problem: Problem, s: Stages, share: Array) -> tuple[Array, Array]:
    """Return (m, 2) sums of the sizes of what adds up to lambda1 and lambda2 over the horizon.

    The scale of their rounding, and of what counts as little of them: near the target, where
    lambda2 itself vanishes, it does not, for the entries of a rotation are of the order of one.
    And, of the zones that act, the sums of what their weights make of a cosine: that of its
    rounding.
    """
    steep1, steep2 = np.zeros(len(s.u)), np.zeros(len(s.u))
    h, track = problem.ocp.time_step, s.track
    fastest = np.linalg.norm(s.Pi, axis=2).max(axis=1)  # one near zero is a difference of larger
    for momenta in (track.momenta[:, 0], track.momenta[:, -1]):
        fastest = np.maximum(fastest, np.linalg.norm(momenta, axis=1))
    push = np.linalg.norm(problem.rate)
    if problem.end is None:
        a1 = np.full(len(s.u), np.linalg.norm(problem.end_attitude))
        a2 = np.linalg.norm(problem.end_momentum) * fastest
    else:
        P = [[np.linalg.norm(problem.end[i : i + 3, j : j + 3]) for j in (0, 3)] for i in (0, 3)]
        a1 = 0.5 * share * (P[0][0] + P[0][1] * fastest)
        a2 = 0.5 * share * (P[1][0] + P[1][1] * fastest)
    turn, spin = h * np.linalg.norm(problem.attitude), h * np.linalg.norm(problem.momentum)
    sizes = np.linalg.norm(s.M, axis=(2, 3))
    for k in range(s.u.shape[1] - 1, -1, -1):
        a2 = a2 + sizes[:, k] * (a1 + push) + spin * fastest
        steep2 = steep2 + sizes[:, k] * steep1
        a1 = a1 + turn
        for v, d, cosine, sign, weight in _each(problem.zones):
            excess, a = _excess(s.R[:, k], v, d, cosine, sign)
            pull = h * weight * np.linalg.norm(np.cross(v, a), axis=1)
            a1, steep1 = a1 + excess * pull, steep1 + np.where(excess > 0.0, pull, 0.0)
    fed = track.controls @ problem.control @ problem.back.T
    a2 = a2 + np.linalg.norm(fed, axis=1)
    return np.stack([a1, a2], axis=1), np.stack([steep1, steep2], axis=1)


def _end(problem: Problem, s: Stages, share: Array) -> tuple[Array, Array]:
    """Return the costates at the end of plans."""
    R_ref, Pi_ref = s.track.attitudes[:, -1], s.track.momenta[:, -1]
    if problem.end is None:
        l1 = vee(transposed(s.R[:, -1]) @ problem.end_attitude @ R_ref)
        return l1, -(s.Pi[:, -1] - Pi_ref) @ problem.end_momentum
    Z = logarithm.continuous(transposed(R_ref)[:, None] @ s.R)
    y = share[:, None] * (np.hstack([Z, s.Pi[:, -1]]) @ problem.end)
    return -0.5 * times(transposed(logarithm.derivative(Z)), y[:, :3]), -0.5 * y[:, 3:]


def _end_cost(problem: Problem, s: Stages) -> Array:
    R_ref, Pi_ref = s.track.attitudes[:, -1], s.track.momenta[:, -1]
    if problem.end is None:
        off = s.Pi[:, -1] - Pi_ref
        momentum = np.einsum("...i,ij,...j->...", off, problem.end_momentum, off)
        return np.asarray(_weighed(problem.end_attitude, s.R[:, -1] - R_ref) + momentum)
    Z = logarithm.continuous(transposed(R_ref)[:, None] @ s.R)
    x = np.hstack([Z, s.Pi[:, -1]])
    return np.asarray(0.5 * np.einsum("...i,ij,...j->...", x, problem.end, x))


def _attitude_gradient(problem: Problem, R: Array, R_ref: Array) -> Array:
    """Return g_R of the stage cost and zone penalties, so that (34) is F^T (lambda1 + g_R)."""
    h = problem.ocp.time_step
    g = -h * vee(transposed(R) @ weighed_reference(problem, R_ref))
    for v, d, cosine, sign, weight in _each(problem.zones):
        excess, a = _excess(R, v, d, cosine, sign)
        g += (h * weight * sign * excess)[:, None] * np.cross(v, a)
    return g


def attitude_curvature(problem: Problem, R: Array, R_ref: Array) -> Array:
    """Return G_R with delta g_R = G_R eta for R exp(hat(eta))."""
    h = problem.ocp.time_step
    G = 0.5 * h * trace_minus(transposed(R) @ weighed_reference(problem, R_ref))
    for v, d, cosine, sign, weight in _each(problem.zones):
        excess, a = _excess(R, v, d, cosine, sign)
        n = np.cross(v, a)
        bend = n[:, :, None] * n[:, None, :] + (sign * excess)[:, None, None] * (hat(v) @ hats(a))
        G += h * weight * np.where((excess > 0.0)[:, None, None], bend, 0.0)
    return G


def weighed_reference(problem: Problem, R_ref: Array) -> Array:
    """Return Q1 R_ref, or R_ref Q1 in the cost of Kalabic et al."""
    return problem.attitude @ R_ref if problem.end is None else R_ref @ problem.attitude


def _each(zones: Array) -> list[tuple[Array, Array, float, float, float]]:
    return [(row[:3], row[3:6], float(row[6]), float(row[7]), float(row[8])) for row in zones]


def _excess(R: Array, v: Array, d: Array, cosine: float, sign: float) -> tuple[Array, Array]:
    """Return max(0, H) of a zone at R (..., 3, 3), and R^T d."""
    a = d @ R
    return np.maximum(0.0, sign * (a @ v - cosine)), a


def _weighed(weight: Array, D: Array) -> Array:
    """Return |W^(1/2) D|_F^2 / 2 of (..., 3, 3) differences."""
    return np.asarray(0.5 * np.sum(D * (weight @ D), axis=(-2, -1)))
