"""Random transfers of the paper's range agree with CasADi and IPOPT."""

from __future__ import annotations

import numpy as np
import pytest
from transfer_cases import BODY, random_transfer

from spacecraft_gnc.ocp.transfer import TransferSolver
from spacecraft_gnc.ocp.transfer.starts import NAMES, make_start

pytest.importorskip("casadi")


@pytest.mark.parametrize("index", [6, 22, 33, 43, 51, 109, 113, 141, 148])
def test_cost_and_torque(index):
    from transfer_ipopt import TransferIpopt

    problem = random_transfer(index)
    plan = TransferSolver().solve(problem)
    assert plan.converged
    start = make_start(problem, NAMES[0])
    status, cost, torque, _ = TransferIpopt(BODY, problem.n_steps).solve(
        problem, np.clip(start.torque, -20.0, 20.0), np.clip(start.momentum, -70.0, 70.0)
    )
    assert status == "Solve_Succeeded"
    assert plan.cost == pytest.approx(cost, rel=1e-6)
    np.testing.assert_allclose(plan.torque, torque, atol=1e-3)
