"""Plan of an attitude transfer, with what certifies it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.ocp.transfer.conditions import Residuals
from spacecraft_gnc.ocp.transfer.problem import AttitudeTransfer
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array, Vector3


class Tried(NamedTuple):
    """What one start led to."""

    start: str
    status: Status
    cost: float
    iterations: int
    """Newton steps of the homotopy and of Algorithm 2."""


class ActiveBound(NamedTuple):
    """A bound that acts over consecutive steps."""

    quantity: str
    """``torque`` or ``momentum``."""
    axis: int
    bound: float
    """[N m] or [N m s]."""
    first: int
    last: int


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class TransferSolution:
    """A plan; CONVERGED: (5.6)-(5.8) hold within the tolerance, at a strict minimum.

    Attributes
    ----------
    problem : AttitudeTransfer
    status : Status
        INFEASIBLE: proven, see ``reason``. What was not found is not called infeasible.
    torque : (N, 3) array
        Body torque [N m].
    momentum : (N+1, 3) array
        Body frame [N m s].
    attitude : (N+1, 3, 3) array
        Body to inertial, by a roll-out of the torque.
    co_momentum : (N, 3) array
        gamma [N m]; -gamma is the torque where no bound acts.
    zeta : (3,) array
        zeta_0 [kg m^2 N m]; the co-state of the attitude, constant in the inertial frame.
    torque_multipliers, momentum_multipliers : (N, 3), (N+1, 3) arrays
        alpha u [N m] and beta Pi [N m/s]: positive at upper, negative at lower bounds.
    active_torque, active_momentum : (N, 3), (N+1, 3) arrays of int
        -1, 0, 1: lower bound, none, upper bound.
    cost : float
        Sum of |u|^2 / 2 [N^2 m^2].
    residuals : Residuals
    min_curvature : float
        Lower bound on the smallest eigenvalue of the Hessian of the cost by the torque, reduced to
        the active set (1 where the motion is linear); NaN unless converged.
    iterations : int
        Newton steps of the start that was taken.
    work : float
        Of all starts: how often the stages were gone along (Riccati recursions, and motions of line
        searches), times their number N.
    tried : tuple of Tried
    reason : str
        What the status rests on, in words.
    solve_time : float
        Wall time of all starts [s].
    """

    problem: AttitudeTransfer
    status: Status
    torque: Array
    momentum: Array
    attitude: Array
    co_momentum: Array
    zeta: Vector3
    torque_multipliers: Array
    momentum_multipliers: Array
    active_torque: NDArray[np.int64]
    active_momentum: NDArray[np.int64]
    cost: float
    residuals: Residuals
    min_curvature: float
    iterations: int
    tried: tuple[Tried, ...]
    reason: str
    solve_time: float
    work: float = 0.0

    @property
    def converged(self) -> bool:
        """Whether it is optimal: a plan to fly."""
        return self.status == Status.CONVERGED

    @property
    def active(self) -> tuple[ActiveBound, ...]:
        """The bounds that act, each over its consecutive steps."""
        found = []
        limits = self.problem.limits
        for quantity, sets, pair in (
            ("torque", self.active_torque, limits[:2]),
            ("momentum", self.active_momentum, limits[2:]),
        ):
            for axis in range(3):
                for side in (-1, 1):
                    steps = np.flatnonzero(sets[:, axis] == side)
                    for run in np.split(steps, np.flatnonzero(np.diff(steps) > 1) + 1):
                        if len(run):
                            bound = float(pair[int(side > 0), axis])
                            found.append(
                                ActiveBound(quantity, axis, bound, int(run[0]), int(run[-1]))
                            )
        return tuple(found)
