"""Transfers solved by the planner and by CasADi with IPOPT, from the same starts."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any, Final, NamedTuple

from spacecraft_gnc.extras import explained_imports
from spacecraft_gnc.ocp.transfer import AttitudeTransfer, TransferSolution, TransferSolver
from spacecraft_gnc.ocp.transfer.starts import NAMES, STRAIGHT, Start, make_start
from spacecraft_gnc.status import Status
from spacecraft_gnc.studies.phogat_transfers import BODY, random_start

AGREE: Final = 1e-6
"""Largest relative difference of two costs that are called the same."""
_RANDOM_STARTS: Final = 5
_REPEATS: Final = 3  # timed solves, of which the shortest counts


class Compared(NamedTuple):
    """A transfer solved by both."""

    plan: TransferSolution
    """By all starts of ours."""
    ipopt_cost: float
    """The least that IPOPT found; NaN where none of its starts led to a plan."""
    ipopt_starts: int
    ours: float
    """Time of a solve from the straight start [s]; NaN where one of both finds no plan from it."""
    ipopts: float

    @property
    def difference(self) -> float:
        """Relative difference of the costs; NaN where one of them found no plan."""
        if not self.plan.converged:
            return math.nan
        return (self.plan.cost - self.ipopt_cost) / self.ipopt_cost

    @property
    def outcome(self) -> str:
        """Who solved it, in words."""
        by_ipopt = math.isfinite(self.ipopt_cost)
        if not self.plan.converged:
            proven = self.plan.status == Status.INFEASIBLE
            return f"{'proven infeasible' if proven else 'not solved'}, {_NOT_OURS[by_ipopt]}"
        if not by_ipopt:
            return "solved by ours alone"
        if abs(self.difference) <= AGREE:
            return "solved by both, the same cost"
        return f"solved by both, ours costs {'more' if self.difference > 0.0 else 'less'}"


_NOT_OURS: Final = {True: "solved by IPOPT", False: "not solved by IPOPT either"}


class Comparison:
    """Both solvers; IPOPT's problem of each number of steps is built once."""

    def __init__(self) -> None:
        self._built: dict[int, Any] = {}

    def of(self, problem: AttitudeTransfer) -> Compared:
        """Solve a transfer of the paper's spacecraft by both.

        The solves from the straight start are timed. Where IPOPT finds another cost from it, or no
        plan, it is given further starts: those of ours if they led to a plan, and random ones.
        """
        plan, start = TransferSolver().solve(problem), make_start(problem, STRAIGHT)
        ipopt = self._ipopt(problem.n_steps)
        first = ipopt.solve(problem, start)
        cost, starts = first.cost if first.solved else math.inf, 1
        if plan.status != Status.INFEASIBLE:
            for further in _further_starts(plan):
                if plan.converged and cost <= plan.cost * (1.0 + AGREE):
                    break
                answer = ipopt.solve(problem, further)
                cost, starts = min(cost, answer.cost if answer.solved else math.inf), starts + 1
        times = self.times(problem) if first.solved else (math.nan, math.nan)
        return Compared(plan, cost if math.isfinite(cost) else math.nan, starts, *times)

    def times(self, problem: AttitudeTransfer) -> tuple[float, float]:
        """Return the times of ours and of IPOPT from the straight start [s]; NaN if one fails."""
        start, ipopt = make_start(problem, STRAIGHT), self._ipopt(problem.n_steps)
        if not (_alone(problem, start).converged and ipopt.solve(problem, start).solved):
            return math.nan, math.nan
        return (
            _least(lambda: _alone(problem, start).solve_time),
            _least(lambda: ipopt.solve(problem, start).solve_time),
        )

    def _ipopt(self, n_steps: int) -> Any:
        if n_steps not in self._built:
            with explained_imports():
                from spacecraft_gnc.studies.phogat_ipopt import TransferIpopt
            self._built[n_steps] = TransferIpopt(BODY.inertia, n_steps)
        return self._built[n_steps]


def _further_starts(plan: TransferSolution) -> Iterator[Start]:
    if plan.converged:
        yield from (make_start(plan.problem, name) for name in NAMES[1:])
    yield from (random_start(plan.problem, seed) for seed in range(_RANDOM_STARTS))


def _alone(problem: AttitudeTransfer, start: Start) -> TransferSolution:
    """Solve from one start, as IPOPT does."""
    return TransferSolver().solve(problem, (start.torque, start.momentum))


def _least(call: Callable[[], float]) -> float:
    return min(call() for _ in range(_REPEATS))
