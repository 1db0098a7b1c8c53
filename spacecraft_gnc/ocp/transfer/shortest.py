"""Shortest feasible time of a transfer, by bisection over the number of steps."""

from __future__ import annotations

import math
from dataclasses import replace

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.ocp.transfer.certificate import shortest_possible_steps
from spacecraft_gnc.ocp.transfer.problem import AttitudeTransfer
from spacecraft_gnc.ocp.transfer.solution import TransferSolution
from spacecraft_gnc.ocp.transfer.solver import TransferSolver


def shortest_transfer(
    problem: AttitudeTransfer, solver: TransferSolver | None = None
) -> TransferSolution:
    """Return the plan with the fewest steps for which one is found, by bisection.

    Below it none was found; that none exists is proven only below `shortest_possible_steps`.

    Raises
    ------
    ParameterError
        If none is found in 64 times the time of the problem.
    """
    solver = solver or TransferSolver()
    low = shortest_possible_steps(problem) - 1
    high = max(low + 1, 2)
    best = None
    while best is None:
        solution = solver.solve(replace(problem, n_steps=high))
        if solution.converged:
            best = solution
        elif high > 64 * max(problem.n_steps, low + 1):
            raise ParameterError(
                f"problem: received a transfer for which no plan was found in up to {high} steps; "
                "required one within the bounds; widen them"
            )
        else:
            low, high = high, math.ceil(1.3 * high)
    while high - low > 1:
        middle = (low + high) // 2
        solution = solver.solve(replace(problem, n_steps=middle))
        if solution.converged:
            best, high = solution, middle
        else:
            low = middle
    return best
