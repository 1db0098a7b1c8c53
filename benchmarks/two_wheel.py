"""The SQP for two wheels beside CasADi with IPOPT, on the problems of closed loops in one run.

python benchmarks/two_wheel.py [MODEL ...]

The report's spacecraft is flown by the SQP on the exact plant from the report's three starts and
from random ones; each problem on the way is also solved by IPOPT and by the SQP with chord steps,
from the same warm start (plan and multipliers), each solver in turn first. Times are those of the
whole call without the curvature of the certificate, one thread each, the best of three. A problem
whose hard end is infeasible is flown with a soft one; the soft problem is then compared too.
"""

from __future__ import annotations

import os

os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")  # before NumPy and CasADi

import sys
from collections import Counter, defaultdict
from typing import Any

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.types import Matrix3, Vector3
from spacecraft_gnc.vehicles.two_wheel.dynamics import Gyrostat
from spacecraft_gnc.vehicles.two_wheel.euler import from_euler_321
from spacecraft_gnc.vehicles.two_wheel.ocp.ipopt import IpoptSolver
from spacecraft_gnc.vehicles.two_wheel.ocp.problem import MODELS, WheelOcp
from spacecraft_gnc.vehicles.two_wheel.ocp.sqp import SqpSolver

INERTIA, WHEELS = np.diag([430.0, 1210.0, 1300.0]), np.eye(3)[:, :2]
WHEEL_INERTIA, SPEED, ACCELERATION = 0.043, 100.0, 5.0  # [kg m^2], [rad/s], [rad/s^2]
NAMED = ((0.5, 0.3, -0.4), (0.2, 0.1, -0.1), (0.0, 0.0, 0.25))  # roll, pitch, yaw [rad]
RANDOM, STEPS = 7, 60
SETTLED_ANGLE, SETTLED_RATE = 0.01, 0.001  # [rad], [rad/s]


class Tally:
    """What came of the problems."""

    def __init__(self) -> None:
        self.times: dict[str, list[float]] = defaultdict(list)
        self.cold: dict[str, list[float]] = defaultdict(list)
        self.iterations: dict[str, list[int]] = defaultdict(list)
        self.failed: Counter[str] = Counter()
        self.relative: list[float] = []
        self.absolute: list[float] = []

    def add(self, found: dict[str, Any], warm: bool) -> None:
        """Count one problem."""
        for name, plan in found.items():
            (self.times if warm else self.cold)[name].append(1e3 * plan.solve_time)
            self.iterations[name].append(plan.iterations)
            self.failed[name] += not plan.converged
        ours, theirs = found["sqp"], found["ipopt"]
        if ours.converged and theirs.converged:
            self.absolute.append(ours.cost - theirs.cost)
            self.relative.append((ours.cost - theirs.cost) / max(abs(theirs.cost), 1e-3))

    def print(self) -> None:
        """Print times and differences."""
        for name, times in self.times.items():
            row = np.array(times)
            cold, steps = np.array(self.cold[name]), np.mean(self.iterations[name])
            print(
                f"  {name:6} warm: median {np.median(row):6.2f}  mean {row.mean():6.2f}  worst "
                f"{row.max():7.2f} ms, {steps:4.1f} iterations; cold: mean "
                f"{cold.mean():6.1f}  worst {cold.max():6.1f} ms; "
                f"not solved: {self.failed[name]} of {row.size + cold.size}"
            )
        ours, theirs = np.array(self.times["sqp"]), np.array(self.times["ipopt"])
        same = np.abs(self.relative) <= 1e-6
        print(
            f"  ipopt / sqp: medians {np.median(theirs) / np.median(ours):.2f}, median of ratios "
            f"{np.median(theirs / ours):.2f}, means {theirs.mean() / ours.mean():.2f}; chord / sqp "
            f"{np.median(self.times['chord']) / np.median(ours):.2f}"
        )
        print(
            f"  cost: {same.sum()} of {same.size} equal to 1e-6 (of the cost, or of 1e-3), sqp "
            f"dearer in {np.sum(np.array(self.relative) > 1e-6)} (worst "
            f"{max(self.relative):.1e}), cheaper in {np.sum(np.array(self.relative) < -1e-6)} "
            f"(most {min(self.relative):.1e})"
        )


def fly(start: Vector3, solvers: dict[str, Any], tally: Tally) -> float:
    """Fly one closed loop; returns when it settles for good [s], NaN if it does not."""
    plant = Gyrostat(INERTIA, WHEELS, [WHEEL_INERTIA] * 2, 1.0, SPEED, ACCELERATION)
    state = plant.state_from_rate(from_euler_321(start), np.zeros(3), np.zeros(2))
    warm, settled, names = None, np.nan, list(solvers)
    for step in range(STEPS):
        soft = False
        while True:
            names = names[1:] + names[:1]
            found = {name: best(solvers[name], state, warm, soft) for name in names}
            tally.add(found, warm is not None)
            if soft or found["sqp"].converged:
                break
            soft = True
        state = plant.step(state, found["sqp"].accelerations[0], 10)
        warm = found["sqp"].warm_start
        if not at_rest(state.attitude, state.angular_velocity):
            settled = np.nan
        elif np.isnan(settled):
            settled = 10.0 * (step + 1)
    return settled


def best(solver: Any, state: Any, warm: Any, soft: bool) -> Any:
    """Solve three times; return what took the least time."""
    plans = (
        solver.solve(state.attitude, state.wheel_speed, warm_start=warm, soft=soft)
        for _ in range(3)
    )
    return min(plans, key=lambda plan: plan.solve_time)


def at_rest(attitude: Matrix3, rate: Vector3) -> bool:
    """Whether the spacecraft is within the report's box."""
    angle = np.linalg.norm(lie.log(attitude))
    return bool(angle < SETTLED_ANGLE and np.linalg.norm(rate) < SETTLED_RATE)


def main(models: list[str]) -> None:
    """Print one table for each model."""
    rng = np.random.default_rng(0)
    starts = [np.array(start) for start in NAMED]
    starts += [rng.uniform(-0.4, 0.4, 3) for _ in range(RANDOM)]
    for model in models:
        ocp = WheelOcp(
            INERTIA, WHEEL_INERTIA * WHEELS, 10.0, max_speed=SPEED,
            max_acceleration=ACCELERATION, model=model,
        )  # fmt: skip
        solvers = {"sqp": SqpSolver(ocp), "ipopt": IpoptSolver(ocp)}
        solvers["chord"] = SqpSolver(ocp, chord=True)
        for soft in (False, True):  # compile and build
            for solver in solvers.values():
                solver.solve(from_euler_321(starts[1]), np.zeros(2), soft=soft)
        tally = Tally()
        settled = [fly(start, solvers, tally) for start in starts]
        print(f"{model}: settled after {', '.join(f'{time:.0f}' for time in settled)} s")
        tally.print()


if __name__ == "__main__":
    main(sys.argv[1:] or list(MODELS))
