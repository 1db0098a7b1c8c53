"""When another plan is made, from where, and when it is taken."""

from __future__ import annotations

import math
from threading import Event

import numpy as np
import pytest
from transfer_cases import BODY, figure_4

from spacecraft_gnc import lie
from spacecraft_gnc.governors.planned.governor import PlannedGovernor
from spacecraft_gnc.governors.planned.guard import BoundGuard
from spacecraft_gnc.governors.planned.keeper import PlanKeeper
from spacecraft_gnc.governors.planned.replanner import Replanner
from spacecraft_gnc.governors.planned.report import Cause, Phase
from spacecraft_gnc.ocp.transfer import TransferSolver
from spacecraft_gnc.types import State

LIMITS = figure_4().limits
ELSEWHERE = lie.exp([0.3, -0.2, 0.4])
OFF = lie.exp([math.radians(2.5), 0.0, 0.0])


@pytest.fixture(scope="module")
def plan():
    return TransferSolver().solve(figure_4())


def keeper_of(plan, **options):
    return PlanKeeper(plan, BoundGuard(BODY, LIMITS), BODY.time_step, **options)


def on(plan, k, off=None):
    """The state of the plan at its step k, turned by ``off``."""
    k_there = min(k, plan.problem.n_steps)
    attitude = plan.attitude[k_there] if off is None else plan.attitude[k_there] @ off
    return State(k, attitude, plan.momentum[k_there])


def look(keeper, state, target):
    report = keeper.look(state, target)
    keeper.seek(state)
    return report


def test_a_body_on_its_plan_flies_it_and_arrives(plan):
    keeper, goal = keeper_of(plan), plan.problem.goal
    reports = [look(keeper, on(plan, k), goal) for k in range(195)]
    assert {report.number for report in reports} == {0}
    assert [report.plan_step for report in reports] == [*range(191), *[190] * 4]
    assert [report.phase for report in reports] == [Phase.FLYING] * 190 + [Phase.ARRIVED] * 5
    assert max(report.attitude_error for report in reports) < 1e-12
    first = reports[0].told[0]
    assert (first.number, first.first_step, first.cause) == (0, 0, Cause.START)
    assert first.solution is plan
    assert not any(report.told for report in reports[1:])


def test_off_the_plan_another_one_is_made_from_where_the_body_will_be(plan):
    keeper, goal = keeper_of(plan, lead=4), plan.problem.goal
    look(keeper, on(plan, 0), goal)
    state = on(plan, 50, OFF)
    for k in range(50, 54):
        report = look(keeper, state, goal)
        assert (report.phase, report.number) == (Phase.REPLANNING, 0)
        attitude, momentum = BODY.step(state.attitude, state.momentum, plan.torque[k])
        state = State(k + 1, attitude, momentum)
    report = look(keeper, state, goal)
    (told,) = report.told
    assert (told.number, told.first_step, told.cause) == (1, 54, Cause.DEVIATION)
    assert report.number == 1
    assert report.plan_step == 0
    assert report.phase is Phase.FLYING
    assert report.attitude_error < 1e-12  # the body went as it was predicted
    problem = told.solution.problem
    assert told.solution.converged
    assert problem.n_steps == 190 - 54  # the time that was left
    assert (problem.limits == LIMITS).all()
    assert np.allclose(problem.start_momentum, state.momentum, rtol=0.0, atol=1e-12)


def test_the_prediction_takes_what_is_going_to_be_commanded_within_the_bounds(plan):
    keeper, goal = keeper_of(plan, lead=2), plan.problem.goal
    state = on(plan, 0, OFF)
    keeper.look(state, goal)
    keeper.seek(state, np.array([[100.0, 0.0, -3.0]]))
    for k in (1, 2):
        report = keeper.look(on(plan, k, OFF), goal)
    attitude, momentum = BODY.step(state.attitude, state.momentum, np.array([20.0, 0.0, -3.0]))
    attitude, momentum = BODY.step(attitude, momentum, plan.torque[1])
    (told,) = report.told
    assert np.allclose(told.solution.problem.start, attitude, rtol=0.0, atol=1e-12)
    assert np.allclose(told.solution.problem.start_momentum, momentum, rtol=0.0, atol=1e-10)


def test_a_new_target_is_planned_for(plan):
    keeper, goal = keeper_of(plan), plan.problem.goal
    look(keeper, on(plan, 0), goal)
    assert look(keeper, on(plan, 1), ELSEWHERE).phase is Phase.REPLANNING
    for k in range(2, 6):
        assert look(keeper, on(plan, k), ELSEWHERE).phase is Phase.REPLANNING
    (told,) = look(keeper, on(plan, 6), ELSEWHERE).told
    assert told.cause is Cause.TARGET
    assert (told.solution.problem.goal == ELSEWHERE).all()
    assert told.solution.problem.n_steps >= 190
    assert told.solution.converged


def test_a_search_for_a_target_that_is_wanted_no_more_is_dropped(plan):
    keeper, goal = keeper_of(plan), plan.problem.goal
    look(keeper, on(plan, 0), ELSEWHERE)
    assert look(keeper, on(plan, 1), goal).phase is Phase.FLYING
    assert not any(look(keeper, on(plan, k), goal).told for k in range(2, 12))


def test_a_flight_that_starts_elsewhere_is_planned_anew(plan):
    keeper, goal = keeper_of(plan, replan_error=0.0), plan.problem.goal
    elsewhere = State(1000, plan.problem.goal @ ELSEWHERE, np.zeros(3))
    first = look(keeper, elsewhere, goal)
    assert (first.told[0].first_step, first.plan_step) == (1000, 0)
    assert first.phase is Phase.REPLANNING
    (told,) = look(keeper, elsewhere._replace(step=1005), goal).told
    assert (told.cause, told.first_step) == (Cause.DEVIATION, 1005)


def test_with_an_error_of_zero_the_plan_is_kept(plan):
    keeper, goal = keeper_of(plan, replan_error=0.0), plan.problem.goal
    look(keeper, on(plan, 0), goal)
    far = State(1, plan.attitude[1] @ ELSEWHERE, plan.momentum[1])
    assert look(keeper, far, goal).phase is Phase.FLYING


class Solver:
    """Solves when it is let, and counts."""

    def __init__(self, *, finds=True):
        self.let, self.finds, self.asked = Event(), finds, 0

    def solve(self, problem, *, max_work):
        self.let.wait(60.0)
        self.asked += 1
        found = TransferSolver().solve(problem)
        if self.finds:
            return found
        return TransferSolver(max_iterations=1, starts=1, homotopy=False).solve(
            figure_4(n_steps=150)
        )


def test_what_is_not_found_is_sought_again_later(plan):
    solver = Solver(finds=False)
    solver.let.set()
    keeper, goal = keeper_of(plan, solver=solver), plan.problem.goal
    phases = [look(keeper, on(plan, k, OFF), goal).phase for k in range(22)]
    sought = [Phase.REPLANNING] * 5
    assert phases == [*sought, *[Phase.NOT_FOUND] * 10, *sought, *[Phase.NOT_FOUND] * 2]
    assert solver.asked == 24  # durations
    solver.finds = True
    told = [look(keeper, on(plan, k, OFF), goal).told for k in range(22, 46)]
    assert [each.number for several in told for each in several] == [1]


def test_the_pause_after_a_search_doubles_until_the_target_changes(plan):
    solver = Solver(finds=False)
    solver.let.set()
    keeper, goal = keeper_of(plan, solver=solver, lead=1), plan.problem.goal
    phases = [look(keeper, on(plan, k, OFF), goal).phase for k in range(75)]
    asked = [k for k, phase in enumerate(phases) if phase is Phase.REPLANNING]
    assert asked == [0, 11, 32, 73]
    assert look(keeper, on(plan, 75), ELSEWHERE).phase is Phase.REPLANNING
    assert look(keeper, on(plan, 76), ELSEWHERE).phase is Phase.NOT_FOUND
    assert look(keeper, on(plan, 86), ELSEWHERE).phase is Phase.REPLANNING


def test_in_free_run_a_plan_is_taken_when_it_is_there(plan):
    solver = Solver()
    keeper, goal = keeper_of(plan, solver=solver), plan.problem.goal
    keeper.waits = False
    for k in range(20):
        report = look(keeper, on(plan, k, OFF), goal)
        assert (report.phase, report.number) == (Phase.REPLANNING, 0)
    solver.let.set()
    keeper._search.answer.result(60.0)
    (told,) = look(keeper, on(plan, 20, OFF), goal).told
    assert told.first_step == 5
    again = look(keeper, on(plan, 21, OFF), goal)
    assert again.plan_step == 16


def test_a_state_that_is_none_is_survived(plan):
    keeper, goal = keeper_of(plan), plan.problem.goal
    look(keeper, on(plan, 0), goal)
    nowhere = State(1, np.full((3, 3), np.nan), np.full(3, np.nan))
    report = look(keeper, nowhere, ELSEWHERE)
    assert np.isnan(report.attitude_error)
    assert look(keeper, on(plan, 2), ELSEWHERE).phase is Phase.NOT_FOUND


def test_reset_returns_to_the_first_plan(plan):
    keeper, goal = keeper_of(plan), plan.problem.goal
    look(keeper, on(plan, 0), ELSEWHERE)
    for k in range(1, 7):
        look(keeper, on(plan, k), ELSEWHERE)
    keeper.reset()
    report = look(keeper, on(plan, 0), goal)
    assert report.number == 0
    assert report.told[0].solution is plan


class Counting(TransferSolver):
    """Adds up the work."""

    __slots__ = ("found",)

    def solve(self, problem, start=None, *, max_work=0.0):
        one = super().solve(problem, start, max_work=max_work)
        self.found.append(one)
        return one


@pytest.mark.parametrize("push", [-580.0, -1780.0, -5980.0])
def test_the_work_of_a_search_is_bounded(push):
    """Momenta of a push in flight [N m s]; without a bound they take up to a minute."""
    solver = Counting()
    object.__setattr__(solver, "found", [])
    transfer = figure_4(n_steps=220, torque=18.0, momentum=56.0)
    attitude = lie.exp([0.3, 0.4, 0.2])
    found = Replanner(transfer, solver).find(
        attitude, np.array([20.0, 30.0, push]), transfer.goal, 140
    )
    assert (found is not None) == (push == -580.0)
    assert 1e5 < sum(one.work for one in solver.found) < 1.3e6


def test_a_momentum_outside_the_bounds_widens_them():
    problem = figure_4()
    momentum = np.array([75.0, -71.0, 0.0])
    found = Replanner(problem).find(np.eye(3), momentum, problem.goal, 100)
    assert found is not None
    assert found.converged
    assert found.problem.limits[2:].tolist() == [[-70.0, -71.0, -70.0], [75.0, 70.0, 70.0]]
    assert found.problem.n_steps > 100


def test_nothing_is_found_where_no_step_exists():
    assert Replanner(figure_4()).find(np.eye(3), np.full(3, 1e9), np.eye(3), 100) is None


def test_the_governor_publishes_the_plan_and_plans_to_a_new_target(plan):
    governor = PlannedGovernor(keeper_of(plan))
    decision = governor.decide(on(plan, 0))
    assert decision.reference is decision.report.reference
    assert (governor.target == plan.problem.goal).all()
    governor.set_target(ELSEWHERE)
    with pytest.raises(ValueError, match=r"target: .*rotation"):
        governor.set_target(2.0 * np.eye(3))
    assert (governor.target == ELSEWHERE).all()
    told = [governor.decide(on(plan, k)).report.told for k in range(1, 8)]
    assert [each.cause for several in told for each in several] == [Cause.TARGET]
    governor.reset()
    assert (governor.target == plan.problem.goal).all()
    assert governor.waits
    governor.waits = False
    assert not governor.keeper.waits
