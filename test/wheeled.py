"""Spacecraft with wheels, shared by the tests."""

from __future__ import annotations

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.vehicles.two_wheel.dynamics import Gyrostat

FULL_INERTIA = np.array([[1.0, 0.05, -0.1], [0.05, 0.8, 0.02], [-0.1, 0.02, 0.9]])  # [kg m^2]
ORTHOGONAL = np.eye(3)
PYRAMID = np.array([[1.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, -1.0], [1.0, 1.0, 1.0, 1.0]])
WHEEL_SETS = {
    "one": PYRAMID[:, :1],
    "two": np.eye(3)[:, :2],
    "three": ORTHOGONAL,
    "pyramid": PYRAMID,
}
ATTITUDE = lie.exp(np.array([0.3, 0.2, 0.1]))
RATE = np.array([0.3, -0.5, 0.8])  # [rad/s]
SPEEDS = np.array([100.0, -50.0, 30.0, 20.0])  # [rad/s]
AFRL_INERTIA = np.diag([430.0, 1210.0, 1300.0])  # [kg m^2], Kolmanovsky et al. 2016, 4.1
AFRL_WHEEL = 0.043  # [kg m^2]
AFRL_SPEED, AFRL_ACCELERATION = 100.0, 5.0  # [rad/s], [rad/s^2]


def small(axes, time_step, **limits):
    """A body of about 1 kg m^2 with strong wheels."""
    inertias = 0.01 * (1.0 + 0.1 * np.arange(axes.shape[1]))
    return Gyrostat(FULL_INERTIA, axes, inertias, time_step, **limits)


def afrl(axes, time_step=1.0):
    """The report's spacecraft, with its limits."""
    inertias = np.full(axes.shape[1], AFRL_WHEEL)
    return Gyrostat(AFRL_INERTIA, axes, inertias, time_step, AFRL_SPEED, AFRL_ACCELERATION)


def start(gyrostat, share=1.0):
    """A tumbling start, with a fraction of `SPEEDS`."""
    return gyrostat.state_from_rate(ATTITUDE, RATE, share * SPEEDS[: gyrostat.n_wheels])


def momentum(gyrostat, attitudes, rates, speeds):
    """R (J omega + sum of a_i Js_i nu_i), from the definition (n, 3) [N m s]."""
    axes = gyrostat.wheel_axes
    body = rates @ gyrostat.inertia
    for i, inertia in enumerate(gyrostat.wheel_inertias):
        body = body + inertia * speeds[:, i, None] * axes[:, i]
    return np.einsum("nij,nj->ni", attitudes, body)
