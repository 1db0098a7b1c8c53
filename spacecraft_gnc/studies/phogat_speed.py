"""Speed of the planner: over the number of steps, and beside IPOPT."""

from __future__ import annotations

import itertools
from typing import Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.ocp.transfer import TransferSolver
from spacecraft_gnc.studies.phogat_compare import Comparison
from spacecraft_gnc.studies.phogat_transfers import BODY, figure_4, random_transfer
from spacecraft_gnc.studies.speed import quantiles

STEPS: Final = 190  # of figure 4
LENGTHS: Final = (100, 200, 500, 1000, 2000)
_SECONDS: Final = 19.0


class Length(NamedTuple):
    """Figure 4 with another number of steps in the same time."""

    n_steps: int
    time: float
    """From the straight start, with the certificate [s]."""
    iterations: int
    """Newton steps."""


def time_lengths(lengths: tuple[int, ...] = LENGTHS, repeats: int = 15) -> tuple[Length, ...]:
    """Time figure 4 over the number of steps: the shortest of some solves each."""
    solver = TransferSolver(starts=1)
    found = []
    for n in lengths:
        problem = figure_4(body=RigidBody(BODY.inertia, _SECONDS / n), n_steps=n)
        plans = [solver.solve(problem) for _ in range(repeats + 1)][1:]
        found.append(Length(n, min(plan.solve_time for plan in plans), plans[0].iterations))
    return tuple(found)


def growth(found: tuple[Length, ...]) -> float:
    """Return the power of N with which the time of a Newton step grows; linear: 1."""
    n, time, iterations = np.array(found).T
    return float(np.polyfit(np.log(n), np.log(time / iterations), 1)[0])


def time_planner(count: int = 200) -> dict[str, Any]:
    """Time the plans of random transfers of 190 steps: every start, with the certificate.

    ``solves``: of those that have a plan; ``lengths``: figure 4 over the number of steps.
    """
    solver = TransferSolver()
    solver.solve(random_transfer(0, STEPS))
    plans = [solver.solve(random_transfer(index, STEPS)) for index in range(count)]
    solves = np.array([plan.solve_time for plan in plans if plan.converged])
    lengths = time_lengths()
    return {
        "solves": quantiles(solves),
        "lengths": [length._asdict() for length in lengths],
        "growth": growth(lengths),
    }


def time_beside_ipopt(count: int = 20) -> dict[str, Any]:
    """Time the same transfers of 190 steps by ours and by IPOPT, both from the straight start."""
    comparison, solver = Comparison(), TransferSolver(starts=1)
    times: list[tuple[float, float]] = []
    for problem in (random_transfer(index, STEPS) for index in itertools.count()):
        if len(times) == count:
            break
        if solver.solve(problem).converged:
            times.append(comparison.times(problem))
    ours, ipopts = np.array(times)[np.isfinite(times).all(axis=1)].T
    return {"ours": quantiles(ours), "ipopt": quantiles(ipopts), "ratio": quantiles(ipopts / ours)}
