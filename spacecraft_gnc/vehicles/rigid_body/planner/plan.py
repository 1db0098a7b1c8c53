"""A plan as commands, figures and pages show it, and its numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from spacecraft_gnc.types import Array

if TYPE_CHECKING:  # the solver's kernels are needed by whoever solves
    from spacecraft_gnc.ocp.transfer import TransferSolution
    from spacecraft_gnc.ocp.transfer.solution import ActiveBound

AXES: Final = "xyz"


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """A plan with the time axis of a flight.

    Attributes
    ----------
    solution : TransferSolution
    is_shortest : bool
        Whether none was found with a control step less.
    reserves : pair of float
        Shares of the real bounds on torque and momentum that it leaves to the tracking; NaN where
        that is not known.
    """

    solution: TransferSolution
    is_shortest: bool = False
    reserves: tuple[float, float] = (math.nan, math.nan)

    @property
    def n_steps(self) -> int:
        """N."""
        return self.solution.problem.n_steps

    @property
    def period(self) -> float:
        """Control period [s]."""
        return self.solution.problem.body.time_step

    @property
    def time(self) -> Array:
        """(N,) start of each step [s]."""
        return np.asarray(self.period * np.arange(self.n_steps), dtype=np.float64)

    @property
    def torque_bounds(self) -> Array:
        """(2, 3) lower and upper ones [N m]."""
        return self.solution.problem.limits[:2]

    @property
    def momentum_bounds(self) -> Array:
        """(2, 3) lower and upper ones [N m s]."""
        return self.solution.problem.limits[2:]

    @property
    def saturation(self) -> Array:
        """(2, 3) co-momentum beyond which the torque, else -gamma, is at a bound [N m]."""
        return np.asarray(-self.torque_bounds[::-1])

    @property
    def attitude_co_states(self) -> Array:
        """(N, 3) zeta_k in the frame of the body at the end of step k [kg m^2 N m]."""
        turned = self.solution.attitude[1:]
        return np.asarray(turned.transpose(0, 2, 1) @ (turned[0] @ self.solution.zeta))

    @property
    def error_deg(self) -> Array:
        """(N+1,) angle to the goal [deg]."""
        from spacecraft_gnc import lie

        attitudes = self.solution.attitude
        goal = np.broadcast_to(self.solution.problem.goal, attitudes.shape)
        return np.degrees(lie.angles_between(attitudes, goal))


def numbers(plan: Plan) -> dict[str, Any]:
    """Return a plan in numbers, ready for JSON."""
    from spacecraft_gnc.ocp.transfer import shortest_possible_steps

    solution, problem = plan.solution, plan.solution.problem
    low_u, high_u, low_p, high_p = problem.limits
    return {
        "status": solution.status.text,
        "cost": solution.cost,
        "cost_integral": solution.cost * plan.period,
        "iterations": solution.iterations,
        "residual": solution.residuals.largest,
        "steps": plan.n_steps,
        "period": plan.period,
        "duration": problem.duration,
        "is_shortest": plan.is_shortest,
        "shortest_possible": shortest_possible_steps(problem) * plan.period,
        "angle_deg": math.degrees(problem.angle),
        "active": [_active(one) for one in solution.active],
        "tried": [{**one._asdict(), "status": one.status.text} for one in solution.tried],
        "reason": solution.reason,
        "min_curvature": solution.min_curvature,
        "residuals": solution.residuals._asdict(),
        "max_torque": np.abs(solution.torque).max(axis=0),
        "max_momentum": np.abs(solution.momentum).max(axis=0),
        "torque_bounds": [low_u, high_u],
        "momentum_bounds": [low_p, high_p],
        "reserves": list(plan.reserves),
        "solve_time": solution.solve_time,
    }


def _active(one: ActiveBound) -> dict[str, Any]:
    return {
        "bound": one.quantity,
        "axis": AXES[one.axis],
        "side": "upper" if one.bound > 0.0 else "lower",
        "value": one.bound,
        "first": one.first,
        "last": one.last,
    }
