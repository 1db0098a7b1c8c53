"""Search for the best plan over several starts, the same for both solvers."""

from __future__ import annotations

import math
from collections.abc import Callable
from time import perf_counter
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.arrays import as_finite
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array, ArrayLike, Matrix3, Vector3, as_rotation
from spacecraft_gnc.vehicles.two_wheel.euler import from_euler_321, to_euler_321
from spacecraft_gnc.vehicles.two_wheel.ocp.problem import WheelOcp
from spacecraft_gnc.vehicles.two_wheel.ocp.solution import WarmStart, WheelSolution
from spacecraft_gnc.vehicles.two_wheel.ocp.starts import can_stop, loops, random_plan, within

IDENTITY: Final = np.eye(3)
_ACTIVE: Final = 1e-7  # multiplier of a bound that acts, over the largest one


class Found(NamedTuple):
    """What one start led to."""

    status: Status
    speeds: Array
    attitudes: Array
    multipliers: Array
    bounds: Array
    report: Array
    matrices: tuple[Any, ...]
    """What the solver makes the curvature of."""

    @property
    def active(self) -> NDArray[np.bool_]:
        """(N, 4) whether a bound acts."""
        sizes = np.abs(self.bounds)
        return np.asarray(sizes > _ACTIVE * max(1.0, float(sizes.max())))

    @property
    def rank(self) -> tuple[bool, float]:
        """Order of preference, the best first: solved, then cheap; else near the reference."""
        solved = self.status == Status.CONVERGED
        return not solved, float(self.report[2 if solved else 3])


Run = Callable[[Array, Array, Array, bool, WarmStart | None, bool], Found]
"""(first attitude, speeds to start from, drift, soft, warm start, firm) -> what the start leads to.

``firm``: put the end before the cost, after starts that ended off the reference.
"""


def solve(
    ocp: WheelOcp,
    run: Run,
    curvature: Callable[[Found], float],
    restarts: int,
    seed: int,
    attitude: ArrayLike,
    wheel_speed: ArrayLike,
    reference: ArrayLike,
    drift: ArrayLike | None,
    warm_start: WarmStart | None,
    soft: bool,
    search: bool,
) -> WheelSolution:
    """Return the plan of the best start; the arguments are those of `SqpSolver.solve`.

    ``curvature`` gives the least curvature of a plan that keeps the conditions.
    """
    begun = perf_counter()
    rotation, target = as_rotation("attitude", attitude), as_rotation("reference", reference)
    speed = as_finite("wheel_speed", wheel_speed, (2,), "two numbers [rad/s]")
    nodes, first = ocp.horizon + 1, first_attitude(ocp, rotation, target)
    rates = np.zeros((nodes, 3))
    if drift is not None:
        rates = as_finite("drift", drift, (nodes, 3), f"{nodes} rates [rad/s]") @ ocp.frame

    def start(speeds: Array, warm: WarmStart | None = None, firm: bool = False) -> Found:
        return run(first, speeds, rates, soft, warm, firm)

    tried = []
    if warm_start is not None:
        for firm in (False, True) if search else (False,):
            tried.append(start(within(ocp, warm_start.speeds, speed), warm_start, firm))
            if tried[-1].status == Status.CONVERGED:
                break
    if not tried or (search and tried[-1].status != Status.CONVERGED):
        plans = list(loops(ocp, coordinates(ocp, first), speed))
        plans = plans if can_stop(ocp, speed) else plans[:1]  # there is no plan
        tried += [start(speeds) for speeds in plans]
        for attempt in range(restarts if can_stop(ocp, speed) else 0):
            if any(found.status == Status.CONVERGED for found in tried):
                break
            again = attempt + 1 < len(plans)  # the loops, once more
            speeds = plans[attempt + 1] if again else random_plan(ocp, speed, seed, attempt)
            tried.append(start(speeds, firm=True))
    found = min(tried, key=lambda one: one.rank)
    if not can_stop(ocp, speed):
        found = found._replace(status=Status.INFEASIBLE)
    taken = perf_counter() - begun
    least = curvature(found) if found.status == Status.CONVERGED else math.nan
    status = Status.SADDLE if least < 0.0 else found.status
    attitudes = inertial_attitudes(ocp, found.attitudes, target)
    return WheelSolution(
        ocp=ocp,
        soft=soft,
        status=status,
        accelerations=np.diff(found.speeds, axis=0) / ocp.time_step,
        speeds=found.speeds,
        attitudes=attitudes,
        cost=float(found.report[2]),
        terminal_violation=float(lie.angle_between(attitudes[-1], target)),
        iterations=int(found.report[0]),
        restarts=len(tried) - 1,
        residual=float(found.report[1]),
        min_curvature=least,
        reference=target,
        terminal_multipliers=np.zeros(3) if soft else found.multipliers[:3].copy(),
        speed_multipliers=np.vstack([np.zeros(2), found.bounds[:, :2]]),
        acceleration_multipliers=found.bounds[:, 2:].copy(),
        solve_time=taken,
    )


def first_attitude(ocp: WheelOcp, attitude: Matrix3, reference: Matrix3) -> Array:
    """Return an attitude as the model has it: angles (3,), or the error's quaternion (4,)."""
    error = ocp.frame.T @ reference.T @ attitude @ ocp.frame
    if ocp.model == "simplified":
        return to_euler_321(error)
    x, y, z, w = lie.to_quaternion_xyzw(error)
    return np.array([w, x, y, z])


def coordinates(ocp: WheelOcp, a: Array) -> Vector3:
    """Return about the angles (3,) from the reference in the prediction frame [rad]."""
    return a if ocp.model == "simplified" else 2.0 * a[1:]


def inertial_attitudes(ocp: WheelOcp, a: Array, reference: Matrix3) -> Array:
    """Return attitudes (N+1, 3, 3), body to inertial, of those of the model."""
    if ocp.model == "simplified":
        errors = np.array([from_euler_321(angles) for angles in a])
    else:
        w, x, y, z = (a / np.linalg.norm(a, axis=1, keepdims=True)).T
        errors = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        ).transpose(2, 0, 1)
    return np.asarray(reference @ ocp.frame @ errors @ ocp.frame.T)
