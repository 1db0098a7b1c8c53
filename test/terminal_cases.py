"""Terminal-set problems that the tests share, and the cost written out with matrices."""

from __future__ import annotations

import numpy as np
from ocp_cases import random_rotation, random_weight

from spacecraft_gnc import lie
from spacecraft_gnc.ocp import TerminalSetOcp
from spacecraft_gnc.ocp.terminal_level import Level

INERTIA = np.diag([10.0, 8.0, 8.0])
RATE = np.diag([3.0, 5.0, 5.0])  # J = tr(Jc) I / 2 - Jc
START = lie.exp(np.radians(57.0) * np.array([0.8, 0.6, 0.0]))
REST = np.zeros(3)


def paper(horizon=5, terminal_set="true", **changes):
    """The first example of Kalabic et al. 2014, section V-B."""
    values = {"stage_rate": RATE, "stage_torque": 1000.0, "max_torque": 0.02} | changes
    return TerminalSetOcp(INERTIA, 0.1, horizon, terminal_set=terminal_set, **values)


def flip(terminal_set="true"):
    """The second example."""
    return paper(10, terminal_set, stage_torque=1.0, max_torque=0.0)


def with_level(ocp, level):
    """The same problem with another terminal level."""
    return ocp._with(level=Level(level, "the test", 0, 0.0, 0.0))


def random_case(rng, largest_horizon=20, limits=(0.0, 0.02, 0.1, 0.5)):
    """A problem without terminal set, full in all matrices; attitude, momentum, reference."""
    a, b, c = rng.uniform(0.3, 1.0, 3)
    axes = random_rotation(rng)
    inertia = axes @ np.diag([b + c, a + c, a + b]) @ axes.T
    ocp = TerminalSetOcp(
        0.5 * (inertia + inertia.T), float(rng.choice([0.1, 0.2])),
        int(rng.integers(1, largest_horizon + 1)),
        random_weight(rng, -1, 1), random_weight(rng, -1, 1), random_weight(rng, 0, 2), 0.1,
        float(rng.choice(limits)), "false",
    )  # fmt: skip
    momentum = rng.normal(size=3)
    momentum *= rng.uniform(0.0, 0.3) / np.linalg.norm(momentum)
    return ocp, random_rotation(rng), momentum, random_rotation(rng)


def stage_cost(ocp, attitude, momentum, torque, reference):
    """lambda L of (25)."""
    h, identity = ocp.time_step, np.eye(3)
    C, F = reference.T @ attitude, attitude.T @ ocp.body.step(attitude, momentum, torque)[0]
    cost = np.trace(ocp.weights.stage_attitude @ (identity - C))
    cost += np.trace(ocp.stage_rate @ (identity - F)) / h**2
    return ocp.stage_cost_scale * (cost + 0.5 * torque @ ocp.weights.stage_torque @ torque)


def total_cost(ocp, torques, attitude, momentum, reference):
    """(24), for a flight that keeps within half a turn."""
    total, state = 0.0, (attitude, momentum)
    for torque in torques:
        total += stage_cost(ocp, *state, torque, reference)
        state = ocp.body.step(*state, torque)
    x = np.concatenate([lie.log(reference.T @ state[0]), state[1]])
    return total + 0.5 * x @ ocp.terminal.riccati @ x
