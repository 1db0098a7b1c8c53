"""Plans to start a solve from: loops about the uncontrolled axis, and random ones."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import numpy as np

from spacecraft_gnc.plant.random_numbers import generator
from spacecraft_gnc.types import Array, Vector3
from spacecraft_gnc.vehicles.two_wheel.ocp._starts_kernels import keep_limits
from spacecraft_gnc.vehicles.two_wheel.ocp.problem import WheelOcp

_STREAM: Final = "two_wheel.restart"


def can_stop(ocp: WheelOcp, wheel_speed: Array) -> bool:
    """Tell whether speeds (2,) can be within their limit a step on, and zero in the horizon."""
    change = ocp.time_step * (ocp.max_acceleration or math.inf)
    most = min(ocp.horizon * change, ocp.max_speed + change)
    return bool(np.abs(wheel_speed).max() <= most)


def within(ocp: WheelOcp, wanted: Array, wheel_speed: Array) -> Array:
    """Return speeds (N+1, 2) near ``wanted`` from ``wheel_speed`` to rest, within the limits.

    Wheels that cannot stop within the horizon end as slow as they can be.
    """
    change = ocp.time_step * (ocp.max_acceleration or math.inf)
    speeds = np.empty((ocp.horizon + 1, 2))
    speeds[0] = wheel_speed
    keep_limits(np.asarray(wanted, dtype=np.float64), ocp.max_speed, change, speeds)
    return speeds


def loops(ocp: WheelOcp, error: Vector3, wheel_speed: Array) -> Iterator[Array]:
    """Yield speeds (N+1, 2): straight ones, then four loops that turn about the third axis.

    ``error`` (3,): angles from the reference in the prediction frame [rad]. To first order the
    third angle changes by the area that the first two enclose.
    """
    span = ocp.horizon * ocp.time_step
    phase = 2.0 * math.pi * np.arange(ocp.horizon + 1) / ocp.horizon
    bump = (1.0 - np.cos(phase)) / span
    first, second = -error[0] / ocp.rates[0, 0], -error[1] / ocp.rates[1, 1]
    straight = np.column_stack([first * bump, second * bump])
    yield within(ocp, straight, wheel_speed)
    area = -error[2] if error[2] != 0.0 else 1e-3
    size = math.sqrt(max(abs(area), 1e-3) / math.pi)
    sense = math.copysign(1.0, area)
    per_first, per_second = (
        2.0 * math.pi * size / span / np.array([abs(ocp.rates[0, 0]), abs(ocp.rates[1, 1])])
    )
    signs = np.sign([ocp.rates[0, 0], ocp.rates[1, 1]])
    for mirror in (1.0, -1.0):
        lobes = np.column_stack(
            [per_first * np.sin(phase) * signs[0], -sense * per_second * np.cos(phase) * signs[1]]
        )
        yield within(ocp, straight + mirror * lobes, wheel_speed)
        lobes = np.column_stack(
            [per_first * np.cos(phase) * signs[0], sense * per_second * np.sin(phase) * signs[1]]
        )
        yield within(ocp, straight + mirror * lobes, wheel_speed)


def random_plan(ocp: WheelOcp, wheel_speed: Array, seed: int, attempt: int) -> Array:
    """Return random speeds (N+1, 2), the same for the same seed and attempt."""
    numbers = generator(seed, attempt, _STREAM, 0).uniform(-1.0, 1.0, (4, 2))
    phase = math.pi * np.arange(ocp.horizon + 1) / ocp.horizon
    shapes = np.column_stack([np.sin((i + 1) * phase) for i in range(4)])
    return within(ocp, 0.5 * ocp.max_speed * shapes @ numbers, wheel_speed)
