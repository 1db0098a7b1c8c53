"""Shortest horizon over which two wheels bring a spacecraft to rest at a reference."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from spacecraft_gnc.types import ArrayLike
from spacecraft_gnc.vehicles.two_wheel.ocp.problem import WheelOcp
from spacecraft_gnc.vehicles.two_wheel.ocp.search import IDENTITY
from spacecraft_gnc.vehicles.two_wheel.ocp.sqp import SqpSolver

LONGEST: Final = 480
"""Horizon beyond which none is looked for [steps]."""


def shortest_horizon(
    ocp: WheelOcp,
    attitude: ArrayLike,
    wheel_speed: ArrayLike,
    reference: ArrayLike = IDENTITY,
) -> int | None:
    """Return the least horizon whose hard problem has a plan [steps]; None: not even `LONGEST`.

    A plan over N steps, and a step at rest after it, is one over N + 1: what is feasible stays so,
    and the least is found by doubling and bisection, each horizon by `SqpSolver`.

    Parameters
    ----------
    ocp : WheelOcp
        Its horizon is where the search begins.
    attitude, reference : (3, 3) arrays
        Body to inertial.
    wheel_speed : (2,) array
        [rad/s].

    Raises
    ------
    ShapeError, ParameterError
        If an argument is refused.
    """

    def feasible(horizon: int) -> bool:
        solver = SqpSolver(replace(ocp, horizon=horizon))
        return solver.solve(attitude, wheel_speed, reference).converged

    high = min(ocp.horizon, LONGEST)
    while not feasible(high):
        if high == LONGEST:
            return None
        high = min(2 * high, LONGEST)
    low = 0  # over no step at all, nothing is solved
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if feasible(middle) else (middle, high)
    return high
