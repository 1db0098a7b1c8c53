"""Judge solutions of the random problems by an independent model, and solve them by IPOPT.

`model.py PROBLEMS IPOPT CHECKS PART PARTS` runs in the environment of the peers. PROBLEMS holds a
drawn problem on each line, with our controls; IPOPT and CHECKS get a line for each problem whose
horizon is PART modulo PARTS. What IPOPT already holds is not solved again.
"""

from __future__ import annotations

import json
import sys
from functools import cache
from pathlib import Path
from time import perf_counter
from typing import Any

import casadi as ca
import numpy as np
from judge import lines
from newton import Array, Problem, program
from program import STATE

IPOPT = {
    "print_time": False,
    "calc_lam_p": False,
    "ipopt": {
        "tol": 1e-10, "constr_viol_tol": 1e-11, "max_iter": 1000, "max_cpu_time": 30.0,
        "acceptable_iter": 0, "print_level": 0, "sb": "yes",
    },
}  # fmt: skip
NOTHING = 1e-20  # control, in units of the limit, that is zero but for rounding
POLISH = 8  # Newton steps that bring IPOPT's solution to rounding


@cache
def solver(horizon: int, controls: int) -> ca.Function:
    """Return IPOPT for a horizon."""
    return program(horizon, controls).solver(IPOPT)


def relative(steps: Array, v: Array) -> float:
    """Return the largest correction relative to the largest control; on the target, to the unit."""
    return float(np.abs(steps).max() / max(np.abs(v).max(), NOTHING))


def checked(problem: Problem, controls: list[list[float]]) -> dict[str, Any]:
    """Return what the model says of a solution."""
    v = np.array(controls) / problem.scale
    try:
        steps, positive, _ = problem.newton(v)
        cost, moved = problem.cost(v)
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        return {"seed": problem.seed, "fault": str(error)}
    return {
        "seed": problem.seed,
        "correction": relative(steps, v),
        "positive": positive,
        "cost": cost,
        "moved": moved,
    }


def by_ipopt(problem: Problem) -> dict[str, Any]:
    """Return what IPOPT finds from the free motion."""
    f = problem.program
    n, m = f.horizon, f.controls
    row: dict[str, Any] = {"seed": problem.seed, "solved": False}
    try:
        v = np.zeros((n, m))
        states = problem.rollout(v)
        moved = problem.cost(v)[1]
    except ArithmeticError as error:
        return row | {"said": f"start: {error}"}
    scaled = problem.values | {"cost_scale": 1.0 / moved if moved > 0.0 else 1.0}
    first = np.concatenate([np.concatenate([v[k], states[k + 1]]) for k in range(n)])
    ipopt = solver(n, m)
    begun = perf_counter()
    found = ipopt(x0=first, p=np.concatenate([problem.start, f.pack(scaled)]), lbg=0.0, ubg=0.0)
    stats = ipopt.stats()
    row |= {
        "said": stats["return_status"],
        "iterations": stats["iter_count"],
        "seconds": perf_counter() - begun,
    }
    if not stats["success"]:
        return row
    v = found["x"].full().reshape(n, m + STATE)[:, :m]
    return row | _polished(problem, v)


def _polished(problem: Problem, v: Array) -> dict[str, Any]:
    """Return IPOPT's minimum to rounding; it counts as solved where the integrator can go there."""
    try:
        for _ in range(POLISH):
            steps, positive, _ = problem.newton(v)
            if not positive:
                return {"said": "no minimum", "solved": False}
            if relative(steps, v) > 1e-2:
                return {"said": "not at a minimum", "solved": False}
            v = v + steps
            if relative(steps, v) < 1e-13:
                break
        cost, moved = problem.cost(v)
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        return {"said": str(error), "solved": False}
    controls = (problem.scale * v).tolist()
    return {"solved": True, "cost": cost, "moved": moved, "controls": controls}


def main() -> None:
    """Solve and check this part of the problems."""
    given, ipopt, checks = (Path(name) for name in sys.argv[1:4])
    part, parts = (int(number) for number in sys.argv[4:6])
    known = {row["seed"] for row in lines(ipopt)}
    rows = [row for row in lines(given) if row["drawn"]["horizon"] % parts == part]
    with checks.open("a", encoding="utf-8") as said, ipopt.open("a", encoding="utf-8") as solved:
        for row in rows:
            problem = Problem(row["drawn"])
            if row["controls"] is not None:
                print(json.dumps(checked(problem, row["controls"])), file=said, flush=True)
            if problem.seed not in known:
                print(json.dumps(by_ipopt(problem)), file=solved, flush=True)
            print(problem.seed, flush=True)  # what the driver counts


if __name__ == "__main__":
    main()
