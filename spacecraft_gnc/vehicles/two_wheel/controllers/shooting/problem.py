"""Optimal control problem of the bus, from its inertia, its wheels and the wanted bandwidth.

About a principal axis the bus is the double integrator J a'' = T. The weights are those of the law
T = -J (w^2 eta + 2 w eta') in continuous time,

    h/2 (w^4 eta . J^2 eta + 2 w^2 Pi . Pi + T . T) / U^2,

critically damped at the bandwidth w of the feedback law, with U the limit of the torque; the
terminal weights are its cost to go without the product of attitude and momentum.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from spacecraft_gnc.ocp import AttitudeOcp, Weights
from spacecraft_gnc.types import Array, Matrix3
from spacecraft_gnc.vehicles.two_wheel.dynamics import Gyrostat

_PENALTY: Final = 1e6
"""Of the torque limit, in units of the torque's weight over the limit squared."""
_SMALLEST: Final = 1e-4
"""Eigenvalue of an attitude weight, in units of its largest."""


def torque_problem(
    gyrostat: Gyrostat, allocation: Array, bandwidth: float, horizon: int
) -> AttitudeOcp:
    """Return the problem of torques on the bus that the wheels can give.

    Parameters
    ----------
    gyrostat : Gyrostat
        As believed; its ``time_step`` is the control period.
    allocation : (m, 3) array
        Accelerations [rad/s^2] per torque [N m].
    bandwidth : float
        w [rad/s].
    horizon : int
        Steps.
    """
    w, h, inertia = bandwidth, gyrostat.time_step, gyrostat.inertia
    limit = torque_limit(gyrostat, allocation)
    wanted = float(np.linalg.eigvalsh(inertia)[-1]) * w * w
    unit = limit or wanted
    attitude, momentum = _weight_of(inertia @ inertia), _weight_of(np.eye(3))
    slope = math.hypot(1.0 / ((horizon - 1) * h), 2.0 * w)
    weights = Weights(
        stage_attitude=w**4 / unit**2 * attitude,
        stage_momentum=2.0 * w**2 / unit**2 * momentum,
        stage_torque=_weight_of(np.eye(3)) / unit**2,
        terminal_attitude=w**2 * slope / unit**2 * attitude,
        terminal_momentum=2.0 * w / unit**2 * momentum,
    )
    penalty = 0.5 * _PENALTY / unit**4 * max(1.0, 0.25 * wanted / unit)
    return AttitudeOcp(inertia, h, horizon, weights, limit, penalty, plant_step=0.0)


def torque_limit(gyrostat: Gyrostat, allocation: Array) -> float:
    """Return the size of torques [N m] that no wheel's acceleration limits; 0: all."""
    return gyrostat.max_acceleration / float(np.linalg.norm(allocation, axis=1).max())


def _weight_of(effort: Matrix3) -> Matrix3:
    """Return Q of the cost x . (tr(Q) I - Q) x = x . ``effort`` x, kept positive definite."""
    values, vectors = np.linalg.eigh(0.5 * np.trace(effort) * np.eye(3) - effort)
    kept = (vectors * np.maximum(values, _SMALLEST * values[-1])) @ vectors.T
    return np.asarray(0.5 * (kept + kept.T))
