"""Speed of the planner: over the number of steps, and beside IPOPT."""

from __future__ import annotations

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


def time_lengths(lengths: tuple[int, ...] = LENGTHS, repeats: int = 5) -> tuple[Length, ...]:
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
    """Time random transfers of 190 steps: whole calls with every start, those that are solved."""
    solver = TransferSolver()
    plans = [solver.solve(random_transfer(index, STEPS)) for index in range(-1, count)][1:]
    return quantiles(np.array([plan.solve_time for plan in plans if plan.converged]))


def time_beside_ipopt(count: int = 20) -> dict[str, Any]:
    """Time the same transfers by ours and by IPOPT, both from the straight start."""
    comparison = Comparison()
    found = [comparison.of(random_transfer(index, STEPS)) for index in range(count)]
    times = np.array([(one.ours, one.ipopts) for one in found])
    ours, ipopts = times[np.isfinite(times).all(axis=1)].T
    return {"ours": quantiles(ours), "ipopt": quantiles(ipopts), "ratio": quantiles(ipopts / ours)}
