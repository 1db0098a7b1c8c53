"""Problems of a flight solved once more: by our SQP and by IPOPT, from the same warm starts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from spacecraft_gnc.status import Status
from spacecraft_gnc.studies.flights import Flown, Progress
from spacecraft_gnc.types import Array, Matrix3
from spacecraft_gnc.vehicles.two_wheel.controllers.report import Solve, Terminal
from spacecraft_gnc.vehicles.two_wheel.ocp.ipopt import IpoptSolver
from spacecraft_gnc.vehicles.two_wheel.ocp.problem import WheelOcp
from spacecraft_gnc.vehicles.two_wheel.ocp.solution import WarmStart, WheelSolution
from spacecraft_gnc.vehicles.two_wheel.ocp.sqp import SqpSolver


class Problem(NamedTuple):
    """What a solve was asked for."""

    attitude: Matrix3
    wheel_speed: Array
    reference: Matrix3
    soft: bool


class Comparison(NamedTuple):
    """Row k: the problem of a step, solved by both.

    Attributes
    ----------
    ours, theirs : (n,) arrays
        Wall times [s] of SQP and IPOPT.
    our_cost, their_cost : (n,) arrays
        NaN where a solver found no plan.
    slack : (n,) array
        What our cost would change by if the plan ended at the reference exactly, and not up to the
        tolerance off it: the multipliers of the end times the angle.
    """

    ours: Array
    theirs: Array
    our_cost: Array
    their_cost: Array
    slack: Array

    @property
    def speed_up(self) -> float:
        """Median of IPOPT's time over ours."""
        return float(np.median(self.theirs / self.ours))

    @property
    def excess(self) -> Array:
        """(n,) our cost over IPOPT's beyond the slack, relative; NaN where one of them has none."""
        over = self.our_cost - self.their_cost
        return np.sign(over) * np.maximum(np.abs(over) - self.slack, 0.0) / self.their_cost


def problems(flown: Flown) -> Iterator[Problem]:
    """Yield the problems of the solves of a flight whose plans were flown."""
    flight: Any = flown.trajectory
    for k, report in enumerate(flown.reports):
        solve: Solve | None = getattr(report, "solve", None)
        if solve is not None and solve.terminal != Terminal.FREE:
            soft = solve.terminal == Terminal.SOFT
            yield Problem(flight.attitude[k], flight.wheel_speed[k], solve.terminal_attitude, soft)


def compare(ocp: WheelOcp, wanted: list[Problem], progress: Progress) -> Comparison:
    """Solve each problem by both solvers, from the plan that ours had for the one before."""
    ours, theirs = SqpSolver(ocp), IpoptSolver(ocp)
    warm: WarmStart | None = None
    rows = []
    for k, problem in enumerate(wanted):
        progress("the same problems by IPOPT", k, len(wanted))
        if k == 0:  # loads the kernels, and builds IPOPT's problem
            _solve(ours, problem, warm)
            _solve(theirs, problem, warm)
        first, second = _solve(ours, problem, warm), _solve(theirs, problem, warm)
        slack = first.terminal_violation * float(np.linalg.norm(first.terminal_multipliers))
        rows.append((first.solve_time, second.solve_time, _cost(first), _cost(second), slack))
        warm = first.warm_start
    return Comparison(*np.array(rows).T.copy())


def _solve(
    solver: SqpSolver | IpoptSolver, problem: Problem, warm_start: WarmStart | None
) -> WheelSolution:
    return solver.solve(
        problem.attitude,
        problem.wheel_speed,
        problem.reference,
        warm_start=warm_start,
        soft=problem.soft,
    )


def _cost(solution: WheelSolution) -> float:
    return solution.cost if solution.status == Status.CONVERGED else np.nan
