"""Proof that a transfer is too short, from the bounds alone.

Over a step |Pi| changes by at most h |u| (F is a rotation), so that it is bounded from both ends
and by its box; and q . (2 q0 J q + 2 q x J q) = h q . Pi gives sin(angle of F) <= h |Pi| / J_min.
Where these angles do not add up to that of the transfer, no torque within the bounds reaches it.
"""

from __future__ import annotations

import math

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
    smallest = float(np.linalg.eigvalsh(problem.body.inertia)[0])
    sine = h * most / smallest
    if (sine >= 1.0).any():  # a step may turn by more than a quarter
        return False
    return bool(np.arcsin(sine).sum() * (1.0 + 1e-12) < problem.angle)


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
