"""Transfers of the paper against the reference solution, and what makes an answer optimal."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from transfer_cases import BODY, figure_4, paper_transfer, random_transfer

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.ocp.transfer import TransferSolver, shortest_possible_steps, shortest_transfer
from spacecraft_gnc.ocp.transfer.conditions import evaluate
from spacecraft_gnc.status import Status

DATA = Path(__file__).parents[2] / "data" / "phogat_figure4_ipopt.npz"


@pytest.fixture(scope="module")
def plan():
    """The plan of figure 4."""
    return TransferSolver().solve(figure_4())


def test_figure_4(plan):
    assert plan.converged
    assert plan.cost == pytest.approx(20965.95496, abs=1e-5)
    reference = np.load(DATA)
    np.testing.assert_allclose(plan.torque, reference["torque"], rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(plan.momentum, reference["momentum"], rtol=0.0, atol=1e-6)
    found = {(one.quantity, one.axis, one.bound, one.first, one.last) for one in plan.active}
    assert found == {
        ("torque", 1, 20.0, 0, 5),
        ("torque", 1, -20.0, 179, 189),
        ("torque", 2, 20.0, 0, 3),
        ("momentum", 2, 70.0, 58, 79),
        ("momentum", 1, 70.0, 70, 132),
    }


def test_roll_out_ends_at_the_goal(plan):
    problem = plan.problem
    attitudes, momenta = BODY.simulate(problem.start, problem.start_momentum, plan.torque)
    assert lie.angle_between(attitudes[-1], problem.goal) < 1e-12
    np.testing.assert_allclose(momenta[-1], 0.0, atol=1e-11)
    assert np.abs(plan.torque).max() <= 20.0
    assert np.abs(plan.momentum).max() <= 70.0


@pytest.mark.parametrize(
    ("what", "field"),
    [
        ("momentum", "momentum"),
        ("co_momentum", "co_momentum"),
        ("zeta", "co_momentum"),
        ("torque_multipliers", "torque"),
        ("momentum_multipliers", "co_momentum"),
    ],
)
def test_conditions_notice_a_wrong_number(plan, what, field):
    parts = {
        name: getattr(plan, name).copy()
        for name in (
            "torque", "momentum", "co_momentum", "zeta", "torque_multipliers",
            "momentum_multipliers",
        )
    }  # fmt: skip
    good, _ = evaluate(plan.problem, **parts)
    assert good.largest < 1e-12
    parts[what].flat[parts[what].size // 2] *= 1.0 + 1e-4
    parts[what].flat[parts[what].size // 2] += 1e-3
    bad, _ = evaluate(plan.problem, **parts)
    assert getattr(bad, field) > 1e-7


def test_multipliers_have_their_signs(plan):
    assert (plan.torque_multipliers * plan.active_torque >= 0.0).all()
    assert (plan.torque_multipliers[plan.active_torque == 0] == 0.0).all()
    assert (plan.momentum_multipliers * plan.active_momentum >= 0.0).all()
    assert (plan.momentum_multipliers[plan.active_momentum == 0] == 0.0).all()


def test_straight_start_on_a_principal_axis_is_no_proof():
    plan = TransferSolver().solve(paper_transfer(90.0, (0.0, 1.0, 0.0), 30.0))
    assert plan.converged
    assert plan.cost == pytest.approx(14192.2478, abs=1e-4)
    assert plan.tried[0].status != Status.CONVERGED


THE_OTHER_WAY = [
    # Costs by IPOPT from several starts, as benchmarks/transfer_turns.py.
    (math.degrees(3.2), (1.0, 0.0, 0.0), 40.0, (30.0, -10.0, 10.0), 6479.179),
    (175.0, (-1.0, -1.0, -1.0), 40.0, (20.0, 20.0, 20.0), 5918.415),
]


@pytest.mark.parametrize(("degrees", "axis", "seconds", "momentum", "cost"), THE_OTHER_WAY)
def test_the_other_way_is_taken_where_it_is_cheaper(degrees, axis, seconds, momentum, cost):
    problem = paper_transfer(degrees, axis, seconds, start_momentum=np.array(momentum))
    plan = TransferSolver().solve(problem)
    assert plan.converged
    assert plan.residuals.largest < 1e-8
    assert plan.cost == pytest.approx(cost, abs=1e-3)
    costs = {one.start: one.cost for one in plan.tried}
    assert costs["other way"] < 0.5 * costs["eigenaxis"]
    assert TransferSolver(starts=1).solve(problem).cost == pytest.approx(plan.cost, rel=1e-9)


@pytest.mark.parametrize(
    ("degrees", "axis", "seconds", "momentum", "cost"),
    [
        (175.0, (0.0, -1.0, 0.0), 45.0, (0.0, 30.0, 0.0), 6558.8),
        (170.0, (0.0, -1.0, 0.0), 60.0, (0.0, 40.0, 0.0), 1132.2),
        (160.0, (0.0, 0.0, -1.0), 50.0, (0.0, 0.0, 40.0), 2911.4),
        (150.0, (0.0, -1.0, 0.0), 50.0, (0.0, 50.0, 0.0), 4331.8),
    ],
)
def test_the_other_way_about_a_principal_axis(degrees, axis, seconds, momentum, cost):
    """Straight the other way there is a saddle or nothing; costs by IPOPT, off the axis."""
    problem = paper_transfer(
        degrees,
        axis,
        seconds,
        body=RigidBody(BODY.inertia, seconds / 200),
        n_steps=200,
        start_momentum=np.array(momentum),
    )
    plan = TransferSolver().solve(problem)
    assert plan.converged
    assert plan.cost == pytest.approx(cost, abs=0.1)
    ended = {one.start: one.status for one in plan.tried}
    assert ended["other way"] != Status.CONVERGED


def test_a_short_turn_from_rest_has_one_way():
    plan = TransferSolver().solve(paper_transfer(90.0, (1.0, 1.0, 1.0), 30.0))
    assert [one.start for one in plan.tried] == ["eigenaxis", "off axis 1+", "off axis 1-"]


def test_a_body_that_spins_need_not_be_stopped():
    """Almost four turns of coasting: one that coasts costs less than those that stop it."""
    body = RigidBody(BODY.inertia, 0.2)
    coast = np.array([0.0, 0.0, 350.0])
    problem = paper_transfer(
        60.0, (0.2, 0.1, 1.0), 65.0, body=body, n_steps=325, momentum=None, start_momentum=coast
    )
    plan = TransferSolver().solve(problem)
    assert plan.converged
    assert plan.cost == min(one.cost for one in plan.tried if one.status == Status.CONVERGED)
    assert plan.cost < 0.9 * plan.tried[0].cost


def test_work_is_bounded_and_told():
    problem = figure_4()
    whole = TransferSolver().solve(problem)
    assert whole.work % problem.n_steps == 0.0
    passes = whole.work / problem.n_steps
    assert sum(one.iterations for one in whole.tried) <= passes < 300.0
    again = TransferSolver().solve(problem, max_work=whole.work)
    np.testing.assert_array_equal(again.torque, whole.torque)
    little = TransferSolver().solve(problem, max_work=5.0 * problem.n_steps)
    assert little.status == Status.MAX_ITERATIONS
    assert [one.start for one in little.tried] == ["eigenaxis"]


def test_plain_algorithm_2_solves_the_paper_s_case():
    plan = TransferSolver(starts=1, homotopy=False).solve(figure_4())
    assert plan.converged
    assert plan.cost == pytest.approx(20965.95496, abs=1e-5)


def test_curvature_is_that_of_the_dense_hessian():
    """The lower bound against the reduced Hessian by differences, bounds apart."""
    problem = figure_4(
        body=RigidBody(BODY.inertia, 19.0 / 12), n_steps=12, torque=None, momentum=None
    )
    plan = TransferSolver(starts=1).solve(problem)
    assert plan.converged

    n = plan.torque.size

    def end(torque):
        attitudes, momenta = problem.body.simulate(
            problem.start, problem.start_momentum, torque.reshape(-1, 3)
        )
        return np.append(lie.log(problem.goal.T @ attitudes[-1]), momenta[-1])

    base, steps = plan.torque.ravel(), 1e-2 * np.eye(n)
    jacobian = np.array([(end(base + d) - end(base - d)) / 2e-2 for d in steps]).T
    multipliers = np.linalg.lstsq(jacobian.T, -base, rcond=None)[0]
    gamma = problem.body.time_step * multipliers[3:]
    np.testing.assert_allclose(gamma, plan.co_momentum[-1], rtol=1e-3)
    hessian = np.eye(n)
    for i in range(n):
        for j in range(n):
            a, b = 50.0 * steps[i], 50.0 * steps[j]
            bend = end(base + a + b) - end(base + a - b) - end(base - a + b) + end(base - a - b)
            hessian[i, j] += multipliers @ bend
    free = np.linalg.svd(jacobian)[2][6:]
    least = np.linalg.eigvalsh(free @ hessian @ free.T)[0]
    assert plan.min_curvature == pytest.approx(least, abs=2e-3)


@pytest.mark.parametrize("bounds", [(-np.inf, 20.0), ([-15.0, -25.0, -30.0], 20.0), None])
def test_bounds_need_not_be_symmetric(bounds):
    plan = TransferSolver(starts=1).solve(figure_4(torque=bounds))
    assert plan.converged
    assert plan.residuals.largest < 1e-8


def test_cost_falls_with_wider_bounds():
    costs = [TransferSolver(starts=1).solve(figure_4(torque=x)).cost for x in (19.0, 20.0, 25.0)]
    assert costs == sorted(costs, reverse=True)
    assert costs[0] > costs[1] > costs[2]


def test_nothing_to_do_costs_nothing():
    plan = TransferSolver().solve(paper_transfer(0.0, (1.0, 0.0, 0.0), 10.0))
    assert plan.converged
    assert plan.cost < 1e-20


def test_same_problem_in_other_units():
    """Mass in other units scales torque and momentum, and nothing else."""
    plain = TransferSolver(starts=1).solve(figure_4())
    factor = 1e-6
    problem = figure_4()
    scaled = TransferSolver(starts=1).solve(
        replace(
            problem,
            body=RigidBody(factor * BODY.inertia, BODY.time_step),
            start_momentum=factor * problem.start_momentum,
            torque=20.0 * factor,
            momentum=70.0 * factor,
        )
    )
    assert scaled.converged
    np.testing.assert_allclose(scaled.torque / factor, plain.torque, atol=1e-7)


def test_given_start(plan):
    again = TransferSolver().solve(plan.problem, (0.9 * plan.torque, plan.momentum))
    assert again.converged
    assert [one.start for one in again.tried] == ["given"]
    np.testing.assert_allclose(again.torque, plan.torque, atol=1e-9)


@pytest.mark.parametrize("index", [43, 51, 109])
def test_inertial_frame_does_not_matter(index):
    problem = random_transfer(index)
    turn = lie.exp(np.array([0.3, -1.1, 0.7]))
    turned = replace(problem, start=turn @ problem.start, goal=turn @ problem.goal)
    one, two = (TransferSolver(starts=1).solve(p) for p in (problem, turned))
    assert one.converged
    assert two.converged
    np.testing.assert_allclose(two.torque, one.torque, atol=1e-8)


@pytest.mark.parametrize("index", [43, 51, 109])
def test_names_of_the_axes_do_not_matter(index):
    problem = random_transfer(index)
    cycle = np.eye(3)[[2, 0, 1]]
    body = RigidBody(cycle @ BODY.inertia @ cycle.T, BODY.time_step)
    renamed = replace(problem, body=body, goal=cycle @ problem.goal @ cycle.T)
    one, two = (TransferSolver(starts=1).solve(p) for p in (problem, renamed))
    assert one.converged
    assert two.converged
    np.testing.assert_allclose(two.torque, one.torque @ cycle.T, atol=1e-7)


def test_too_short_is_proven():
    problem = paper_transfer(90.0, (1.0, 0.0, 0.0), 5.0)
    plan = TransferSolver().solve(problem)
    assert plan.status == Status.INFEASIBLE
    assert "too short" in plan.reason
    least = shortest_possible_steps(problem)
    assert TransferSolver().solve(replace(problem, n_steps=least)).status != Status.INFEASIBLE


def test_shortest_transfer_is_no_shorter_than_the_bound():
    problem = paper_transfer(10.0, (1.0, 0.0, 0.0), 5.0)
    assert not TransferSolver().solve(problem).converged
    best = shortest_transfer(problem)
    assert best.converged
    # At full torque there and back: angle = u T^2 / (4 J), 5.28 s.
    assert best.problem.duration == pytest.approx(2.0 * np.sqrt(np.radians(10.0) * 40.0), abs=0.1)
    assert best.problem.n_steps >= shortest_possible_steps(problem) >= 52


def test_shortest_transfer_goes_the_other_way_where_that_is_quicker():
    problem = paper_transfer(
        math.degrees(3.2), (1.0, 0.0, 0.0), 40.0, start_momentum=np.array([30.0, -10.0, 10.0])
    )
    best = shortest_transfer(problem)
    assert best.converged
    assert best.problem.n_steps <= 342  # straight on, 352 are the fewest
    assert next(one.start for one in best.tried if one.status == Status.CONVERGED) == "other way"


@pytest.mark.parametrize("index", range(0, 40, 4))
def test_second_solve_is_the_same(index):
    problem = random_transfer(index)
    one, two = (TransferSolver().solve(problem) for _ in range(2))
    assert one.status == two.status
    np.testing.assert_array_equal(one.torque, two.torque)
