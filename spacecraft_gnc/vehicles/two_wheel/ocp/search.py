"""Search for the best plan over several starts, the same for both solvers."""

from __future__ import annotations

import math
from collections.abc import Callable
from time import perf_counter

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.arrays import as_finite
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array, ArrayLike, as_rotation
from spacecraft_gnc.vehicles.two_wheel.ocp.problem import WheelOcp
from spacecraft_gnc.vehicles.two_wheel.ocp.solution import WarmStart, WheelSolution
from spacecraft_gnc.vehicles.two_wheel.ocp.sqp import (
    Found,
    coordinates,
    first_attitude,
    inertial_attitudes,
)
from spacecraft_gnc.vehicles.two_wheel.ocp.starts import can_stop, loops, random_plan, within

Run = Callable[[Array, Array, Array, bool, WarmStart | None], Found]
"""(first attitude, speeds to start from, drift, soft, warm start) -> what the start leads to."""


def solve(
    ocp: WheelOcp,
    run: Run,
    restarts: int,
    seed: int,
    attitude: ArrayLike,
    wheel_speed: ArrayLike,
    reference: ArrayLike,
    drift: ArrayLike | None,
    warm_start: WarmStart | None,
    soft: bool,
) -> WheelSolution:
    """Return the plan of the best start; the arguments are those of `SqpSolver.solve`."""
    begun = perf_counter()
    rotation, target = as_rotation("attitude", attitude), as_rotation("reference", reference)
    speed = as_finite("wheel_speed", wheel_speed, (2,), "two numbers [rad/s]")
    nodes, first = ocp.horizon + 1, first_attitude(ocp, rotation, target)
    rates = np.zeros((nodes, 3))
    if drift is not None:
        rates = as_finite("drift", drift, (nodes, 3), f"{nodes} rates [rad/s]") @ ocp.frame

    def start(speeds: Array, warm: WarmStart | None = None) -> Found:
        return run(first, speeds, rates, soft, warm)

    tried = []
    if warm_start is not None:
        tried.append(start(within(ocp, warm_start.speeds, speed), warm_start))
    if not tried or tried[0].status != Status.CONVERGED:
        error = coordinates(ocp, first)
        tried += [start(speeds) for speeds in loops(ocp, error, speed)]
        for attempt in range(restarts if can_stop(ocp, speed) else 0):
            if any(found.status == Status.CONVERGED for found in tried):
                break
            tried.append(start(random_plan(ocp, speed, seed, attempt)))
    found = min(tried, key=lambda one: one.rank)
    if not can_stop(ocp, speed):
        found = found._replace(status=Status.INFEASIBLE)
    attitudes = inertial_attitudes(ocp, found.attitudes, target)
    return WheelSolution(
        ocp=ocp,
        soft=soft,
        status=found.status,
        accelerations=np.diff(found.speeds, axis=0) / ocp.time_step,
        speeds=found.speeds,
        attitudes=attitudes,
        cost=float(found.report[2]),
        terminal_violation=float(lie.angle_between(attitudes[-1], target)),
        iterations=int(found.report[0]),
        restarts=len(tried) - 1,
        residual=float(found.report[1]),
        min_curvature=math.nan,
        reference=target,
        terminal_multipliers=np.zeros(3) if soft else found.multipliers[:3].copy(),
        speed_multipliers=np.vstack([np.zeros(2), found.bounds[:, :2]]),
        acceleration_multipliers=found.bounds[:, 2:].copy(),
        solve_time=perf_counter() - begun,
    )
