"""Formations for the tests of the time shift governor: Hill's equations, gain and natural motion.

Computed here with SciPy alone, from the report's Table 1.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import expm, solve_discrete_are

from spacecraft_gnc.governors.time_shift import TimeShiftProblem

RATE = math.sqrt(3.986004418e14 / (6378137.0 + 350e3) ** 3)  # [rad/s] at 350 km
PERIOD = 2.0 * math.pi / RATE
PAIRS = ((0, 1), (0, 2), (1, 2))

PHASES, OFFSETS, AMPLITUDES = (45, 21, 10), (6103.0, 8325.0, 5036.0), (1.53, 1.705, 0.877)
"""Start of the figures: samples of the orbit, [m], share of the ellipse."""


def hill(t):
    """Return the map (6, 6) of Hill's equations over t [s]."""
    n = RATE
    a = np.zeros((6, 6))
    a[:3, 3:] = np.eye(3)
    a[3, 0], a[3, 4], a[4, 3], a[5, 2] = 3.0 * n * n, 2.0 * n, -2.0 * n, -n * n
    return expm(a * t)


def ellipse(p, semi_axis=1000.0):
    """Return the 2x1 ellipse (p, 6) with a radial semi-axis [m]."""
    angle = 2.0 * np.pi * np.arange(p) / p
    x, y, still = np.cos(angle), -2.0 * np.sin(angle), np.zeros(p)
    speeds = RATE * np.array([-np.sin(angle), -2.0 * np.cos(angle), still])
    return semi_axis * np.vstack([x, y, still, speeds]).T


def weights():
    """Return Q and R of the report in SI units; there they are for km and km/s."""
    return 1e-6 * np.diag([1.0, 1.0, 1.0, 1e-3, 1e-3, 1e-3]), 1e-6 * 1e8 * np.eye(3)


def lq_gain(a, q, r):
    """Return K of delta-v = K (x - x_d)."""
    b = a[:, 3:]
    cost = solve_discrete_are(a, b, q, r)
    return -np.linalg.solve(r + b.T @ cost @ b, b.T @ cost @ a)


def problem(p=50, phases=(16, 0, 33), **changes):
    """Return the report's problem, or one with other samples, craft or limits."""
    a = hill(PERIOD / p)
    q, r = weights()
    given = {
        "state_map": a, "gain": lq_gain(a, q, r), "natural": ellipse(p), "phases": phases,
        "max_delta_v": 1.0, "min_separation": 1000.0, "max_angle": math.radians(60.0),
        "state_weight": q, "control_weight": r,
    }  # fmt: skip
    return TimeShiftProblem(**(given | changes))


def start(natural, phases=PHASES, offsets=OFFSETS, amplitudes=AMPLITUDES):
    """Return the states (n, 6): a place on an ellipse of another size, moved along the track."""
    states = np.array([
        amplitude * natural[phase % len(natural)]
        for phase, amplitude in zip(phases, amplitudes, strict=True)
    ])  # fmt: skip
    states[:, 1] += offsets
    return states


def flown_limits(problem, flight, lost=()):
    """Return the largest delta-v, least separation and largest angle [rad] of a flight.

    Measured craft by craft from states, delta-v and shifts; no angle is asked of ``lost`` craft.
    """
    fast, near, wide = 0.0, math.inf, 0.0
    craft = range(problem.n_craft)
    for k, (states, pushes, shifts) in enumerate(
        zip(flight.states, flight.delta_v, flight.shifts, strict=True)
    ):
        told = [
            problem.natural[(k + problem.phases[i] + shifts[i]) % problem.samples] for i in craft
        ]
        fast = max(fast, *(float(np.linalg.norm(push)) for push in pushes))
        for i in craft:
            for j in range(i):
                apart, wanted = states[i, :3] - states[j, :3], told[i][:3] - told[j][:3]
                near = min(near, float(np.linalg.norm(apart)))
                if not {i, j} & set(lost):
                    wide = max(wide, angle_between(apart, wanted))
    return fast, near, wide


def angle_between(u, v):
    """Return the angle between two vectors, exact also near 0 and pi [rad]."""
    return math.atan2(float(np.linalg.norm(np.cross(u, v))), float(u @ v))
