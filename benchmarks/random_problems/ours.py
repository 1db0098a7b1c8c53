"""What this project's solver makes of the random problems, in one or two sets of units."""

from __future__ import annotations

import math
import traceback
from typing import Any

import numpy as np
from draw import Drawn, draw, in_units

from spacecraft_gnc.errors import GncError
from spacecraft_gnc.ocp import (
    AutomaticContinuation,
    ShootingOptions,
    ShootingSolver,
    cheapest,
)

Account = dict[str, Any]
BEYOND = "its motion has a step that Kalabic et al. 2014, (3) rules out"


def solved(problem: Drawn, options: ShootingOptions) -> Account:
    """Return how the solves of a problem ended, with the controls freed of their units."""
    account: Account = {"seed": problem.seed}
    try:
        account |= _solved_in(problem, problem.units, options, patient=True)
        if problem.other_units is not None:
            other = _solved_in(problem, problem.other_units, options, patient=False)
            other["exact"] = _are_powers(problem.units, problem.other_units)
            account |= {"other": other, "unlike": difference(account, other)}
    except Exception:  # noqa: BLE001 - it is what is looked for
        account["exception"] = traceback.format_exc()
    return account


def _solved_in(
    problem: Drawn, units: tuple[float, float, float], options: ShootingOptions, *, patient: bool
) -> Account:
    """Solve from nothing; where that fails or takes long and it is ``patient``, as in flight."""
    ocp, state = in_units(problem, units)
    solution = direct = ShootingSolver(ocp, options=options).solve(*state)
    way = "cold"
    if patient and not (direct.converged and direct.iterations <= AutomaticContinuation.patience):
        solution = cheapest((direct, AutomaticContinuation(ocp, options).solve(*state)))
        way = "cold" if solution.torques is direct.torques else "other starts"
    torque = units[0] / (units[1] * units[1])
    finite = bool(np.isfinite(solution.controls).all())
    return {
        "cold": direct.status.name,
        "iterations": direct.iterations,
        "status": solution.status.name,
        "way": way,
        "residual": float(solution.residual) if np.isfinite(solution.residual) else None,
        "cost": solution.cost / units[2] if np.isfinite(solution.cost) else None,
        "curvature": solution.min_curvature if np.isfinite(solution.min_curvature) else None,
        "controls": (solution.controls / torque).tolist() if finite else None,
        "direct": (direct.controls / torque).tolist(),
    }


def within_reach(row: Account) -> Account:
    """Return a result of IPOPT; as unsolved where our integrator has no step along its motion.

    The model solves the equation of a step by its own root finder, also beyond (3).
    """
    if row["solved"]:
        problem = draw(row["seed"])
        ocp, state = in_units(problem, (1.0, 1.0, 1.0))
        try:
            ocp.rollout(row["controls"], *state[:2])
        except GncError:
            return row | {"solved": False, "said": BEYOND}
    return row


def _are_powers(units: tuple[float, ...], others: tuple[float, ...]) -> bool:
    """Tell whether units differ by powers of two: every rounding is then the same."""
    ratios = [other / unit for unit, other in zip(units, others, strict=True)]
    return all(math.frexp(ratio)[0] == 0.5 for ratio in ratios)


def difference(one: Account, other: Account) -> float | None:
    """Return by how much the direct solves' controls differ, relative to the largest."""
    if one["cold"] != "CONVERGED" or other["status"] != "CONVERGED":
        return None
    first, second = np.array(one["direct"]), np.array(other["direct"])
    largest = np.abs(first).max()
    return float(np.abs(first - second).max() / largest) if largest > 0.0 else 0.0
