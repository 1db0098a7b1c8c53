"""What this project's solver makes of the random problems, in one or two sets of units."""

from __future__ import annotations

import traceback
from typing import Any

import numpy as np
from draw import Drawn, in_units

from spacecraft_gnc.ocp import (
    AttitudeOcp,
    PenaltyContinuation,
    ShootingOptions,
    ShootingSolver,
    Solution,
    StateContinuation,
)

Account = dict[str, Any]


def solved(problem: Drawn, options: ShootingOptions) -> Account:
    """Return how the solves of a problem ended, with the controls freed of their units."""
    account: Account = {"seed": problem.seed}
    try:
        account |= _solved_in(problem, problem.units, options, patient=True)
        if problem.other_units is not None:
            other = _solved_in(problem, problem.other_units, options, patient=False)
            account |= {"other": other, "unlike": difference(account, other)}
    except Exception:  # noqa: BLE001 - it is what is looked for
        account["exception"] = traceback.format_exc()
    return account


def _solved_in(
    problem: Drawn, units: tuple[float, float, float], options: ShootingOptions, *, patient: bool
) -> Account:
    """Solve from nothing; where that fails and the problem is ``patient``, by the continuations."""
    ocp, state = in_units(problem, units)
    solution = ShootingSolver(ocp, options=options).solve(*state)
    cold = solution.status.name
    iterations, way = solution.iterations, "cold"
    if patient and not solution.converged:
        way, solution = continued(ocp, state, options, solution)
    torque = units[0] / units[1] ** 2
    finite = bool(np.isfinite(solution.controls).all())
    return {
        "cold": cold,
        "iterations": iterations,
        "status": solution.status.name,
        "way": way,
        "residual": float(solution.residual) if np.isfinite(solution.residual) else None,
        "cost": solution.cost / units[2] if np.isfinite(solution.cost) else None,
        "curvature": solution.min_curvature if np.isfinite(solution.min_curvature) else None,
        "controls": (solution.controls / torque).tolist() if finite else None,
    }


def continued(
    ocp: AttitudeOcp,
    state: tuple[np.ndarray, ...],
    options: ShootingOptions,
    failed: Solution,
) -> tuple[str, Solution]:
    """Return the first continuation that reaches the problem, and its solution."""
    for way in (PenaltyContinuation, StateContinuation):
        solution = way(ocp, options).solve(*state)
        if solution.converged:
            return way.__name__, solution
    return "none", failed


def difference(one: Account, other: Account) -> float | None:
    """Return by how much the controls differ, relative to the largest; None without controls."""
    if one["cold"] != "CONVERGED" or other["status"] != "CONVERGED":
        return None
    first, second = np.array(one["controls"]), np.array(other["controls"])
    largest = np.abs(first).max()
    return float(np.abs(first - second).max() / largest) if largest > 0.0 else 0.0
