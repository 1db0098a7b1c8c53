"""Random transfers of the paper's range agree with CasADi and IPOPT."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from transfer_cases import BODY, paper_transfer, random_transfer

from spacecraft_gnc import lie
from spacecraft_gnc.ocp.transfer import TransferSolver
from spacecraft_gnc.ocp.transfer.starts import NAMES, make_start
from spacecraft_gnc.studies.phogat_compare import Comparison

pytest.importorskip("casadi")


@pytest.fixture(scope="module")
def comparison():
    return Comparison()


@pytest.mark.parametrize("index", [6, 22, 33, 43, 51, 109, 113, 141, 148])
def test_cost_and_torque(index):
    from spacecraft_gnc.studies.phogat_ipopt import TransferIpopt

    problem = random_transfer(index)
    plan = TransferSolver().solve(problem)
    assert plan.converged
    answer = TransferIpopt(BODY.inertia, problem.n_steps).solve(
        problem, make_start(problem, NAMES[0])
    )
    assert answer.solved
    assert plan.cost == pytest.approx(answer.cost, rel=1e-6)
    np.testing.assert_allclose(plan.torque, answer.torque, atol=1e-3)


def test_the_start_s_attitude_does_not_matter_to_ipopt(comparison):
    """Its frame is that of the start; a turn of more than half leaves the sign of quaternions."""
    problem = paper_transfer(170.0, (1.0, 2.0, -1.0), 40.0)
    turn = lie.exp(np.array([2.0, -1.1, 0.7]))
    turned = replace(problem, start=turn @ problem.start, goal=turn @ problem.goal)
    found = comparison.of(turned)
    assert found.outcome == "solved by both, the same cost"
    assert found.plan.cost == pytest.approx(TransferSolver().solve(problem).cost, rel=1e-9)


@pytest.mark.parametrize(
    ("degrees", "axis", "seconds", "outcome", "starts"),
    [
        (30.0, (1.0, 1.0, 1.0), 10.0, "solved by both, the same cost", 1),
        (90.0, (0.0, 1.0, 0.0), 30.0, "solved by both, the same cost", 2),
        (10.0, (1.0, 0.0, 0.0), 5.0, "proven infeasible, not solved by IPOPT either", 1),
        (90.0, (1.0, 0.0, 0.0), 20.0, "not solved, not solved by IPOPT either", 6),
    ],
)
def test_outcomes(comparison, degrees, axis, seconds, outcome, starts):
    found = comparison.of(paper_transfer(degrees, axis, seconds))
    assert found.outcome == outcome
    assert found.ipopt_starts == starts
    assert np.isfinite(found.ours) == (starts == 1 and "both" in outcome)
