"""What a solve returns."""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from spacecraft_gnc.types import Array

if TYPE_CHECKING:
    from spacecraft_gnc.ocp.problem import AttitudeOcp


class Status(IntEnum):
    """How a solve ended; the values are those of SolverStatus.msg."""

    CONVERGED = 0
    MAX_ITERATIONS = 1
    LINE_SEARCH_FAILED = 2
    UNSOLVABLE_STEP = 3
    NOT_FINITE = 4
    SINGULAR = 5
    STALLED = 6
    ESCAPING = 7

    @property
    def advice(self) -> str:
        """One sentence for a person: what happened and what to try."""
        return _ADVICE[self]


_ADVICE = {
    Status.CONVERGED: "The first-order conditions hold within the tolerance.",
    Status.MAX_ITERATIONS: "The iteration limit was reached: raise it, or start from a warm start.",
    Status.LINE_SEARCH_FAILED: "No step reduced the residual: loosen the tolerance or penalties.",
    Status.UNSOLVABLE_STEP: "The body turns too far in one step (Kalabic (3)): shorten it.",
    Status.NOT_FINITE: "A number overflowed: check the weights and the state.",
    Status.SINGULAR: "The Jacobian is singular: start from another guess.",
    Status.STALLED: "The loop came to rest away from its target, at a local minimum of the cost.",
    Status.ESCAPING: (
        "The loop leaves an unstable standstill by a small torque added to the optimal one."
    ),
}


class Solution(NamedTuple):
    """One solved horizon.

    Arrays belong to this solution alone and are not overwritten by later solves.
    """

    torques: Array
    """(N, 3) optimal body torques u_0 .. u_{N-1} [N m]."""
    attitudes: Array
    """(N+1, 3, 3) predicted rotations, body to inertial."""
    momenta: Array
    """(N+1, 3) predicted angular momenta, body frame [N m s]."""
    costates: Array
    """(N, 6) multipliers (lambda1_k, lambda2_k) in the paper's scaling, half the true ones."""
    cost: float
    """(27) + (28) + penalties, constants included."""
    status: Status
    iterations: int
    """Newton steps taken."""
    residual: float
    """Euclidean norm of the terminal conditions (44)."""
    solve_time: float
    """Wall time of the solve [s]."""
    torque_margin: float
    """max_torque - max_k |u_k| [N m]; infinite without a limit."""
    reference: Array
    """(3, 3) attitude tracked, body to inertial."""
    ocp: AttitudeOcp
    """The problem solved."""
    formulation: str
    """How the optimality conditions were solved, e.g. ``"backward_sweep"``."""
    min_curvature: float
    """Smallest eigenvalue of the second derivative of the cost to the controls; NaN: not known."""
    zone_margins: Array
    """(n_zones,) smallest angle left to each zone over the horizon [rad] (negative: inside)."""

    @property
    def converged(self) -> bool:
        """Whether the first-order conditions hold within the tolerance."""
        return self.status == Status.CONVERGED

    @property
    def warm_start(self) -> Array | None:
        """Multipliers (6,) shifted by one step, for the next solve; None if this one failed."""
        if not self.converged:
            return None
        return np.asarray(self.costates[min(1, len(self.costates) - 1)])
