"""Proof that a transfer is too short, from the bounds alone.

Over a step |Pi| changes by at most h |u| (F is a rotation), so that it is bounded from both ends
and by its box. With q the vector part of F, |q| = sin(angle / 2), the step's equation
2 q0 q + 2 J^-1 (q x J q) = h J^-1 Pi bounds the angle twice:

    sin(angle) <= h |Pi| / J_min,
    sin(angle) <= h |J^-1 Pi| + |q|^2 (J_max - J_min) / J_min.

Where these angles do not add up to that of the transfer, no torque within the bounds reaches it.
"""

from __future__ import annotations

import math
from itertools import product

import numpy as np

from spacecraft_gnc.ocp.transfer.problem import AttitudeTransfer


def is_too_short(problem: AttitudeTransfer, n_steps: int) -> bool:
    """Tell whether no torque within the bounds makes the transfer in ``n_steps`` steps."""
    h = problem.body.time_step
    sizes = np.linalg.norm(np.abs(problem.limits).reshape(2, 2, 3).max(axis=1), axis=1)
    first, last = (
        float(np.linalg.norm(pi)) for pi in (problem.start_momentum, problem.goal_momentum)
    )
    push = h * float(sizes[0])
    if abs(first - last) > n_steps * push * (1.0 + 1e-12):
        return True
    k = np.arange(n_steps)
    with np.errstate(invalid="ignore"):
        most = np.fmin(first + k * push, last + (n_steps - k) * push)
    most[0] = first
    most[1:] = np.fmin(most[1:], sizes[1])
    moments = np.linalg.eigvalsh(problem.body.inertia)
    sine = h * most / moments[0]
    if (sine >= 1.0).any():  # a step may turn by more than a quarter
        return False
    inner = sine[1:]  # the first momentum need not be within the box
    spread = (moments[-1] - moments[0]) / moments[0]
    inner[:] = np.fmin(inner, h * _fastest(problem) + np.sin(0.5 * np.arcsin(inner)) ** 2 * spread)
    return bool(np.arcsin(sine).sum() * (1.0 + 1e-12) < problem.angle)


def _fastest(problem: AttitudeTransfer) -> float:
    """Return the largest rate |J^-1 Pi| within the box of the momentum [rad/s]."""
    low, high = problem.limits[2:]
    if not np.isfinite(problem.limits[2:]).all():
        return math.inf
    corners = np.array(list(product(*zip(low, high, strict=True))))
    return float(np.linalg.norm(np.linalg.solve(problem.body.inertia, corners.T), axis=0).max())


def shortest_possible_steps(problem: AttitudeTransfer) -> int:
    """Return the fewest steps that `is_too_short` does not rule out; a lower bound."""
    low, high = 1, 2
    while is_too_short(problem, high):
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if is_too_short(problem, middle) else (low, middle)
    return high


def time_bound_text(problem: AttitudeTransfer) -> str:
    """Return the lower bound on the time, in words."""
    steps = shortest_possible_steps(problem)
    time = steps * problem.body.time_step
    return (
        f"{problem.duration:g} s are too short for {math.degrees(problem.angle):.6g} deg within "
        f"the bounds: no torque makes it in less than {time:g} s"
    )
