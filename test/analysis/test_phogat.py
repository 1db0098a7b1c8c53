"""Figures of the study of transfers, from plans and against what is known without a solver."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from spacecraft_gnc.cli.bench import _planner_rows
from spacecraft_gnc.ocp.transfer import TransferSolver
from spacecraft_gnc.studies import phogat_study as study
from spacecraft_gnc.studies.phogat_compare import Compared
from spacecraft_gnc.studies.phogat_speed import Length, growth, time_beside_ipopt, time_planner
from spacecraft_gnc.studies.phogat_transfers import BODY, figure_4, random_start, random_transfer


@pytest.fixture(scope="module")
def plan():
    return TransferSolver(starts=1).solve(figure_4())


def test_a_torque_that_holds_a_momentum_holds_it(plan):
    k = 100
    torque = study.holding_torque(plan)[k]
    _, momentum = BODY.step(plan.attitude[k], plan.momentum[k], torque)
    np.testing.assert_allclose(momentum, plan.momentum[k], atol=1e-12)


def test_momentum_stays_over_the_steps_that_keep_it(plan):
    assert study.kept(plan, 0).size == 0
    for axis in (1, 2):
        steps = study.kept(plan, axis)
        np.testing.assert_array_equal(plan.momentum[[*steps, steps[-1] + 1], axis], 70.0)


def test_a_torque_that_saturates_without_its_co_state_is_noticed(plan):
    assert study.saturated_as_co_states_say(plan)
    active = plan.active_torque.copy()
    active[100, 0] = 1
    assert not study.saturated_as_co_states_say(replace(plan, active_torque=active))


def test_co_state_of_the_attitude_is_constant_in_the_inertial_frame(plan):
    inertial = np.einsum("kij,kj->ki", plan.attitude[1:], study.attitude_co_state(plan))
    np.testing.assert_allclose(inertial, inertial[:1].repeat(190, axis=0), rtol=1e-12)
    np.testing.assert_allclose(study.attitude_co_state(plan)[0], plan.zeta, rtol=1e-12)


def test_full_torque_takes_the_known_time():
    """10 deg of 800 kg m^2 by 20 N m: 5.28 s."""
    assert study.time_of_full_torque(10.0, 800.0, 20.0) == pytest.approx(5.2844, abs=1e-4)


def test_growth_is_the_power_of_the_steps():
    found = tuple(Length(n, 1e-6 * n**1.5 * 20, 20) for n in (100, 500, 2000))
    assert growth(found) == pytest.approx(1.5)


@pytest.mark.parametrize(
    ("ipopt", "outcome"),
    [
        (1.0, "solved by both, the same cost"),
        (1.0 - 1e-5, "solved by both, ours costs more"),
        (1.0 + 1e-5, "solved by both, ours costs less"),
        (math.nan, "solved by ours alone"),
    ],
)
def test_outcomes(plan, ipopt, outcome):
    assert Compared(plan, ipopt * plan.cost, 1, math.nan, math.nan).outcome == outcome


def test_random_starts_keep_the_ends_and_differ():
    problem = random_transfer(3)
    starts = [random_start(problem, seed) for seed in (0, 0, 1)]
    np.testing.assert_array_equal(starts[0].momentum, starts[1].momentum)
    assert np.abs(starts[0].momentum - starts[2].momentum).max() > 1.0
    np.testing.assert_allclose(starts[2].momentum[[0, -1]], 0.0, atol=1e-12)


def test_rows_of_the_bench():
    pytest.importorskip("casadi")
    figures = {"planner": time_planner(3), "planner_beside_ipopt": time_beside_ipopt(2)}
    rows = dict(_planner_rows(figures))
    assert rows["figure 4, 2000 steps"].endswith("29 Newton steps")
    assert rows["ratio"].endswith(" 2 transfers")
    assert figures["planner_beside_ipopt"]["ratio"]["median"] > 0.0
    del figures["planner_beside_ipopt"]
    assert "ratio" not in dict(_planner_rows(figures))
