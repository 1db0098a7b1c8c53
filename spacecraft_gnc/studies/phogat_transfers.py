"""Transfers of Phogat et al., section 6: the paper's spacecraft, named and random transfers."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.ocp.transfer import AttitudeTransfer
from spacecraft_gnc.ocp.transfer.starts import STRAIGHT, Start, make_start
from spacecraft_gnc.types import ArrayLike

MAX_TORQUE, MAX_MOMENTUM = 20.0, 70.0  # [N m], [N m s]
BODY: Final = RigidBody(np.diag([800.0, 1200.0, 1000.0]), 0.1)
FIGURE_4_START: Final = (30.0, -10.0, 10.0)  # momentum [N m s]
_WAVE: Final = 30.0  # largest amplitude of a random start [N m s]


def paper_transfer(
    degrees: float, axis: ArrayLike, seconds: float, **changes: Any
) -> AttitudeTransfer:
    """Return a transfer of the paper's spacecraft, from rest to rest unless changed."""
    direction = np.asarray(axis, dtype=float)
    given: dict[str, Any] = {
        "body": BODY,
        "n_steps": round(seconds / BODY.time_step),
        "goal": lie.exp(math.radians(degrees) * direction / np.linalg.norm(direction)),
        "torque": MAX_TORQUE,
        "momentum": MAX_MOMENTUM,
    }
    return AttitudeTransfer(**{**given, **changes})


def figure_4(**changes: Any) -> AttitudeTransfer:
    """Return the transfer of figure 4."""
    changes = {"start_momentum": np.array(FIGURE_4_START)} | changes
    return paper_transfer(90.0, (1.0, 1.0, 1.0), 19.0, **changes)


def random_transfer(index: int, n_steps: int | None = None) -> AttitudeTransfer:
    """Return one of the paper's range: 10-90 deg about any axis in 5-30 s, rest to rest.

    Parameters
    ----------
    index : int
        Its seed.
    n_steps : int, optional
        None: as many as the paper's time step makes.
    """
    numbers = np.random.default_rng([16, index])
    axis = numbers.standard_normal(3)
    degrees, seconds = numbers.uniform(10.0, 90.0), numbers.uniform(5.0, 30.0)
    if n_steps is None:
        return paper_transfer(degrees, axis, seconds)
    body = RigidBody(BODY.inertia, seconds / n_steps)
    return paper_transfer(degrees, axis, seconds, body=body, n_steps=n_steps)


def random_start(problem: AttitudeTransfer, seed: int) -> Start:
    """Return a random start: the straight one and three sine waves of the momentum."""
    numbers = np.random.default_rng([17, seed])
    phase = np.pi * np.linspace(0.0, 1.0, problem.n_steps + 1)[:, None]
    momentum = make_start(problem, STRAIGHT).momentum.copy()
    for wave in range(1, 4):
        momentum += numbers.uniform(-_WAVE, _WAVE, 3) * np.sin(wave * phase)
    torque = np.diff(momentum, axis=0) / problem.body.time_step
    return Start(f"random {seed}", torque, momentum)
