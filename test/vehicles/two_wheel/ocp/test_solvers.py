"""What both solvers promise: statuses, starts, determinism, refusals, the report's feasible set."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from blocked_imports import run_without
from wheel_problems import EXACT, MODELS, REST, SLEW, YAW, near, report

from spacecraft_gnc import lie
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.status import Status
from spacecraft_gnc.vehicles.two_wheel.dynamics import Gyrostat
from spacecraft_gnc.vehicles.two_wheel.euler import from_euler_321
from spacecraft_gnc.vehicles.two_wheel.ocp.horizon import shortest_horizon
from spacecraft_gnc.vehicles.two_wheel.ocp.ipopt import IpoptSolver
from spacecraft_gnc.vehicles.two_wheel.ocp.sqp import SqpSolver

SOLVERS = (SqpSolver, IpoptSolver)
FAR = from_euler_321(np.array([0.0, 0.0, 1.0]))


def arrays(plan):
    """All numbers of a plan but its time."""
    fields = [field.name for field in dataclasses.fields(plan)]
    return [np.asarray(getattr(plan, name)) for name in fields if name not in ("ocp", "solve_time")]


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("model", MODELS)
def test_what_is_out_of_reach_is_infeasible_and_has_a_soft_plan(solver, model):
    ocp = report(model)
    hard, soft = (solver(ocp, restarts=1).solve(FAR, REST, soft=soft) for soft in (False, True))
    assert hard.status == Status.INFEASIBLE
    assert hard.terminal_violation > 1e-3
    assert soft.converged
    assert 0.01 < soft.terminal_violation < 1.0
    assert soft.speeds[-1] == pytest.approx(REST, abs=1e-9)
    assert np.abs(soft.accelerations).max() <= 5.0 * (1.0 + 1e-12)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("soft", [False, True])
def test_wheels_that_cannot_stop_in_time_are_infeasible(solver, soft):
    ocp = report(horizon=2, max_acceleration=1.0)
    plan = solver(ocp).solve(np.eye(3), [30.0, 0.0], soft=soft)
    assert plan.status == Status.INFEASIBLE
    assert np.isfinite(plan.accelerations).all()


@pytest.mark.parametrize("solver", SOLVERS)
def test_the_same_question_has_the_same_bits_for_an_answer(solver):
    ocp, attitude = report(), near(3)
    first = solver(ocp)
    one = first.solve(attitude, REST)
    first.solve(near(8), REST)
    first.solve(FAR, REST, soft=True)
    for again in (first.solve(attitude, REST), solver(ocp).solve(attitude, REST)):
        for a, b in zip(arrays(one), arrays(again), strict=True):
            assert np.array_equal(a, b, equal_nan=True)


@pytest.mark.parametrize("model", EXACT)
def test_a_warm_start_takes_few_iterations_and_the_plan_stays_feasible(model):
    """Over a closed loop on the plant; the model is exact, so the shifted plan is feasible."""
    ocp = report(model)
    solver = SqpSolver(ocp)
    plant = Gyrostat(ocp.inertia, np.eye(3)[:, :2], [0.043] * 2, 1.0, 100.0, 5.0)
    state = plant.state_from_momentum(from_euler_321(SLEW), np.zeros(3), REST)
    warm, costs, iterations = None, [], []
    for _ in range(60):
        plan = solver.solve(state.attitude, state.wheel_speed, warm_start=warm)
        assert plan.converged
        costs.append(plan.cost)
        iterations.append(plan.iterations)
        state, warm = plant.step(state, plan.accelerations[0], 10), plan.warm_start
    assert (np.diff(costs) < 1e-6).all()  # a Lyapunov function of the loop
    assert np.median(iterations[1:]) <= 5
    assert lie.angle_between(state.attitude, np.eye(3)) < 0.01
    assert np.linalg.norm(state.angular_velocity) < 1e-3


def test_without_a_search_only_the_warm_start_is_tried():
    solver = SqpSolver(report(), max_iterations=1)
    warm = SqpSolver(report()).solve(near(5), REST).warm_start
    plan = solver.solve(near(6), REST, warm_start=warm, search=False)
    assert not plan.converged
    assert plan.iterations == 1
    assert plan.restarts == 0
    assert solver.solve(near(6), REST, warm_start=warm).restarts > 0


def test_the_chord_method_finds_the_same_plan_in_more_steps():
    ocp, attitude = report(), near(4)
    newton, chord = (SqpSolver(ocp, chord=chord).solve(attitude, REST) for chord in (False, True))
    assert chord.converged
    assert chord.cost == pytest.approx(newton.cost, rel=1e-6)
    assert chord.iterations >= newton.iterations


@pytest.mark.long
@pytest.mark.parametrize("model", MODELS)
def test_of_the_report_s_circle_ten_points_of_twenty_four_are_infeasible(model):
    """Figure 1: phi = 0.5 cos, psi = 0.5 sin; infeasible about pure yaw."""
    solver = SqpSolver(report(model))
    angles = 2.0 * np.pi * np.arange(24) / 24
    infeasible = [
        not solver.solve(
            from_euler_321(0.5 * np.array([np.cos(a), 0.0, np.sin(a)])), REST
        ).converged
        for a in angles
    ]
    assert np.flatnonzero(infeasible).tolist() == [4, 5, 6, 7, 8, 16, 17, 18, 19, 20]


@pytest.mark.parametrize("model", MODELS)
def test_the_first_command_jumps_from_limit_to_limit_across_zero_roll(model):
    """Section 3.1.2: the feedback is discontinuous, as Brockett's condition asks."""
    solver = SqpSolver(report(model))
    left, right = (
        solver.solve(from_euler_321(0.25 * np.array([np.cos(a), 0.0, np.sin(a)])), REST)
        for a in (np.pi / 2 + 0.05, np.pi / 2 - 0.05)
    )
    assert left.converged
    assert right.converged
    assert abs(left.accelerations[0, 0]) == pytest.approx(5.0, abs=1e-6)
    assert left.accelerations[0, 0] == pytest.approx(-right.accelerations[0, 0], abs=1e-6)


@pytest.mark.parametrize("solver", SOLVERS)
def test_the_largest_yaw_that_is_feasible_is_that_of_the_notes(solver):
    found = solver(report("simplified"))
    assert found.solve(from_euler_321(np.array([0.0, 0.0, 0.327])), REST).converged
    assert not found.solve(from_euler_321(np.array([0.0, 0.0, 0.34])), REST).converged


def test_the_shortest_horizon_is_feasible_and_no_shorter_one_is():
    ocp, attitude = report(), from_euler_321(YAW)
    least = shortest_horizon(ocp, attitude, REST)
    assert least is not None
    assert 20 < least < 30
    for horizon, feasible in ((least, True), (least - 1, False)):
        plan = SqpSolver(report(horizon=horizon)).solve(attitude, REST)
        assert plan.converged == feasible
    assert shortest_horizon(ocp, np.eye(3), REST) == 1


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"horizon": 0}, "horizon"),
        ({"time_step": -1.0}, "time_step"),
        ({"model": "linear"}, "simplified"),
        ({"attitude_weights": (1.0, 0.0, 1.0)}, "attitude_weights"),
        ({"acceleration_weight": 0.0}, "acceleration_weight"),
        ({"max_speed": -1.0}, "max_speed"),
        ({"wheels": np.eye(3)[:, [0, 0]]}, "parallel"),
        ({"wheels": np.eye(3)}, "wheels"),
    ],
)
def test_a_problem_that_makes_no_sense_is_refused(change, words):
    with pytest.raises(GncError, match=words):
        dataclasses.replace(report(), **change)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((2.0 * np.eye(3), REST), "attitude"),
        ((np.eye(3), [0.0, np.nan]), "wheel_speed"),
        ((np.eye(3), np.zeros(3)), "wheel_speed"),
        ((np.eye(3), REST, np.zeros((3, 3))), "reference"),
    ],
)
def test_a_state_that_makes_no_sense_is_refused(solver, arguments, words):
    with pytest.raises(GncError, match=words):
        solver(report(horizon=5)).solve(*arguments)


@pytest.mark.parametrize("solver", SOLVERS)
def test_options_and_drifts_that_make_no_sense_are_refused(solver):
    ocp = report(horizon=5)
    with pytest.raises(GncError, match="drift"):
        solver(ocp).solve(np.eye(3), REST, drift=np.zeros((5, 3)))
    for option in ({"tolerance": 0.0}, {"max_iterations": 0}, {"restarts": -1}):
        with pytest.raises(GncError, match=next(iter(option))):
            solver(ocp, **option)
    with pytest.raises(GncError, match="ocp"):
        solver(None)


def test_without_casadi_ipopt_is_refused_with_the_remedy_and_the_sqp_works():
    code = """
sys.path.insert(0, "test")
from wheel_problems import near, report, REST
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.vehicles.two_wheel.ocp.ipopt import IpoptSolver
from spacecraft_gnc.vehicles.two_wheel.ocp.sqp import SqpSolver
assert SqpSolver(report()).solve(near(1), REST).converged
try:
    IpoptSolver(report())
except GncError as error:
    print(error)
"""
    done = run_without(("casadi",), code)
    assert done.returncode == 0, done.stderr
    assert "pip install 'spacecraft_gnc[reference]'" in done.stdout
    assert done.stdout.count("\n") == 1
