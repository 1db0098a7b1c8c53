"""Where single shooting loses its accuracy, what the backward sweep costs, what certificates cost.

python benchmarks/horizons.py [--jumps]

The spacecraft, weights and limit of Gupta's Case I, with other horizons. Times are medians of warm
solves along 200 steps of the closed loop, the best of five flights. ``--jumps``: solves from states
that have nothing to do with one another, warm, cold, and by the automatic continuation.
"""

from __future__ import annotations

import sys
from collections import Counter
from time import perf_counter

import numpy as np
from numba import njit

from spacecraft_gnc import lie
from spacecraft_gnc.ocp import (
    AttitudeOcp,
    AutomaticContinuation,
    ShootingOptions,
    ShootingSolver,
    Status,
    Weights,
    cheapest,
)
from spacecraft_gnc.ocp._solve_kernels import summarize
from spacecraft_gnc.ocp._sweep_kernels import smallest_pivot
from spacecraft_gnc.ocp.linearization import factorization

HORIZONS = (1, 2, 5, 10, 20, 40, 60, 80, 100)
START = lie.exp(np.array([0.25, 0.5, 0.5]))
REPEATS = 5
CALLS = 100_000
DEARER = 1.0 + 1e-6


def problem(horizon: int) -> AttitudeOcp:
    """Case I with another horizon."""
    return AttitudeOcp(np.diag([1.0, 0.8, 0.8]), 0.4, horizon, Weights(), 0.01, 1e10)


def fly(solver: ShootingSolver, steps: int = 200) -> tuple[float, Counter[str]]:
    """Median time of a solve along the closed loop of exact torques [s], and the statuses."""
    exact = ShootingSolver(solver.ocp)
    attitude, momentum = START, np.zeros(3)
    times, statuses, warm, exact_warm = [], Counter[str](), None, None
    for _ in range(steps):
        solution = solver.solve(attitude, momentum, None, warm)
        truth = exact.solve(attitude, momentum, None, exact_warm)
        times.append(solution.solve_time)
        statuses[solution.status.name] += 1
        warm, exact_warm = solution.warm_start, truth.warm_start
        attitude, momentum = solver.ocp.body.step(attitude, momentum, truth.torques[0])
    return float(np.median(times)), statuses


def row(horizon: int) -> str:
    """One line of the table."""
    ocp = problem(horizon)
    cells = [f"{horizon:4d}"]
    truth = ShootingSolver(ocp).solve(START, np.zeros(3))
    cells.append(f"{truth.iterations:5d}")
    for formulation in ("backward_sweep", "single_shooting"):
        solver = ShootingSolver(ocp, options=ShootingOptions(formulation=formulation))
        flights = [fly(solver) for _ in range(REPEATS)]
        time, statuses = min(flights, key=lambda flight: flight[0])
        cells.append(f"{time * 1e6:9.1f}")
        cells.append(f"{sum(statuses.values()) - statuses['CONVERGED']:5d}")
    cold = solver.solve(START, np.zeros(3))
    error = np.abs(cold.torques - truth.torques).max()
    word = f"{error:.1e}" if cold.status == Status.CONVERGED else cold.status.name
    return "  ".join([*cells, word])


@njit
def certify(calls, h, fac, zones, reference, attitudes, work, margins):  # type: ignore[no-untyped-def]
    """Curvature, margins and angles of one solve, many times."""
    total = 0.0
    for _ in range(calls):
        total += smallest_pivot(h, fac)
        total += summarize(zones, reference, attitudes, work, margins)[0]
    return total


def certificates() -> tuple[float, float]:
    """Time of the certificates of one Case I solve, and of the solve [s]."""
    ocp = problem(5)
    solver = ShootingSolver(ocp)
    solution = solver.solve(START, np.zeros(3))
    fac = factorization(solution)
    work = np.zeros((5, 34))
    identity = tuple(np.eye(3).ravel())
    arguments = (0.4, fac, ocp.zone_rows, identity, solution.attitudes, work, np.empty(0))
    certify(1, *arguments)
    best = np.inf
    for _ in range(REPEATS):
        begun = perf_counter()
        certify(CALLS, *arguments)
        best = min(best, (perf_counter() - begun) / CALLS)
    return best, min(fly(solver)[0] for _ in range(REPEATS))


def jumps(horizon: int, count: int) -> str:
    """One line of the table of state jumps."""
    ocp = problem(horizon)
    solver, way = ShootingSolver(ocp), AutomaticContinuation(ocp)
    rng, warm, counts, times = np.random.default_rng(3), None, Counter[str](), []
    for _ in range(count):
        state = lie.exp(1.2 * rng.normal(size=3)), 0.05 * rng.normal(size=3)
        cold, plain = solver.solve(*state), solver.solve(*state, None, warm)
        begun = perf_counter()
        found = plain if plain.converged else cold
        if not found.converged or found.iterations > way.patience:
            found = cheapest((found, way.solve(*state)))
        times.append(perf_counter() - begun + plain.solve_time)
        counts["cold"] += cold.converged
        counts["warm"] += plain.converged
        counts["dear"] += plain.converged and cold.converged and plain.cost > DEARER * cold.cost
        counts["auto"] += found.converged
        counts["worse"] += cold.converged and found.cost > DEARER * cold.cost
        warm = found.warm_start
    numbers = [counts[name] for name in ("warm", "dear", "cold", "auto", "worse")]
    cells = [horizon, count, *numbers, f"{1e3 * np.median(times):.3g} ms"]
    return "| " + " | ".join(map(str, cells)) + " |"


def main() -> int:
    """Print the tables."""
    if sys.argv[1:] == ["--jumps"]:
        names = ("N", "jumps", "solved warm", "of these dearer than cold", "solved cold")
        names += ("solved as flown", "of these dearer than cold", "median time")
        print("| " + " | ".join(names) + " |")
        print("|---|---|---|---|---|---|---|---|")
        for horizon, count in ((5, 200), (20, 200), (100, 200), (300, 100)):
            print(jumps(horizon, count), flush=True)
        return 0
    print("warm solves; steps of 200 not solved; single shooting cold: its error in u, or status")
    print("   N  cold   sweep us  fail    single us  fail  single, cold start")
    for horizon in HORIZONS:
        print(row(horizon), flush=True)
    share, solve = certificates()
    print(
        f"certificates: {share * 1e9:.0f} ns of a warm solve of {solve * 1e6:.2f} us "
        f"({100.0 * share / solve:.1f} %)"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
