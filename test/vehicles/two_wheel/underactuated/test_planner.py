"""The planner of two wheels: what it does where no plan is found, or a step was missed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from two_wheels import scenario_of

from spacecraft_gnc import lie
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.loop.protocols import Reference, Source
from spacecraft_gnc.status import Status
from spacecraft_gnc.vehicles.two_wheel.controllers.report import Terminal
from spacecraft_gnc.vehicles.two_wheel.controllers.underactuated import planner as planning
from spacecraft_gnc.vehicles.two_wheel.controllers.underactuated.planner import TwoWheelPlanner
from spacecraft_gnc.vehicles.two_wheel.controllers.underactuated.shaping import path_between
from spacecraft_gnc.vehicles.two_wheel.ocp.problem import WheelOcp

OCP = WheelOcp(
    np.diag([430.0, 1210.0, 1300.0]), 0.043 * np.eye(3)[:, :2], 10.0,
    attitude_weights=(1.0, 1.0, 30.0), max_speed=100.0, max_acceleration=5.0,
)  # fmt: skip
NEAR = lie.exp(np.array([0.2, -0.1, 0.05]))
FAR = lie.exp(np.array([0.0, 0.0, 1.5]))
STILL = np.zeros(2)


class Failing:
    """A solver whose solves fail from now on."""

    def __init__(self, solver):
        self.solver = solver

    def solve(self, *state, **options):
        """Return a solution that says so."""
        return replace(self.solver.solve(*state, **options), status=Status.MAX_ITERATIONS)


@pytest.mark.parametrize("missed", [1, 4])
def test_where_no_plan_is_found_the_last_one_is_flown_on(missed):
    planner = TwoWheelPlanner(OCP)
    plan = planner.plan(0, NEAR, STILL, np.eye(3))
    assert (plan.source, plan.terminal) == (Source.OPTIMAL, Terminal.REFERENCE)
    planner.solver = Failing(planner.solver)
    known = plan.solution
    state = known.attitudes[missed], known.speeds[missed]
    later = planner.plan(missed, *state, np.eye(3))
    assert later.source is Source.SHIFTED_PLAN
    assert np.array_equal(later.acceleration, known.accelerations[missed])
    assert later.solution.status is Status.MAX_ITERATIONS


def test_without_a_plan_the_wheels_brake():
    planner = TwoWheelPlanner(OCP)
    planner.solver = Failing(planner.solver)
    plan = planner.plan(0, NEAR, np.array([80.0, -20.0]), np.eye(3))
    assert plan.source is Source.FEEDBACK
    np.testing.assert_allclose(plan.acceleration, [-5.0, 2.0])


def test_a_missed_step_is_bridged_by_the_plan_before():
    planner = TwoWheelPlanner(OCP)
    known = planner.plan(0, NEAR, STILL, np.eye(3)).solution
    later = planner.plan(3, known.attitudes[3], known.speeds[3], np.eye(3))
    assert later.source is Source.OPTIMAL
    assert later.solution.restarts == 0  # from what is left of the plan, without a search
    np.testing.assert_allclose(later.solution.speeds[0], known.speeds[3])


@pytest.mark.parametrize(
    ("terminal", "target", "expected"),
    [
        ("shaped", [0.0, 0.0, 3.0], Terminal.WAYPOINT),
        ("shaped", [0.0, 0.0, 1.0], Terminal.SOFT),
        ("soft", [0.0, 0.0, 1.0], Terminal.SOFT),
    ],
)
def test_a_target_out_of_reach_is_approached(terminal, target, expected, monkeypatch):
    if expected is Terminal.WAYPOINT:  # no soft end advances enough
        monkeypatch.setattr(planning, "_PROGRESS", 1e9)
    planner, far = TwoWheelPlanner(OCP, terminal=terminal), lie.exp(np.array(target))
    plan = planner.plan(0, far, STILL, np.eye(3))
    assert (plan.source, plan.terminal) == (Source.OPTIMAL, expected)
    end = plan.solution.attitudes[-1]
    assert np.array_equal(plan.solution.speeds[-1], STILL)
    assert lie.angle_between(end, np.eye(3)) > 0.1
    if expected is Terminal.WAYPOINT:
        np.testing.assert_allclose(end, plan.solution.reference, atol=1e-6)
    if terminal == "shaped":
        assert planner.path_left >= path_between(OCP, end, np.eye(3)).time * (1.0 - 1e-6)
        assert planner.path_left < path_between(OCP, far, np.eye(3)).time - 5.0


def test_with_a_hard_end_nothing_else_is_tried():
    plan = TwoWheelPlanner(OCP, terminal="hard").plan(0, FAR, STILL, np.eye(3))
    assert plan.terminal is Terminal.REFERENCE
    assert plan.source is Source.FEEDBACK
    assert plan.solution.status is not Status.CONVERGED


def test_a_start_while_turning_is_stopped_on_the_way():
    speed = np.array([60.0, -90.0])
    plan = TwoWheelPlanner(OCP).plan(0, FAR, speed, np.eye(3))
    assert plan.source is Source.OPTIMAL
    assert np.array_equal(plan.solution.speeds[0], speed)


def test_a_known_drift_is_planned_for():
    drift = np.zeros((31, 3))
    drift[:6] = np.linspace([2e-3, -1e-3, 5e-4], 0.0, 6)
    planner = TwoWheelPlanner(OCP)
    plan = planner.plan(0, NEAR, STILL, np.eye(3), drift)
    assert plan.source is Source.OPTIMAL
    rates = plan.solution.speeds @ (OCP.frame @ OCP.rates).T + drift
    attitude, fine = NEAR, 50
    for k in range(30):  # the midpoint rule in small steps
        for i in range(fine):
            share = (i + 0.5) / fine
            rate = (1.0 - share) * rates[k] + share * rates[k + 1]
            attitude = attitude @ lie.exp(10.0 / fine * rate)
    np.testing.assert_allclose(attitude, np.eye(3), atol=1e-5)


@pytest.mark.parametrize(
    ("options", "words"), [({"solver": "fmincon"}, "solver"), ({"terminal": "none"}, "terminal")]
)
def test_other_words_are_refused(options, words):
    with pytest.raises(ParameterError, match=f"{words}: received .*required one of"):
        TwoWheelPlanner(OCP, **options)


def test_what_is_no_state_gives_no_acceleration():
    scenario = scenario_of()
    controller, state = scenario.build_controller(), scenario.build_plant().state
    still = np.zeros(3)
    for bad in (state._replace(attitude=np.full((3, 3), np.nan)),
                state._replace(wheel_speed=np.array([np.nan, 0.0]))):  # fmt: skip
        command = controller.command(bad, Reference(np.eye(3), still, still))
        assert command.source is Source.ZERO
        assert np.array_equal(command.control, STILL)
    command = controller.command(state, Reference(np.full((3, 3), np.nan), still, still))
    assert command.source is Source.ZERO
