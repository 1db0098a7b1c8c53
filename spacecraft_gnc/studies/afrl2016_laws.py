"""First acceleration of the plans over the attitude: the discontinuous law of Figs. 1 and 2.

Each plan is solved from a cold start, at rest, with the report's simplified model (2) and its
hard terminal condition. (2) has two symmetries: with phi, nu_1, u_1 and psi, and with theta, nu_2,
u_2 and psi reversed, a plan stays a plan of the same cost. For theta = 0 the law is therefore odd
in phi and even in psi, and jumps across phi = 0 wherever it is not 0 there. The circles are solved
all around, which checks this; the plane is solved where phi and psi are positive, and mirrored.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from spacecraft_gnc.status import Status
from spacecraft_gnc.studies.flights import Progress
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.two_wheel.euler import from_euler_321
from spacecraft_gnc.vehicles.two_wheel.ocp.problem import WheelOcp
from spacecraft_gnc.vehicles.two_wheel.ocp.solution import WheelSolution
from spacecraft_gnc.vehicles.two_wheel.ocp.sqp import SqpSolver

INERTIA: Final = np.diag([430.0, 1210.0, 1300.0])  # section 4.1 [kg m^2]
AXIAL: Final = 0.043  # [kg m^2]
MAX_SPEED: Final = 100.0  # [rad/s]
MAX_ACCELERATION: Final = 5.0  # [rad/s^2]
PERIOD: Final = 10.0  # [s]
HORIZON: Final = 30
BESIDE: Final = 1e-3  # how near to phi = 0 the jump is read off [rad]
_YAW_RESOLUTION: Final = 1e-3  # [rad]


class Circle(NamedTuple):
    """The law over phi = r cos(lambda), psi = r sin(lambda), theta = 0."""

    radius: float
    """r [rad]."""
    angle: Array
    """(n,) lambda [rad]."""
    acceleration: Array
    """(n,) u_1 [rad/s^2]; NaN: the problem is infeasible."""
    cost: Array
    """(n,) of the plan; NaN likewise."""

    @property
    def infeasible(self) -> int:
        """Number of points from which no plan ends at rest at the target."""
        return int(np.isnan(self.acceleration).sum())


class Plane(NamedTuple):
    """The law over phi and psi, theta = 0."""

    roll: Array
    """(n,) phi [rad]."""
    yaw: Array
    """(m,) psi [rad]."""
    acceleration: Array
    """(m, n) u_1 [rad/s^2]; NaN: the problem is infeasible."""
    cost: Array
    """(m, n) of the plan; NaN likewise."""


def solver_of(horizon: int = HORIZON) -> SqpSolver:
    """Return the solver of the report's problem (4)-(5)."""
    wheels = AXIAL * np.eye(3)[:, :2]
    return SqpSolver(
        WheelOcp(
            INERTIA,
            wheels,
            PERIOD,
            horizon,
            max_speed=MAX_SPEED,
            max_acceleration=MAX_ACCELERATION,
            model="simplified",
        )
    )


def circle(solver: SqpSolver, radius: float, n: int, progress: Progress) -> Circle:
    """Solve at ``n`` points of a circle, equally spaced, the first at psi = 0.

    Parameters
    ----------
    solver : SqpSolver
    radius : float
        [rad].
    n : int
    progress : callable
    """
    angle = np.linspace(0.0, 2.0 * math.pi, n, endpoint=False)
    points = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    u, cost = _solved(solver, points, f"Fig. 1, radius {radius:g} rad", progress).T
    return Circle(radius, angle, u, cost)


def plane(solver: SqpSolver, half_width: float, n: int, progress: Progress) -> Plane:
    """Solve on a square of 2n by 2n cells, none of them on phi = 0 or psi = 0.

    Parameters
    ----------
    solver : SqpSolver
    half_width : float
        [rad].
    n : int
    progress : callable
    """
    quarter = (np.arange(n) + 0.5) * (half_width / n)
    points = np.stack(np.meshgrid(quarter, quarter), axis=-1).reshape(-1, 2)
    u, cost = _solved(solver, points, "Fig. 2", progress).T.reshape(2, n, n)
    u, cost = np.hstack([-u[:, ::-1], u]), np.hstack([cost[:, ::-1], cost])
    angles = np.concatenate([-quarter[::-1], quarter])
    return Plane(angles, angles, np.vstack([u[::-1], u]), np.vstack([cost[::-1], cost]))


def jump(solver: SqpSolver, radius: float) -> tuple[float, float]:
    """Return u_1 just before and just behind phi = 0 on a circle of a radius [rad]."""
    yaw = math.sqrt(radius**2 - BESIDE**2)
    points = np.array([(-BESIDE, yaw), (BESIDE, yaw)])
    before, behind = (_law(solve(solver, point))[0] for point in points)
    return before, behind


def largest_yaw(horizon: int, lower: float, upper: float) -> float:
    """Return the largest pure yaw from which a horizon suffices, by bisection [rad].

    NaN if there is no plan from ``lower``, or one from ``upper``.
    """
    solver = solver_of(horizon)
    if _reaches(solver, upper) or not _reaches(solver, lower):
        return math.nan
    while upper - lower > _YAW_RESOLUTION:
        middle = 0.5 * (lower + upper)
        lower, upper = (middle, upper) if _reaches(solver, middle) else (lower, middle)
    return lower


def solve(solver: SqpSolver, point: Array) -> WheelSolution:
    """Solve from rest at (phi, psi) (2,) [rad], theta = 0, without a warm start."""
    attitude = from_euler_321(np.array([point[0], 0.0, point[1]]))
    return solver.solve(attitude, np.zeros(2))


def is_plan(solution: WheelSolution) -> bool:
    """Tell whether a solution is a plan to fly."""
    return bool(solution.status == Status.CONVERGED)


def _reaches(solver: SqpSolver, yaw: float) -> bool:
    return is_plan(solve(solver, np.array([0.0, yaw])))


def asymmetry(laws: Circle) -> float:
    """Return the largest relative difference in cost of points that mirror each other.

    NaN where one of them has a plan and the other has none. The number of points has to be even.
    """
    n = len(laws.angle)
    i = np.arange(n)
    mirrored = [laws.cost[at % n] for at in (n // 2 - i, -i, n // 2 + i)]
    if any((np.isnan(laws.cost) != np.isnan(other)).any() for other in mirrored):
        return math.nan
    return max(float(np.nanmax(np.abs(other / laws.cost - 1.0))) for other in mirrored)


def _solved(solver: SqpSolver, points: Array, what: str, progress: Progress) -> Array:
    """Return (k, 2) first accelerations of the first wheel and costs of (k, 2) points."""
    found = np.empty((len(points), 2))
    for i, point in enumerate(points):
        progress(what, i, len(points))
        found[i] = _law(solve(solver, point))
    return found


def _law(solution: WheelSolution) -> tuple[float, float]:
    if not is_plan(solution):
        return math.nan, math.nan
    return float(solution.accelerations[0, 0]), solution.cost
