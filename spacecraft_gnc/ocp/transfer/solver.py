"""Multiple shooting with momentum and torque bounds, on the structure of the problem.

Each start first follows a homotopy to the bounds (an interior-point method on the conditions
(5.9)), which says where they act; Algorithm 2 then solves the conditions with these sets, changing
them where a multiplier or a bound says so. Both solve the same linear system, by one Riccati
recursion along the stages. docs/planner.md says what is the paper's and what was added.

Source: Phogat et al., Algorithm 2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from time import perf_counter
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.arguments import as_count, as_limit, require_kind, require_positive
from spacecraft_gnc.arrays import as_finite
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.ocp.transfer._active_kernels import active_set, is_minimum
from spacecraft_gnc.ocp.transfer._found import Found, best_of
from spacecraft_gnc.ocp.transfer._interior_kernels import interior
from spacecraft_gnc.ocp.transfer.certificate import is_too_short, time_bound_text
from spacecraft_gnc.ocp.transfer.conditions import Residuals, evaluate, units
from spacecraft_gnc.ocp.transfer.problem import AttitudeTransfer
from spacecraft_gnc.ocp.transfer.solution import TransferSolution, Tried
from spacecraft_gnc.ocp.transfer.starts import NAMES, Start, make_start, to_try
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array

_BISECTIONS: Final = 9
_LEAST_CURVATURE: Final = 1e-9
_POLISH: Final = 40  # Newton steps of Algorithm 2
_FEASIBLE: Final = (Status.CONVERGED, Status.SADDLE)


@dataclass(frozen=True, slots=True)
class TransferSolver:
    """Solve an `AttitudeTransfer`.

    Attributes
    ----------
    starts : int
        How many of the deterministic starts `starts.NAMES` are tried, at least; the rest are where
        these lead to no minimum. Where other ways round may be cheaper, these are tried too.
    homotopy : bool
        Whether the homotopy precedes Algorithm 2; without it the method is the paper's.
    tolerance : float
        Largest residual of (5.6)-(5.8), relative to the units of torque and momentum.
    max_iterations : int
        Newton steps of the homotopy. Starts that lead to a minimum take 15 to 80.

    Raises
    ------
    ParameterError
        If an argument is refused.
    """

    starts: int = 3
    homotopy: bool = True
    tolerance: float = 1e-8
    max_iterations: int = 80

    def __post_init__(self) -> None:
        as_count("starts", self.starts, most=len(NAMES))
        require_positive("tolerance", self.tolerance)
        as_count("max_iterations", self.max_iterations)

    def solve(
        self,
        problem: AttitudeTransfer,
        start: tuple[Array, Array] | None = None,
        *,
        max_work: float = 0.0,
    ) -> TransferSolution:
        """Find the plan of the least torque.

        Parameters
        ----------
        problem : AttitudeTransfer
        start : pair of (N, 3) and (N+1, 3) arrays, optional
            Torque [N m] and momentum [N m s] to start from, in place of the starts of its own.
        max_work : float
            `TransferSolution.work` at which the search ends, the same on any machine; 0: none.

        Raises
        ------
        ShapeError, ParameterError
            If an argument is refused. What does not converge is told by the status.
        """
        require_kind("problem", problem, AttitudeTransfer)
        begun = perf_counter()
        arena, most = _arena(problem.n_steps), as_limit("max_work", max_work) or math.inf
        tried: list[tuple[str, Found]] = []
        if start is not None:
            torque, momentum = start
            N = problem.n_steps
            given = Start(
                "given",
                as_finite("torque", torque, (N, 3), f"{N} torques [N m]"),
                as_finite("momentum", momentum, (N + 1, 3), f"{N + 1} momenta [N m s]"),
            )
            tried.append((given.name, self._run(problem, given, arena, most)))
        elif is_too_short(problem, problem.n_steps, thorough=False):
            name = NAMES[0]
            tried.append((name, _not_run(problem, make_start(problem, name))))
        else:
            minima: list[str] = []
            for name in to_try(problem, self.starts, minima):
                left = most - sum(one.work for _, one in tried)
                if left <= 0.0:
                    break
                one = self._run(problem, make_start(problem, name), arena, left)
                tried.append((name, one))
                if one.status == Status.CONVERGED:
                    minima.append(name)
        found = best_of([one for _, one in tried])
        if found.status not in _FEASIBLE and is_too_short(problem, problem.n_steps):
            found = found._replace(status=Status.INFEASIBLE)
        summary = tuple(Tried(name, one.status, one.cost, one.iterations) for name, one in tried)
        work = sum(one.work for _, one in tried)
        return self._conclude(problem, found, summary, arena, work, begun)

    def _run(self, problem: AttitudeTransfer, start: Start, arena: Any, work: float) -> Found:
        """Return what one start leads to with an amount of work."""
        body, h, N = problem.body.packed, problem.body.time_step, problem.n_steps
        first = np.ascontiguousarray(problem.goal.T @ problem.start).ravel()
        scales, told = _scales(problem), np.zeros(3)
        passes = work / N
        u, Pi = start.torque.copy(), start.momentum.copy()
        Pi[0], Pi[-1] = problem.start_momentum, problem.goal_momentum
        plan = (u, Pi, -u / h, np.zeros(3))
        multipliers = (np.zeros((N, 3)), np.zeros((N + 1, 3)))
        sets = (np.zeros((N, 3), dtype=np.int64), np.zeros((N + 1, 3), dtype=np.int64))
        spent = 0
        if self.homotopy:
            z = tuple(np.zeros((n, 3)) for n in (N, N, N + 1, N + 1))
            status = interior(
                body, h, first, scales, problem.limits, self.max_iterations, passes, plan, z, arena,
                told,
            )  # fmt: skip
            spent = int(told[0])
            if status != Status.CONVERGED and told[1] > 1e-4:
                return Found(Status(status), plan, multipliers, sets, spent, *_told(told, N))
            _identify(problem, plan, z, scales, multipliers, sets)
        status = active_set(
            body, h, first, scales, problem.limits, _POLISH, passes, plan, multipliers, sets, arena,
            told,
        )  # fmt: skip
        if status == Status.CONVERGED and not _curved(problem, sets, scales, arena, 0.0):
            status = Status.SADDLE
        spent += int(told[0])
        return Found(Status(status), plan, multipliers, sets, spent, *_told(told, N))

    def _conclude(
        self,
        problem: AttitudeTransfer,
        found: Found,
        tried: tuple[Tried, ...],
        arena: Any,
        work: float,
        begun: float,
    ) -> TransferSolution:
        """Return the solution of the best start, with its certificate."""
        h = problem.body.time_step
        u, Pi, lam, m = found.plan
        zu, zp = found.multipliers
        status, curvature, reason = found.status, math.nan, ""
        try:
            attitudes, _ = problem.body.simulate(problem.start, problem.start_momentum, u)
            zeta = h * h * (attitudes[1].T @ attitudes[-1] @ m)
            residuals, attitudes = evaluate(problem, u, Pi, h * lam, zeta, zu, zp)
        except GncError:  # what did not converge need not be a motion
            attitudes, zeta = np.full((problem.n_steps + 1, 3, 3), math.nan), np.full(3, math.nan)
            residuals = Residuals(*[math.inf] * len(Residuals._fields))
        if status == Status.CONVERGED:
            if not residuals.largest <= self.tolerance:
                status = Status.LINE_SEARCH_FAILED
            else:
                curvature = self._least_curvature(problem, found, arena)
                if curvature <= 0.0:
                    status = Status.SADDLE
        if status == Status.INFEASIBLE:
            reason = time_bound_text(problem)
        elif status == Status.CONVERGED:
            reason = "the conditions hold, and the reduced Hessian is positive definite"
        else:
            starts = ", ".join(f"{one.start}: {one.status.text}" for one in tried)
            reason = f"no plan was found ({starts}), nor a proof that there is none"
        return TransferSolution(
            problem=problem,
            status=status,
            torque=u,
            momentum=Pi,
            attitude=attitudes,
            co_momentum=h * lam,
            zeta=zeta,
            torque_multipliers=zu,
            momentum_multipliers=zp,
            active_torque=found.sets[0],
            active_momentum=found.sets[1],
            cost=found.cost,
            residuals=residuals,
            min_curvature=curvature,
            iterations=found.iterations,
            work=work,
            tried=tried,
            reason=reason,
            solve_time=perf_counter() - begun,
        )

    def _least_curvature(self, problem: AttitudeTransfer, found: Found, arena: Any) -> float:
        """Return a lower bound on the least curvature, by bisection; 0 or less: none is proven."""
        scales = _scales(problem)
        _linearize(problem, found, arena)
        if not _curved(problem, found.sets, scales, arena, _LEAST_CURVATURE):
            return 0.0
        low, high = _LEAST_CURVATURE, 1.0
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            if _curved(problem, found.sets, scales, arena, middle):
                low = middle
            else:
                high = middle
        return low


def _told(told: Array, n_steps: int) -> tuple[float, float]:
    """Return error and work, of what the kernels told."""
    return float(told[1]), n_steps * float(told[2])


def _scales(problem: AttitudeTransfer) -> Array:
    """Return the units of torque and momentum, and the natural weights of the end (4,)."""
    torque, momentum = units(problem)
    h, N = problem.body.time_step, problem.n_steps
    moment = float(np.linalg.eigvalsh(problem.body.inertia)[-1])
    return np.array([torque, momentum, 12.0 * moment**2 / (h**4 * N**3), 1.0 / (h * h * N)])


def _identify(
    problem: AttitudeTransfer,
    plan: tuple[Array, ...],
    z: tuple[Array, ...],
    scales: Array,
    multipliers: tuple[Array, Array],
    sets: tuple[NDArray[np.int64], NDArray[np.int64]],
) -> None:
    """Set active sets and multipliers from the end of the homotopy."""
    inner = slice(1, problem.n_steps)
    natural = float(scales[0]) / problem.duration  # of the multipliers of the momentum
    for which, part, unit in ((0, slice(None), 1.0), (1, inner, natural / float(scales[1]))):
        x = plan[which][part]
        low, high = problem.limits[2 * which : 2 * which + 2]
        zl, zh = z[2 * which][part], z[2 * which + 1][part]
        sets[which][part] = np.where(
            zl > unit * (x - low), -1, np.where(zh > unit * (high - x), 1, 0)
        )
        multipliers[which][part] = np.where(sets[which][part] != 0, zh - zl, 0.0)


def _curved(problem: AttitudeTransfer, sets: Any, scales: Array, arena: Any, least: float) -> bool:
    """Whether the reduced Hessian of the last linearization is at least ``least``."""
    _, gap, stage, D, g, Dp, gp, *_, step, _ = arena
    h = problem.body.time_step
    return bool(is_minimum(h, stage, sets, scales, least, D, g, Dp, gp, gap, step))


def _linearize(problem: AttitudeTransfer, found: Found, arena: Any) -> None:
    """Linearize about a plan, into the arena: Algorithm 2 without a step."""
    first = np.ascontiguousarray(problem.goal.T @ problem.start).ravel()
    active_set(
        problem.body.packed, problem.body.time_step, first, _scales(problem), problem.limits, 0,
        math.inf, found.plan, found.multipliers, found.sets, arena, np.zeros(3),
    )  # fmt: skip


def _not_run(problem: AttitudeTransfer, start: Start) -> Found:
    """Return a start that was not followed, as the transfer is proven to be infeasible."""
    N = problem.n_steps
    plan = (start.torque, start.momentum, -start.torque / problem.body.time_step, np.zeros(3))
    sets = (np.zeros((N, 3), dtype=np.int64), np.zeros((N + 1, 3), dtype=np.int64))
    zeros = (np.zeros((N, 3)), np.zeros((N + 1, 3)))
    return Found(Status.INFEASIBLE, plan, zeros, sets, 0, math.inf, 0.0)


def _arena(n_steps: int) -> Any:
    """Return the arrays that the kernels work in."""
    N, e = n_steps, np.empty
    step = (e((N, 39)), e((6, 6)), e(6), e(6), e((N, 3)), e((N + 1, 3)), e((N, 3)))
    trial = (e((N, 3)), e((N + 1, 3)), e((N, 4)), e((N, 3)))
    return (
        e((N, 4)), e((N, 3)), e((N + 1, 45)), e((N, 3)), e((N, 3)), np.zeros((N + 1, 3)),
        np.zeros((N + 1, 3)), e((N, 3)), e((N + 1, 3)), e((N, 3)), e((N + 1, 3)), step, trial,
    )  # fmt: skip
