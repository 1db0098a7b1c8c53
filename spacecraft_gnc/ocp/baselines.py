"""The solvers that the papers compare with, built of scipy: `SlsqpSolver` and `FsolveSolver`.

Both calculate derivatives numerically, as the papers' baselines did; cost and conditions are the
compiled ones of this package, which is the best that can be done for them.
"""

from __future__ import annotations

import math
from dataclasses import replace
from time import perf_counter
from typing import NamedTuple

import numpy as np

from spacecraft_gnc.arguments import as_count, require_kind, require_positive
from spacecraft_gnc.dynamics import state_units
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.ocp import _shooting_kernels
from spacecraft_gnc.ocp._certificate_kernels import largest_row, rounding_of
from spacecraft_gnc.ocp._data_kernels import MADE_OF, MADE_OF_PI
from spacecraft_gnc.ocp._stage_kernels import Z_AT, horizon_cost, work_size
from spacecraft_gnc.ocp.assembly import assemble, failed
from spacecraft_gnc.ocp.linearization import linearize
from spacecraft_gnc.ocp.problem import AttitudeOcp
from spacecraft_gnc.ocp.reference import Tracked, as_reference, is_moving
from spacecraft_gnc.ocp.rollout import Horizon, track_of
from spacecraft_gnc.ocp.solution import Solution
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array, ArrayLike, Reference, as_rotation, as_vector3

# Residual, in units of the multipliers, with which a search that forward differences no longer
# advance is done.
SETTLED = 4e-6
FAR = 1e12  # cost, or residual, of controls under which the integrator has no step
DIFFERENCE = 1.5e-7  # step of the forward differences, as a share of the limit


class Units(NamedTuple):
    """What the numbers that a solver of scipy sees are counted in."""

    cost: float
    """Of an attitude error of about one radian, or of the momentum that makes it, all along."""
    multiplier: float
    """Of lambda2: that cost over the momentum that turns the body by a radian in the horizon."""
    control: float
    """Controls that cost as much over one step [N m], so that second derivatives are about 1."""

    @classmethod
    def of(cls, ocp: AttitudeOcp) -> Units:
        """Return the units of a problem."""
        span, dearest = ocp.horizon * ocp.time_step, float(ocp.control_weights.max())
        momentum = float(state_units(np.asarray(ocp.inertia), span)[3])
        multiplier = float(ocp.data[MADE_OF] + ocp.data[MADE_OF_PI] * momentum)
        multiplier = multiplier or dearest * momentum / span  # where no state costs anything
        cost = multiplier * momentum
        return cls(cost, multiplier, math.sqrt(cost / (ocp.time_step * dearest)))


class SlsqpSolver:
    """Sequential quadratic programming on the controls: the role of MATLAB's fmincon.

    The torque limit and the pointing zones are hard constraints, at the steps where the penalties
    of `AttitudeOcp` act. Derivatives are forward differences.

    Parameters
    ----------
    ocp : AttitudeOcp
    tolerance : float
        Change of the cost at which the minimization stops, in `Units.cost`.
    max_iterations : int

    Notes
    -----
    Controls and cost are handed over in `Units`, so that differences and tolerance are the same
    whatever the units of the problem are.
    ``residual`` of its solutions is the norm of the gradient of the cost along the directions that
    the torque limit leaves free, over 2 h; ``min_curvature`` is NaN: nothing certifies a minimum.
    Source: Gupta et al. 2015, section IV (baseline solver); Kalabic et al. 2014.
    """

    formulation = "slsqp"

    def __init__(
        self, ocp: AttitudeOcp, tolerance: float = 1e-12, max_iterations: int = 100
    ) -> None:
        self.ocp = require_kind("ocp", ocp, AttitudeOcp)
        self._plain = replace(ocp, max_torque=0.0, zones=())
        self._units = Units.of(ocp)
        self._options = {
            "eps": DIFFERENCE * (ocp.max_torque / self._units.control or 1.0),
            "maxiter": as_count("max_iterations", max_iterations, remedy="give 100"),
            "ftol": require_positive("tolerance", tolerance),
        }

    def warm_up(self) -> None:
        """Compile or load the kernels, and the minimizer."""
        import scipy.optimize  # noqa: F401

        self._plain.cost(np.zeros((self.ocp.horizon, self.ocp.n_controls)), np.eye(3), np.zeros(3))

    def memory(self) -> tuple[()]:
        """Return what the next solve takes over from those before: nothing."""
        return ()

    def recall(self, memory: tuple[()]) -> None:
        """Nothing is remembered."""

    def solve(
        self,
        attitude: ArrayLike,
        momentum: ArrayLike,
        reference: Tracked | None = None,
        warm_start: Array | None = None,
    ) -> Solution:
        """Solve from a state; arguments and failures as `ShootingSolver.solve`.

        ``warm_start`` gives the controls to start from, by way of its multipliers.
        """
        from scipy.optimize import minimize  # loads for longer than all of this package

        started = perf_counter()
        ocp, shape = self.ocp, (self.ocp.horizon, self.ocp.n_controls)
        state = (as_rotation("attitude", attitude), as_vector3("momentum", momentum))
        target = as_reference(reference)
        first = np.zeros(shape)
        if warm_start is not None:
            warm_start = ocp.checked_warm_start(warm_start)
            turned = (warm_start[:, 3:] @ ocp.torque_map @ ocp.control_axes) / ocp.control_weights
            if is_moving(target):
                turned += track_of(ocp, target)[-ocp.n_controls :]
            first = turned @ ocp.control_axes.T

        units = self._units

        def cost(x: Array) -> float:
            try:
                return (
                    self._plain.cost(units.control * x.reshape(shape), *state, target) / units.cost
                )
            except GncError:
                return FAR

        found = minimize(
            cost, first.ravel() / units.control, method="SLSQP",
            constraints=self._constraints(shape, state), options=self._options,
        )  # fmt: skip
        status = Status.CONVERGED if found.success else Status.LINE_SEARCH_FAILED
        if found.status == 9:  # scipy's number for the iteration limit
            status = Status.MAX_ITERATIONS
        u = units.control * np.asarray(found.x, dtype=np.float64).reshape(shape)
        return self._solution(u, state, target, status, int(found.nit), started)

    def _constraints(
        self, shape: tuple[int, int], state: tuple[Array, Array]
    ) -> list[dict[str, object]]:
        ocp, unit, limits = self.ocp, self._units.control, []
        largest = ocp.max_torque / unit

        def torque_room(x: Array) -> Array:
            return np.asarray(1.0 - (x.reshape(shape) ** 2).sum(axis=1) / largest**2)

        def zone_room(x: Array) -> Array:
            try:
                attitudes, _ = self._plain.rollout(unit * x.reshape(shape), *state)
            except GncError:
                return np.full(len(ocp.zones) * (ocp.horizon - 2), -1.0)
            return np.concatenate([zone.cosine_room(attitudes[2:-1]) for zone in ocp.zones])

        if ocp.max_torque > 0.0:
            limits.append({"type": "ineq", "fun": torque_room})
        if ocp.zones and ocp.horizon > 2:
            limits.append({"type": "ineq", "fun": zone_room})
        return limits

    def _solution(
        self, u: Array, state: tuple[Array, Array], target: Reference, status: Status,
        iterations: int, started: float,
    ) -> Solution:  # fmt: skip
        ocp = self.ocp
        try:
            horizon = Horizon(self._plain, u, *state, target)
        except GncError:
            return failed(ocp, state, target, Status.UNSOLVABLE_STEP, self.formulation)
        gradient = horizon.gradient()
        if ocp.max_torque > 0.0:
            for k in np.flatnonzero(np.linalg.norm(u, axis=1) >= ocp.max_torque * (1.0 - 1e-6)):
                gradient[k] -= (gradient[k] @ u[k]) / (u[k] @ u[k]) * u[k]
        norm = float(np.linalg.norm(gradient)) / (2.0 * ocp.time_step)
        if norm <= SETTLED * self._units.multiplier:
            status = Status.CONVERGED
        torques = np.ascontiguousarray(u @ ocp.torque_map.T)
        plan = (horizon.attitudes, horizon.momenta, torques, horizon.costates)
        outcome = (status, iterations, norm, self._plain.cost(u, *state, target))
        largest = float(np.linalg.norm(u, axis=1).max())
        solution = assemble(ocp, plan, target, outcome, largest, self.formulation)
        return solution.replace(solve_time=perf_counter() - started)


class FsolveSolver:
    """MINPACK's hybrid method on the shooting equations (44), with numerical derivatives.

    The role of MATLAB's fsolve in Gupta et al. 2015, section III.

    Parameters
    ----------
    ocp : AttitudeOcp
    tolerance : float
        Largest Euclidean norm of (44) that counts as solved, relative to max |lambda2|, as
        `ShootingOptions.residual_tolerance`.
    """

    formulation = "fsolve"

    def __init__(self, ocp: AttitudeOcp, tolerance: float = 1e-10) -> None:
        self.ocp = require_kind("ocp", ocp, AttitudeOcp)
        self._tolerance = require_positive("tolerance", tolerance)
        self._units = Units.of(ocp)
        n = ocp.horizon
        self._horizon = (
            np.empty((n + 1, 3, 3)), np.empty((n + 1, 3)), np.empty((n, 3)), np.empty((n, 6)),
            np.zeros((n, work_size(ocp.n_controls))),
        )  # fmt: skip

    def warm_up(self) -> None:
        """Compile or load the kernels."""
        self.solve(np.eye(3), np.zeros(3))

    def memory(self) -> tuple[()]:
        """Return what the next solve takes over from those before: nothing."""
        return ()

    def recall(self, memory: tuple[()]) -> None:
        """Nothing is remembered."""

    def solve(
        self,
        attitude: ArrayLike,
        momentum: ArrayLike,
        reference: Tracked | None = None,
        warm_start: Array | None = None,
    ) -> Solution:
        """Solve from a state; arguments and failures as `ShootingSolver.solve`."""
        from scipy.optimize import root  # as above

        started = perf_counter()
        ocp = self.ocp
        state = (as_rotation("attitude", attitude), as_vector3("momentum", momentum))
        target = as_reference(reference)
        problem = (ocp.body.packed, ocp.data, ocp.zone_rows, track_of(ocp, target))
        R, Pi, u, lam, W = self._horizon
        R[0], Pi[0] = state

        unit = self._units.multiplier * np.repeat([1.0 / _shooting_kernels.lever(problem), 1.0], 3)

        def residual(x: Array) -> Array:
            lam[0] = x * unit
            status, E1, E2 = _shooting_kernels.propagate_horizon(*problem, *self._horizon)
            return np.array([*E1, *E2]) / unit if status == 0 else np.full(6, FAR)

        first = np.zeros(6) if warm_start is None else ocp.checked_warm_start(warm_start)[0]
        found = root(residual, first / unit, method="hybr", options={"xtol": 1e-14})
        lam[0] = found.x * unit
        code, E1, E2 = _shooting_kernels.propagate_horizon(*problem, *self._horizon)
        if code != 0 or not np.isfinite(R).all():
            status = Status(code) if code != 0 else Status.NOT_FINITE
            return failed(ocp, state, target, status, self.formulation)
        norm = self._units.multiplier * float(np.linalg.norm(np.array([*E1, *E2]) / unit))
        allowed = max(self._tolerance * largest_row(lam, 3), rounding_of(ocp.data, problem[3], Pi))
        solved = bool(norm <= allowed)
        status = Status.CONVERGED if solved else Status.LINE_SEARCH_FAILED
        outcome = (status, int(found.nfev), norm, horizon_cost(*problem[1:], R, Pi, W))
        largest = float(np.linalg.norm(W[:, Z_AT:], axis=1).max())
        plan = (R.copy(), Pi.copy(), u.copy(), lam.copy())
        solution = assemble(ocp, plan, target, outcome, largest, self.formulation)
        if solved:
            curvature = linearize(solution).min_curvature
            status = Status.CONVERGED if curvature > 0.0 else Status.SADDLE
            solution = solution.replace(min_curvature=curvature, status=status)
        return solution.replace(solve_time=perf_counter() - started)
