"""Neighboring extremals: whether their error bound holds, how often they answer, what they cost.

python benchmarks/neighboring.py

The spacecraft, weights and limit of Gupta's Case I, without and with pointing zones, and without
the limit, and random problems, flown in closed loop from random starts, up to 170 deg about a
random axis with some momentum. Each state is solved exactly as well, from the same warm start. The
true error of a step is that of all planned torques together, sqrt(sum_k |u_k - exact u_k|^2) with
both u_0 cut to the limit, and so not less than that of the torque flown. Times are medians of one
run, of corrected steps and of exact warm solves of the same states. Exits 1 where an error exceeds
its tolerance.
"""

from __future__ import annotations

import argparse
import itertools
import math
import sys
from dataclasses import dataclass, field

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.ocp import (
    AttitudeOcp,
    NeighboringExtremal,
    NeighboringOptions,
    PointingZone,
    ShootingSolver,
    Weights,
)
from spacecraft_gnc.ocp.neighboring import FORMULATION
from spacecraft_gnc.types import Array

LIMIT = 0.01  # [N m]
HORIZONS = (5, 10, 20, 60, 120)
NOISE = (0.0, 1e-5, 1e-4, 1e-3)  # of the attitude [rad]; of the momentum [N m s] a third of it
SETTINGS = ((1e-2, 10), (1e-4, 10), (1e-3, 3), (1e-3, 100))  # tolerance, max_age
GUPTA = PointingZone("exclusion", [1, 0, 0], [0.9276, 0.3736, 0.0], math.radians(4.9965), 1e3)
ZONES = {
    "Case I": (),
    "Case II, its zone": (GUPTA,),
    "four zones": (
        GUPTA,
        PointingZone("exclusion", [0, 1, 0], [0.2, 0.9, 0.3873], math.radians(10.0), 1e3),
        PointingZone("exclusion", [0, 0, 1], [0.7, 0.0, 0.7141], math.radians(8.0), 1e3),
        PointingZone("inclusion", [0, 0, 1], [0.0, 0.3, 0.9539], math.radians(60.0), 1e3),
    ),
    "no torque limit": (),
}


def problem(name: str, horizon: int) -> AttitudeOcp:
    """One of the cases with a horizon."""
    limit = 0.0 if name == "no torque limit" else LIMIT
    return AttitudeOcp(
        np.diag([1.0, 0.8, 0.8]), 0.4, horizon, Weights(), limit, 1e10, zones=ZONES[name]
    )


def random_weight(rng: np.random.Generator, least: float, most: float) -> Array:
    """Full weight with eigenvalues between two powers of ten."""
    axes = lie.from_quaternion_xyzw(rng.normal(size=4))
    weight = axes @ np.diag(10.0 ** rng.uniform(least, most, 3)) @ axes.T
    return np.asarray(0.5 * (weight + weight.T))


def random_problem(rng: np.random.Generator) -> AttitudeOcp:
    """Full matrices, up to two zones, with a limit or without, up to 60 steps."""
    a, b, c = rng.uniform(0.2, 1.0, 3)
    axes = lie.from_quaternion_xyzw(rng.normal(size=4))
    inertia = axes @ np.diag([b + c, a + c, a + b]) @ axes.T
    zones = tuple(
        PointingZone(
            "exclusion", rng.normal(size=3), rng.normal(size=3), float(rng.uniform(0.1, 0.6)),
            float(10.0 ** rng.uniform(0.0, 3.0)),
        )
        for _ in range(rng.integers(0, 3))
    )  # fmt: skip
    weights = Weights(
        random_weight(rng, -3, 0), random_weight(rng, -3, 0), random_weight(rng, -1, 1),
        random_weight(rng, -3, 0), random_weight(rng, -3, 0),
    )  # fmt: skip
    step, limit = float(rng.choice([0.1, 0.2, 0.4])), float(rng.choice([0.0, 0.01, 0.1, 0.5]))
    penalty = float(10.0 ** rng.uniform(4.0, 10.0))
    horizon = int(rng.integers(2, 61))
    inertia = 0.5 * (inertia + inertia.T)
    return AttitudeOcp(inertia, step, horizon, weights, limit, penalty, zones=zones)


@dataclass
class Tally:
    """What was seen of corrected steps."""

    solved: int = 0
    unknown: int = 0
    """Corrected steps whose exact solve did not converge."""
    errors: list[float] = field(default_factory=list)
    """True error of each corrected step, as a share of what the tolerance allows."""
    ratios: list[float] = field(default_factory=list)
    """The error over its bound, less what the exact solve itself leaves of the conditions."""
    corrected_times: list[float] = field(default_factory=list)
    exact_times: list[float] = field(default_factory=list)

    def add(self, other: Tally) -> None:
        """Take in what another one has seen."""
        self.solved += other.solved
        self.unknown += other.unknown
        for name in ("errors", "ratios", "corrected_times", "exact_times"):
            getattr(self, name).extend(getattr(other, name))

    def line(self, name: str) -> str:
        """One row of the table."""
        n = len(self.errors) + self.unknown
        shares = [
            f"{int((x > 1.0).sum()):6d} {x.max(initial=0.0):8.3f}"
            for x in map(np.array, (self.errors, self.ratios))
        ]
        times = [
            f"{1e6 * float(np.median(t or [math.nan])):8.1f}"
            for t in (self.corrected_times, self.exact_times)
        ]
        first = f"{name:28s} {n:7d} {100.0 * n / (n + self.solved):6.1f} %"
        return " ".join([first, *shares, *times, f"{self.unknown:5d}"])


HEADER = "\n".join(
    f"{'':28s} {steps:>7s} {hits:>8s} {over:>6s} {worst:>8s} {bound:>6s} {ratio:>8s} "
    f"{corrected:>8s} {exact:>8s} {fails:>5s}"
    for steps, hits, over, worst, bound, ratio, corrected, exact, fails in (
        ("", "", "over", "worst", "over", "worst", "NE", "exact", "exact"),
        ("steps", "hits", "tol.", "err/tol", "bound", "err/bnd", "us", "us", "fails"),
    )
)


def fly(online: NeighboringExtremal, noise: float, rng: np.random.Generator, steps: int) -> Tally:
    """Fly one closed loop from a random start and compare each corrected step."""
    ocp, exact, seen = online.ocp, ShootingSolver(online.ocp), Tally()
    lightest = np.linalg.eigvalsh(ocp.weights.stage_torque)[0]  # a residual over it is a torque
    online.reset()
    axis = rng.normal(size=3)
    attitude = lie.exp(rng.uniform(0.0, 3.0) * axis / np.linalg.norm(axis))
    momentum = rng.normal(size=3) * 0.02 * rng.uniform()
    warm = None
    for _ in range(steps):
        measured = attitude @ lie.exp(noise * rng.normal(size=3))
        spin = momentum + noise / 3.0 * rng.normal(size=3)
        solution = online.solve(measured, spin, None, warm)
        if not solution.converged:
            solution = online.solve(measured, spin)
        if not solution.converged:
            break
        if solution.formulation == FORMULATION:
            truth = exact.solve(measured, spin, None, warm)
            seen.unknown += not truth.converged
            seen.corrected_times.append(solution.solve_time)
            if truth.converged:
                plan = truth.torques.copy()
                plan[0] = ocp.realizable(plan[0])
                error = float(np.linalg.norm(solution.torques - plan))
                seen.errors.append(error / online.largest_error)
                beyond = max(0.0, error - truth.residual / lightest)
                seen.ratios.append(beyond / online.error_bound if beyond > 0.0 else 0.0)
                seen.exact_times.append(truth.solve_time)
        else:
            seen.solved += 1
        warm = solution.warm_start
        attitude, momentum = ocp.body.step(attitude, momentum, ocp.realizable(solution.torques[0]))
    return seen


def study(
    ocp: AttitudeOcp, options: NeighboringOptions, flights: int, steps: int, seed: int
) -> Tally:
    """Fly from random starts with each size of noise."""
    online, rng, seen = NeighboringExtremal(ocp, options), np.random.default_rng(seed), Tally()
    online.warm_up()
    for noise, _ in itertools.product(NOISE, range(flights)):
        seen.add(fly(online, noise, rng, steps))
    return seen


def settling(horizon: int) -> str:
    """Fly Case I from its own start to rest, with another horizon, and tell the times."""
    ocp = problem("Case I", horizon)
    online, exact = NeighboringExtremal(ocp), ShootingSolver(ocp)
    attitude, momentum = lie.exp(np.array([0.25, 0.5, 0.5])), np.zeros(3)
    warm, exact_warm, corrected, solved = None, None, [], []
    for _ in range(375):
        solution = online.solve(attitude, momentum, None, warm)
        truth = exact.solve(attitude, momentum, None, exact_warm)
        if solution.formulation == FORMULATION:
            corrected.append(1e6 * solution.solve_time)
        solved.append(1e6 * truth.solve_time)
        warm, exact_warm = solution.warm_start, truth.warm_start
        attitude, momentum = ocp.body.step(attitude, momentum, solution.torques[0])
    return (
        f"Case I to rest, N {horizon}: {100.0 * online.hit_rate:.0f} % hits, NE "
        f"{np.median(corrected):.1f} us, exact {np.median(solved):.1f} us"
    )


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--flights", type=int, default=24, help="of each noise (default 24)")
    parser.add_argument("--steps", type=int, default=120, help="of a flight (default 120)")
    given = parser.parse_args()
    cases, total = list(itertools.product(ZONES, HORIZONS)), Tally()
    print(HEADER)
    for seed, (name, horizon) in enumerate(cases):
        seen = study(problem(name, horizon), NeighboringOptions(), given.flights, given.steps, seed)
        print(seen.line(f"{name}, N {horizon}"), flush=True)
        total.add(seen)
    for tolerance, age in SETTINGS:
        options, seen, few = NeighboringOptions(tolerance, age), Tally(), max(1, given.flights // 4)
        for seed, case in enumerate(cases, 100):
            seen.add(study(problem(*case), options, few, given.steps, seed))
        print(seen.line(f"all, tolerance {tolerance:g}, age {age}"), flush=True)
        total.add(seen)
    rng, seen = np.random.default_rng(0), Tally()
    for seed in range(10 * given.flights):
        seen.add(study(random_problem(rng), NeighboringOptions(), 1, given.steps, seed))
    print(seen.line(f"{10 * given.flights} random problems"))
    total.add(seen)
    print(total.line("all"))
    for horizon in HORIZONS:
        print(settling(horizon))
    return 1 if max(total.errors) > 1.0 else 0


if __name__ == "__main__":
    sys.exit(main())
