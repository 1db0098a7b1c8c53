"""Sequential quadratic programming for two wheels, on the structure of the problem.

The unknowns are the wheel speeds: bounds are then linear, every iterate keeps them, and the
attitude follows by a roll-out. Each step solves a quadratic program with the exact Hessian of the
Lagrangian (the Gauss-Newton one where that is not convex on the end's condition) by an
interior-point method along the stages, with the end's condition at an l1 price, so that each
program has a solution; a line search on the l1 merit, with a second-order correction, makes it
global. A plan that ends off the reference at a price that was raised four times is called
infeasible.

Source of the problem: Kolmanovsky et al. 2016 (AFRL), 3.1.2; the method is ours
(docs/underactuated.md).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from spacecraft_gnc.arguments import as_count, require_kind, require_positive
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array, ArrayLike
from spacecraft_gnc.vehicles.two_wheel.ocp._sqp_kernels import sqp
from spacecraft_gnc.vehicles.two_wheel.ocp.certificate import least_curvature
from spacecraft_gnc.vehicles.two_wheel.ocp.problem import MODELS, WheelOcp
from spacecraft_gnc.vehicles.two_wheel.ocp.search import IDENTITY, Found, solve
from spacecraft_gnc.vehicles.two_wheel.ocp.solution import WarmStart, WheelSolution

_PRICE: Final = 1.5  # of a missed end, over the largest weight of the attitude
_FIRM_PRICE: Final = 150.0


@dataclass(frozen=True, slots=True, eq=False)
class SqpSolver:
    """Solve a `WheelOcp` for one state after the other.

    Attributes
    ----------
    ocp : WheelOcp
    tolerance : float
        Largest residual of the first-order conditions, relative to the gradient, and largest
        distance of the end from the reference [rad].
    max_iterations : int
        SQP steps of one start.
    restarts : int
        Starts that are tried where no other one leads to a plan: the loops once more, at a hundred
        times the price of a missed end, then random ones.
    seed : int
        Of the random starts.
    chord : bool
        Keep the Hessian of the first step of a solve (the chord method of Newton and
        Kantorovich, for the second derivatives): more steps, each a little cheaper.

    Raises
    ------
    ParameterError
        If an argument is refused.
    """

    ocp: WheelOcp
    tolerance: float = 1e-8
    max_iterations: int = 60
    restarts: int = 3
    seed: int = 0
    chord: bool = False
    arenas: dict[bool, Any] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        require_kind("ocp", self.ocp, WheelOcp)
        require_positive("tolerance", self.tolerance)
        as_count("max_iterations", self.max_iterations)
        as_count("restarts", self.restarts, least=0)
        object.__setattr__(self, "arenas", {soft: _arena(self.ocp, soft) for soft in (False, True)})

    def solve(
        self,
        attitude: ArrayLike,
        wheel_speed: ArrayLike,
        reference: ArrayLike = IDENTITY,
        *,
        drift: ArrayLike | None = None,
        warm_start: WarmStart | None = None,
        soft: bool = False,
        search: bool = True,
    ) -> WheelSolution:
        """Find the plan from a state to rest at a reference.

        Parameters
        ----------
        attitude : (3, 3) array
            Body to inertial.
        wheel_speed : (2,) array
            [rad/s].
        reference : (3, 3) array
            Body to inertial.
        drift : (N+1, 3) array, optional
            Rate that other wheels give the bus at the nodes of the horizon, body frame [rad/s].
        warm_start : WarmStart, optional
            Of the solution of the step before; others are tried where it does not lead to a plan.
        search : bool, optional
            Whether other starts are tried where the warm one does not lead to a plan.
        soft : bool, optional
            Let the angle from the reference at the end be a term of the cost.

        Raises
        ------
        ShapeError, ParameterError
            If an argument is refused. What does not converge is told by the status.
        """
        return solve(
            self.ocp, self._run, _curvature, self.restarts, self.seed,
            attitude, wheel_speed, reference, drift, warm_start, soft, search,
        )  # fmt: skip

    def _run(
        self,
        first: Array,
        speeds: Array,
        rates: Array,
        soft: bool,
        warm: WarmStart | None,
        firm: bool,
    ) -> Found:
        """Return what one start leads to."""
        ocp = self.ocp
        N, rows = ocp.horizon, 2 if soft else 5
        a = np.empty((N + 1, first.size))
        a[0] = first
        y, z, report = np.zeros(rows), np.zeros((N, 4)), np.zeros(5)
        if warm is not None and warm.terminal.size == rows:
            y[:], z[:] = warm.terminal, warm.bounds
        nu = speeds.copy()
        weights = np.array(
            [*ocp.attitude_weights, ocp.speed_weight, ocp.acceleration_weight,
             ocp.terminal_weight if soft else 0.0]
        )  # fmt: skip
        limits = np.array(_limits(ocp))
        price = _FIRM_PRICE if firm else _PRICE
        status = sqp(
            MODELS.index(ocp.model), ocp.time_step, ocp.rates, rates, nu, a, weights, limits,
            price * float(ocp.attitude_weights.max()), self.tolerance, self.max_iterations,
            self.chord, self.arenas[soft], y, z, report,
        )  # fmt: skip
        A, B, M, _, Ct, *_ = self.arenas[soft][2]
        last = tuple(matrix.copy() for matrix in (A, B, M, Ct))
        return Found(Status(status), nu, a, y, z, report, last)


def _limits(ocp: WheelOcp) -> tuple[float, float]:
    """Return the limits of speed and acceleration; without one: twice what reverses the speed."""
    return ocp.max_speed, ocp.max_acceleration or 4.0 * ocp.max_speed / ocp.time_step


def _curvature(found: Found) -> float:
    """Return the least curvature of a plan by the accelerations."""
    A, B, M, Ct = found.matrices
    return least_curvature((A, B), M, Ct, found.active)


def _arena(ocp: WheelOcp, soft: bool) -> Any:
    """Return the arrays that the kernels work in."""
    N, na = ocp.horizon, 3 if ocp.model == "simplified" else 4
    nx, mt, e = na + 2, 2 if soft else 5, np.empty
    scratch = (e((2, 3)), e(3), e(4), e((3, 4)))
    local = (e(3), e((3, na)), e(3), e(na), e(na), e((na, 4)), e((na, 4)), e((4, 4)), e((na, na)))
    matrices = (
        e((N, nx, nx)), e((N, nx, 2)), e((N + 1, nx + 2, nx + 2)), e((N + 1, nx + 2)),
        e((mt, nx)), e(mt), e((N, 4)), e((N, 4)), e((N, 2)), e(nx), e(nx),
    )  # fmt: skip
    pairs = [np.ones((N + 1, 4, 2)) for _ in range(4)]
    work = (
        e((N + 1, nx, nx)), e((N + 1, nx, mt)), e((N, 2, nx)), e((N, 2, mt)), e((N, 3)),
        e((N + 1, nx)), e((N, 2)), *pairs, e((N, 4)), e((N, 4)), e((N + 1, nx)), e((N, 2)),
    )  # fmt: skip
    step = (np.zeros((N + 1, nx)), np.zeros((N, 2)), np.zeros(mt), np.zeros((N, 4)))
    trial = (e((N + 1, 2)), e((N + 1, na)), e(3), e(mt), e((N + 1, nx + 2, nx + 2)))
    return scratch, local, matrices, work, step, trial
