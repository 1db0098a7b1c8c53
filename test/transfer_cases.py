"""Attitude transfers shared by tests and benchmarks: the paper's spacecraft, named and random."""

from __future__ import annotations

import math

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.ocp.transfer import AttitudeTransfer

BODY = RigidBody(np.diag([800.0, 1200.0, 1000.0]), 0.1)


def paper_transfer(degrees, axis, seconds, **changes):
    """Transfer of Phogat et al., section 6."""
    axis = np.asarray(axis, dtype=float)
    axis = axis / np.linalg.norm(axis)
    return AttitudeTransfer(
        **{
            "body": BODY,
            "n_steps": round(seconds / BODY.time_step),
            "goal": lie.exp(math.radians(degrees) * axis),
            "torque": 20.0,
            "momentum": 70.0,
        }
        | changes
    )


def figure_4(**changes):
    """The transfer of figure 4."""
    changes = {"start_momentum": np.array([30.0, -10.0, 10.0])} | changes
    return paper_transfer(90.0, (1.0, 1.0, 1.0), 19.0, **changes)


def random_transfer(index, n_steps=None):
    """Transfer of the paper's range, 10-90 deg about any axis in 5-30 s, at rest at both ends."""
    numbers = np.random.default_rng([16, index])
    axis = numbers.standard_normal(3)
    degrees, seconds = numbers.uniform(10.0, 90.0), numbers.uniform(5.0, 30.0)
    if n_steps is None:
        return paper_transfer(degrees, axis, seconds)
    body = RigidBody(BODY.inertia, seconds / n_steps)
    return paper_transfer(degrees, axis, seconds, body=body, n_steps=n_steps)
