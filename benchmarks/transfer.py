"""Attitude transfers: ours beside CasADi with IPOPT, and the time over the number of steps.

python benchmarks/transfer.py [COUNT]

COUNT (200) random transfers of the range of Phogat et al. (10-90 deg about any axis, 5-30 s, 190
steps, at rest at both ends) are solved by both from the same start, the one along the eigenaxis;
what ours does not solve with all its starts, IPOPT is given five random starts for. Times are those
of the whole call, one thread each, the best of three. Then the transfer of figure 4 with 100 to
2,000 steps.
"""

from __future__ import annotations

import os

os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")  # before NumPy and CasADi

import sys
from collections import Counter
from pathlib import Path
from time import perf_counter

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "test"))

from transfer_cases import BODY, figure_4, random_transfer
from transfer_ipopt import TransferIpopt

from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.ocp.transfer import TransferSolver
from spacecraft_gnc.ocp.transfer.starts import NAMES, make_start
from spacecraft_gnc.status import Status

STEPS, SECONDS_4 = 190, 19.0


def within(problem, start):
    """Return torque and momentum of a start, within the bounds."""
    low_u, high_u, low_p, high_p = problem.limits
    return np.clip(start.torque, low_u, high_u), np.clip(start.momentum, low_p, high_p)


def random_start(problem, seed):
    """Return torque and momentum of a random start: the straight one and three sine waves."""
    numbers = np.random.default_rng([17, seed])
    phase = np.pi * np.linspace(0.0, 1.0, problem.n_steps + 1)[:, None]
    start = make_start(problem, NAMES[0])
    waves = sum(numbers.uniform(-30.0, 30.0, 3) * np.sin((n + 1) * phase) for n in range(3))
    momentum = start.momentum + waves
    torque = np.diff(momentum, axis=0) / problem.body.time_step
    return within(problem, start._replace(torque=torque, momentum=momentum))


def best_time(call, times=3):
    """Return the shortest time of a call, and its answer."""
    taken = []
    for _ in range(times):
        begun = perf_counter()
        answer = call()
        taken.append(perf_counter() - begun)
    return min(taken), answer


def compare(count):
    """Print the comparison with IPOPT."""
    one, every = TransferSolver(starts=1), TransferSolver()
    tally, ratios, times, worst = Counter(), [], [], 0.0
    for index in range(count):
        problem = random_transfer(index, STEPS)
        start = make_start(problem, NAMES[0])
        other = TransferIpopt(problem.body, STEPS)
        ours, plan = best_time(lambda p=problem, s=start: one.solve(p, (s.torque, s.momentum)))
        begun_at = within(problem, start)
        theirs, (status, cost, *_) = best_time(
            lambda p=problem, o=other, b=begun_at: o.solve(p, *b)
        )
        found = every.solve(problem)
        solved = status == "Solve_Succeeded"
        if found.status == Status.INFEASIBLE:
            tally["proven infeasible" + (", solved by IPOPT" if solved else "")] += 1
        elif not found.converged:
            attempts = [other.solve(problem, *random_start(problem, seed)) for seed in range(5)]
            solved = solved or any(answer[0] == "Solve_Succeeded" for answer in attempts)
            tally["not solved" + (", solved by IPOPT" if solved else " by either")] += 1
        elif solved:
            difference = (found.cost - cost) / cost
            worst = max(worst, difference)
            tally["agree" if abs(difference) < 1e-6 else "differ"] += 1
            if plan.converged:
                ratios.append(theirs / ours)
                times.append((ours, theirs))
        else:
            tally["solved by ours only"] += 1
    for name, number in sorted(tally.items()):
        print(f"{name}: {number}")
    ours, theirs = np.median(times, axis=0)
    print(f"largest excess of the cost over IPOPT's: {worst:.1e}")
    print(f"median {1e3 * ours:.2f} ms, IPOPT {1e3 * theirs:.1f} ms; ratio {np.median(ratios):.1f}")


def lengths():
    """Print the time over the number of steps."""
    solver = TransferSolver(starts=1)
    for steps in (100, 200, 500, 1000, 2000):
        problem = figure_4(body=RigidBody(BODY.inertia, SECONDS_4 / steps), n_steps=steps)
        taken, plan = best_time(lambda p=problem: solver.solve(p))
        text = f"{plan.status.text}, {plan.iterations} Newton steps"
        print(f"N = {steps}: {1e3 * taken:.1f} ms, {text}")


if __name__ == "__main__":
    compare(int(sys.argv[1]) if len(sys.argv) > 1 else 200)
    lengths()
