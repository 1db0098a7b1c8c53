"""Problems of two wheels, and the roll-out written once more, shared by the tests."""

from __future__ import annotations

import numpy as np
from wheeled import AFRL_ACCELERATION, AFRL_INERTIA, AFRL_SPEED, AFRL_WHEEL, FULL_INERTIA

from spacecraft_gnc.vehicles.two_wheel.euler import from_euler_321
from spacecraft_gnc.vehicles.two_wheel.ocp.problem import MODELS, WheelOcp

EXACT = ("euler_321", "so3")
IDENTITY = np.eye(3)
REST = np.zeros(2)
SKEW = np.array([[0.9, 0.1], [0.2, -0.8], [0.3, 0.5]])  # axes of two wheels on no principal axis
YAW = np.array([0.0, 0.0, 0.25])
SLEW = np.array([0.5, 0.3, -0.4])  # [rad], the report's


def report(model="so3", horizon=30, **changed):
    """The report's spacecraft with wheels 1 and 2."""
    limits = {"max_speed": AFRL_SPEED, "max_acceleration": AFRL_ACCELERATION}
    wheels = AFRL_WHEEL * np.eye(3)[:, :2]
    return WheelOcp(AFRL_INERTIA, wheels, 10.0, horizon, model=model, **(limits | changed))


def skew(model="so3", horizon=24, **changed):
    """A small body with two wheels on no principal axis."""
    axes = SKEW / np.linalg.norm(SKEW, axis=0)
    limits = {"max_speed": 60.0, "max_acceleration": 30.0}
    return WheelOcp(FULL_INERTIA, 0.01 * axes, 0.5, horizon, model=model, **(limits | changed))


def near(seed, size=0.3):
    """A random attitude whose 3-2-1 angles are at most ``size`` [rad]; the third is half of it."""
    return from_euler_321(np.random.default_rng(seed).uniform(-size, size, 3) * [1.0, 1.0, 0.5])


def cost(ocp, accelerations, attitude, wheel_speed, reference=IDENTITY, drift=0.0):
    """Cost (4) and the terminal error (3,) of accelerations (N, 2), by another code.

    Complex accelerations give complex results: derivatives by the complex step.
    """
    e, total = None, 0.0
    speed = np.asarray(wheel_speed, dtype=accelerations.dtype)
    drift = np.broadcast_to(drift, (ocp.horizon + 1, 3))
    rotation = (ocp.frame.T @ reference.T @ attitude @ ocp.frame).astype(accelerations.dtype)
    body = -np.linalg.solve(ocp.inertia, ocp.wheels)
    angles = angles_of(rotation)
    for k, u in enumerate(accelerations):
        e = error(ocp.model, rotation, angles)
        total += ocp.attitude_weights @ e**2 + ocp.speed_weight * speed @ speed
        total += ocp.acceleration_weight * u @ u
        after = speed + ocp.time_step * u
        first = ocp.frame.T @ (body @ speed + drift[k])
        last = ocp.frame.T @ (body @ after + drift[k + 1])
        if ocp.model == "simplified":
            angles = angles + small_turn(ocp.time_step, angles, first, last)
        else:
            h = ocp.time_step
            turn = h / 2 * (first + last) + h**2 / 12 * np.cross(first, last)
            rotation = rotation @ rodrigues(turn)
        speed = after
    return total, error(ocp.model, rotation, angles), speed


def small_turn(h, angles, first, last):
    """phi' = w1, theta' = w2, psi' = w3 + w2 phi over a step, by Gauss's rule of degree 5."""
    nodes, shares = np.polynomial.legendre.leggauss(3)
    slope = (last - first) / h
    yaw = 0.0
    for node, share in zip(h * (nodes + 1) / 2, h * shares / 2, strict=True):
        roll = angles[0] + first[0] * node + slope[0] * node**2 / 2
        yaw = yaw + share * (first[1] + slope[1] * node) * roll
    return h / 2 * (first + last) + np.array([0.0, 0.0, 1.0]) * yaw


def rodrigues(turn):
    """exp(hat(turn)), for complex vectors too."""
    t = turn @ turn
    x, y, z = turn
    hat = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    if abs(t) < 1e-12:
        return np.eye(3) + hat + hat @ hat / 2
    a = np.sqrt(t)
    return np.eye(3) + np.sin(a) / a * hat + (1 - np.cos(a)) / t * hat @ hat


def angles_of(rotation):
    """Roll, pitch, yaw of a rotation that may be complex; roll and yaw within a quarter turn."""
    return np.array(
        [
            np.arctan(rotation[2, 1] / rotation[2, 2]),
            -np.arcsin(rotation[2, 0]),
            np.arctan(rotation[1, 0] / rotation[0, 0]),
        ]
    )


def error(model, rotation, angles):
    """Coordinates of the error in a model."""
    if model == "simplified":
        return angles
    if model == "euler_321":
        return angles_of(rotation)
    r = rotation
    q0 = np.sqrt(1 + r[0, 0] + r[1, 1] + r[2, 2]) / 2
    vee = np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])
    return vee / (2 * q0)


__all__ = ["EXACT", "MODELS", "REST", "SLEW", "YAW", "cost", "near", "report", "skew"]
