"""Compare plans of transfers with momentum and large turns with the best that IPOPT finds.

Run as ``python benchmarks/transfer_turns.py [COUNT] [FIRST]``. COUNT (60) seeded transfers of the
spacecraft of Phogat et al. with 200 steps: 5-180 deg about any axis (a quarter: 150-180 deg) in
20-80 s (a quarter: 10-40 s), from momenta of up to 60 N m s, a quarter of them to up to 50 N m s.
IPOPT starts from each start of ours, and from four random ones.
"""

from __future__ import annotations

import sys
from collections import Counter

import numpy as np

from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.ocp.transfer import TransferSolver
from spacecraft_gnc.ocp.transfer.starts import COASTING, NAMES, OTHER_WAY, make_start
from spacecraft_gnc.status import Status
from spacecraft_gnc.studies.phogat_compare import AGREE
from spacecraft_gnc.studies.phogat_ipopt import TransferIpopt
from spacecraft_gnc.studies.phogat_transfers import BODY, paper_transfer, random_start

STEPS = 200
RANDOM_STARTS = 4


def turning_transfer(index):
    """Return a seeded transfer with momentum."""
    numbers = np.random.default_rng([18, index])
    axis = numbers.standard_normal(3)
    degrees, seconds = numbers.uniform(5.0, 180.0), numbers.uniform(20.0, 80.0)
    size = 60.0 * numbers.uniform()
    first, last = size * direction(numbers), np.zeros(3)
    if index % 4 == 0:
        degrees = numbers.uniform(150.0, 180.0)
    elif index % 4 == 2:
        last = direction(numbers) * numbers.uniform(0.0, 50.0)
    elif index % 4 == 3:
        seconds = numbers.uniform(10.0, 40.0)
    body = RigidBody(BODY.inertia, seconds / STEPS)
    momenta = {"start_momentum": first, "goal_momentum": last}
    return paper_transfer(degrees, axis, seconds, body=body, n_steps=STEPS, **momenta)


def direction(numbers):
    """Return a random unit vector."""
    vector = numbers.standard_normal(3)
    return vector / np.linalg.norm(vector)


def least_of_ipopt(ipopt, problem):
    """Return the least cost that IPOPT finds; infinite: none."""
    starts = [make_start(problem, name) for name in (*NAMES, OTHER_WAY, COASTING)]
    starts += [random_start(problem, seed) for seed in range(RANDOM_STARTS)]
    answers = [ipopt.solve(problem, start) for start in starts]
    return min((one.cost for one in answers if one.solved), default=np.inf)


def main(count, first):
    """Print each transfer, then who found what."""
    ipopt, outcomes, one_way, times = TransferIpopt(BODY.inertia, STEPS), Counter(), 0, []
    for index in range(first, first + count):
        problem = turning_transfer(index)
        plan = TransferSolver().solve(problem)
        if plan.status == Status.INFEASIBLE:
            outcomes["proven infeasible"] += 1
            continue
        theirs = least_of_ipopt(ipopt, problem)
        ours = plan.cost if plan.converged else np.inf
        about = [x.cost for x in plan.tried if x.status == Status.CONVERGED and x.start in NAMES]
        if min(about, default=np.inf) > theirs * (1.0 + AGREE):
            one_way += 1
        if ours == theirs == np.inf:
            outcome = "solved by neither"
        elif ours > theirs * (1.0 + AGREE):
            outcome = "ours dearer, or none"
        else:
            outcome = "the same cost" if ours > theirs * (1.0 - AGREE) else "ours cheaper"
        outcomes[outcome] += 1
        times.append(plan.solve_time)
        print(
            f"{index}: {np.degrees(problem.angle):.0f} deg in {problem.duration:.0f} s, "
            f"ours {ours:.4f}, IPOPT {theirs:.4f}: {outcome}",
            flush=True,
        )
    for outcome, number in sorted(outcomes.items()):
        print(f"{outcome}: {number}")
    print(f"dearer, or none, without the other ways: {one_way}")
    print(f"{1e3 * np.median(times):.1f} ms in the median")


if __name__ == "__main__":
    given = [int(text) for text in sys.argv[1:]]
    main(*given, *(60, 0)[len(given) :])
