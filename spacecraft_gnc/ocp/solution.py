"""What a solve returns."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from typing_extensions import Self

from spacecraft_gnc.ocp.reference import RESTING
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array, Reference

if TYPE_CHECKING:
    from spacecraft_gnc.ocp.problem import AttitudeOcp


class Solution(NamedTuple):
    """One solved horizon.

    Arrays belong to this solution alone and are not overwritten by later solves.
    """

    torques: Array
    """(N, 3) optimal body torques B u_0 .. B u_{N-1} [N m]."""
    attitudes: Array
    """(N+1, 3, 3) predicted rotations, body to inertial."""
    momenta: Array
    """(N+1, 3) predicted angular momenta, body frame [N m s]."""
    multipliers: Array
    """(N+1, 6) `costates`, with the last row twice: what `warm_start` is cut from."""
    cost: float
    """(27) + (28) + penalties, constants included."""
    status: Status
    iterations: int
    """Newton steps taken."""
    residual: float
    """Euclidean norm of the first-order conditions over all stages, in the units of lambda2: of the
    costates run backward over the plan, minus the multipliers that its torques belong to."""
    solve_time: float
    """Wall time of the solve [s]."""
    torque_margin: float
    """max_torque - max_k |u_k| [N m]; infinite without a limit."""
    reference: Array
    """(3, 3) attitude tracked at the start of the horizon, body to inertial."""
    ocp: AttitudeOcp
    """The problem solved."""
    formulation: str
    """How the conditions were solved, such as "backward_sweep"."""
    min_curvature: float
    """Smallest pivot of the cost's second derivative to the torques, swept backward [(N m)^-2].

    A stationary point is a strict local minimum exactly where it is positive. Of the last
    linearization, one Newton step from the solution; NaN where the solve did not converge.
    """
    zone_margins: Array
    """Smallest angle [rad] to each zone over the predicted attitudes (negative: inside)."""
    attitude_error: float
    """Angle [rad] from the reference at the start of the horizon."""
    travel: float
    """Angle [rad] between the first and the last predicted attitude."""
    terminal_level: float = math.nan
    """|(Z_N, Pi_N)|_P^2 where the problem has a terminal set; NaN without one."""
    terminal_multiplier: float = 0.0
    """Multiplier nu >= 0 of the terminal set; ``ocp`` then has (1 + nu) F as its terminal cost."""
    feedforward: Array = RESTING
    """(2, 3) angular velocity [rad/s] and torque [N m] with which that attitude moves."""

    def __repr__(self) -> str:
        """Return how the solve ended, in one line."""
        error = math.degrees(self.attitude_error)
        return (
            f"Solution({self.status.name} after {self.iterations} iterations, residual "
            f"{self.residual:.2g}, cost {self.cost:.6g}, {error:.4g} deg from the reference, "
            f"{len(self.torques)} steps, {1e6 * self.solve_time:.3g} us)"
        )

    def plain(self) -> tuple[Any, ...]:
        """Return its fields as numbers, texts and arrays alone; of the problem, nothing."""
        return tuple(self._replace(ocp=None, status=int(self.status)))  # type: ignore[arg-type]

    @classmethod
    def of_plain(cls, fields: tuple[Any, ...], ocp: AttitudeOcp) -> Self:
        """Return the solution of a problem whose `plain` fields these are."""
        found = cls(*fields)
        if found.terminal_multiplier > 0.0:
            ocp = ocp.weighted(found.terminal_multiplier)  # type: ignore[attr-defined]
        return found._replace(ocp=ocp, status=Status(found.status))

    @property
    def tracked(self) -> Reference:
        """The reference of the solve."""
        return Reference(self.reference, *self.feedforward)

    @property
    def converged(self) -> bool:
        """Whether the first-order conditions hold within the tolerance, at a minimum."""
        return self.status == Status.CONVERGED

    @property
    def costates(self) -> Array:
        """(N, 6) multipliers (lambda1_k, lambda2_k) in the paper's scaling, half the true ones."""
        return self.multipliers[:-1]

    @property
    def warm_start(self) -> Array | None:
        """Multipliers (N, 6) to start the next solve from, one step on; None if this one failed."""
        return self.multipliers[1:] if self.converged else None

    @property
    def controls(self) -> Array:
        """(N, m) optimal controls u_k, of which B makes the torques [N m]: the cheapest that do."""
        ocp = self.ocp
        B = ocp.torque_map
        if B.shape[1] != 3 or np.linalg.matrix_rank(B) == 3:  # of one weight, or the only ones
            return np.asarray(self.torques @ ocp.allocation.T)
        cheap = ocp.control_axes / np.sqrt(ocp.control_weights)
        return np.asarray((cheap @ (np.linalg.pinv(B @ cheap) @ self.torques.T)).T)
