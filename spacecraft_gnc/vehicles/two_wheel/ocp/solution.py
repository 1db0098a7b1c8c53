"""Plan for two wheels, with what certifies it."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np
from typing_extensions import Self

from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array, Matrix3
from spacecraft_gnc.vehicles.two_wheel.ocp.problem import WheelOcp


class WarmStart(NamedTuple):
    """Plan of the step before, one step on."""

    speeds: Array
    """(N+1, 2) [rad/s]; what the limits and the speeds now do not allow is changed."""
    terminal: Array
    """Multipliers of the conditions at the end."""
    bounds: Array
    """(N, 4) multipliers of the bounds of speeds and accelerations."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class WheelSolution:
    """A plan over the horizon; CONVERGED: the conditions hold within the tolerance, at a minimum.

    Attributes
    ----------
    ocp : WheelOcp
    soft : bool
        Whether the attitude at the end is a term of the cost and no condition.
    status : Status
        INFEASIBLE: the nearest that was found to a plan that ends at the reference.
    accelerations, speeds : (N, 2), (N+1, 2) arrays
        Of the wheels [rad/s^2], [rad/s].
    attitudes : (N+1, 3, 3) array
        As the model predicts them, body to inertial.
    cost : float
    terminal_violation : float
        Angle from the last attitude to the reference [rad].
    iterations, restarts : int
        SQP steps, of the start that was taken; further starts.
    residual : float
        Largest violation of the first-order conditions, relative to the gradient.
    min_curvature : float
        Smallest eigenvalue of the Hessian of the Lagrangian by the accelerations, reduced to the
        directions that keep the conditions and the active bounds [(s^2/rad)^2]; infinite where
        there is none.
    terminal_multipliers : (3,) array
        Of e_N = 0; zero where the end is soft.
    speed_multipliers, acceleration_multipliers : (N+1, 2), (N, 2) arrays
        Of the bounds: positive at the upper, negative at the lower one.
    solve_time : float
        Wall time of the plan, without ``min_curvature`` [s].
    """

    ocp: WheelOcp
    soft: bool
    status: Status
    accelerations: Array
    speeds: Array
    attitudes: Array
    cost: float
    terminal_violation: float
    iterations: int
    restarts: int
    residual: float
    min_curvature: float
    reference: Matrix3
    terminal_multipliers: Array
    speed_multipliers: Array
    acceleration_multipliers: Array
    solve_time: float

    def plain(self) -> tuple[Any, ...]:
        """Return its fields, but the problem, as numbers and arrays alone."""
        return tuple(getattr(self, field.name) for field in fields(self)[1:])

    @classmethod
    def of_plain(cls, values: tuple[Any, ...], ocp: WheelOcp) -> Self:
        """Return the plan of a problem whose `plain` fields these are."""
        named = dict(zip([field.name for field in fields(cls)[1:]], values, strict=True))
        named["status"] = Status(named["status"])
        return cls(ocp=ocp, **named)

    @property
    def converged(self) -> bool:
        """Whether it is a plan to fly."""
        return self.status == Status.CONVERGED

    @property
    def warm_start(self) -> WarmStart:
        """What a solve one step later starts from: the same plan, at rest at its end."""
        bounds = np.column_stack([self.speed_multipliers[1:], self.acceleration_multipliers])
        terminal = np.append(self.terminal_multipliers[: 0 if self.soft else 3], np.zeros(2))
        return WarmStart(
            np.vstack([self.speeds[1:], np.zeros(2)]),
            terminal,
            np.vstack([bounds[1:], np.zeros(4)]),
        )
