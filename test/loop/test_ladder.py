"""The failure ladder, every rung by a forced failure."""

from __future__ import annotations

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.loop import Reference, Source, State
from spacecraft_gnc.ocp import Status, linearize
from spacecraft_gnc.ocp.linearization import deviation

LIMIT = 0.01
TOO_FAST = np.array([0.0, 3.0, 0.0])
INERTIA = np.diag([1.0, 0.8, 0.8])
TARGET = Reference(np.eye(3), np.zeros(3), np.zeros(3))
START = State(0, lie.exp(np.array([0.25, 0.5, 0.5])), np.zeros(3))


def unsolved(*_):
    """Stand in for a solve that raised."""


def too_fast(step):
    """A state from which no prediction exists, so that every solve fails."""
    return State(step, START.attitude, TOO_FAST)


def test_the_plan_is_corrected_for_where_the_body_is_until_it_ends(build):
    controller = build().controller
    good = controller.command(START, TARGET)
    assert good.source is Source.OPTIMAL
    plan = good.report.solution
    gains = linearize(plan).gains
    for ahead in range(1, 5):
        command = controller.command(too_fast(ahead), TARGET)
        assert command.source is Source.NEIGHBORING_EXTREMAL
        assert command.report.solution.status is Status.UNSOLVABLE_STEP
        off = deviation(START.attitude, TOO_FAST, plan.attitudes[ahead], plan.momenta[ahead])
        wanted = plan.torques[ahead] + gains[ahead] @ off
        assert np.abs(np.cross(command.control, wanted)).max() < 1e-15
        assert command.control @ wanted > 0.0
        assert np.linalg.norm(command.control) == pytest.approx(LIMIT, rel=1e-14)  # it is far off
    assert controller.command(too_fast(5), TARGET).source is Source.FEEDBACK


def test_on_its_plan_the_correction_is_the_plan(build, monkeypatch):
    controller = build().controller
    plan = controller.command(START, TARGET).report.solution
    monkeypatch.setattr(controller, "solve", unsolved)
    for ahead in range(1, 5):
        state = State(ahead, plan.attitudes[ahead], plan.momenta[ahead])
        command = controller.command(state, TARGET)
        assert command.source is Source.NEIGHBORING_EXTREMAL
        # The penalty leaves 1e-9 beyond the limit; this rung cuts it off.
        assert np.abs(command.control - plan.torques[ahead]).max() < 1e-8


def test_near_its_plan_the_correction_is_nearly_optimal(build, monkeypatch):
    controller, fresh = build().controller, build().controller
    calm = State(0, lie.exp(np.array([0.02, 0.04, 0.03])), np.zeros(3))
    plan = controller.command(calm, TARGET).report.solution
    monkeypatch.setattr(controller, "solve", unsolved)
    kick = np.array([1e-4, -2e-4, 1e-4])  # [N m s]: the torque answers with some 1e-5
    state = State(1, plan.attitudes[1], plan.momenta[1] + kick)
    corrected = controller.command(state, TARGET).control
    # The tail of a plan is not the plan of the next horizon; compare what the kick changes.
    optimal = (
        fresh.command(state, TARGET).control
        - fresh.command(State(2, plan.attitudes[1], plan.momenta[1]), TARGET).control
    )
    assert np.linalg.norm(optimal) > 1e-6
    assert np.linalg.norm(corrected - plan.torques[1] - optimal) < 0.5 * np.linalg.norm(optimal)


@pytest.mark.parametrize("why", ["another target", "far from the plan"])
def test_the_plan_is_shifted_where_no_correction_holds(build, monkeypatch, why):
    controller = build().controller
    plan = controller.command(START, TARGET).report.solution
    monkeypatch.setattr(controller, "solve", unsolved)
    target = Reference(lie.exp(np.array([0.0, 0.0, 0.1])), np.zeros(3), np.zeros(3))
    for ahead in range(1, 5):
        attitude = plan.attitudes[ahead]
        if why == "far from the plan":
            attitude, target = attitude @ lie.exp(np.array([0.0, 0.25, 0.0])), TARGET
        command = controller.command(State(ahead, attitude, plan.momenta[ahead]), target)
        assert command.source is Source.SHIFTED_PLAN
        assert np.array_equal(command.control, plan.torques[ahead])
    assert controller.command(State(5, *START[1:]), target).source is Source.FEEDBACK


def test_a_plan_is_no_use_for_a_step_before_it_or_after_a_reset(build, monkeypatch):
    controller = build().controller
    controller.command(State(7, *START[1:]), TARGET)
    monkeypatch.setattr(controller, "solve", unsolved)
    assert controller.command(State(7, *START[1:]), TARGET).source is Source.FEEDBACK
    assert controller.command(State(6, *START[1:]), TARGET).source is Source.FEEDBACK
    assert controller.command(State(8, *START[1:]), TARGET).source < Source.FEEDBACK
    controller.reset()
    assert controller.command(State(8, *START[1:]), TARGET).source is Source.FEEDBACK


@pytest.mark.parametrize(
    "actuators",
    [
        None,
        np.array([[0.9, 0.3, -0.2], [0.1, 1.2, 0.4], [-0.3, 0.2, 0.7]]),
        np.array([[1.0, -1.0, -1.0, 1.0], [1.0, 1.0, -1.0, -1.0], [1.0, 1.0, 1.0, 1.0]]) / 3**0.5,
        np.array([[1.0, 0.2], [0.0, 0.7], [0.3, -0.5]]),
    ],
    ids=["none", "skew", "pyramid", "two"],
)
def test_every_rung_respects_the_limit_of_the_actuators(build, actuators):
    controller = build(actuators=actuators).controller
    ocp = controller.solver.ocp
    turned = Reference(lie.exp(np.array([0.5, 0.0, 0.1])), np.zeros(3), np.zeros(3))
    nowhere = State(9, np.full((3, 3), np.nan), np.zeros(3))
    commands = [
        controller.command(START, TARGET), controller.command(too_fast(1), TARGET),
        controller.command(too_fast(2), turned), controller.command(too_fast(8), TARGET),
        controller.command(nowhere, TARGET),
    ]  # fmt: skip
    rungs = [Source.OPTIMAL, Source.NEIGHBORING_EXTREMAL, Source.SHIFTED_PLAN, Source.FEEDBACK]
    assert [command.source for command in commands] == [*rungs, Source.ZERO]
    for command in commands:
        controls = ocp.allocation @ command.control
        # What the actuators cannot give is not asked for.
        assert np.abs(ocp.torque_map @ controls - command.control).max() < 1e-15
        # Optimal ones, and the plan, are limited by the penalty: 1e-8 for 1e10.
        soft = command.source in (Source.OPTIMAL, Source.SHIFTED_PLAN)
        assert np.linalg.norm(controls) <= LIMIT + (1e-8 if soft else 1e-16)  # rounding of B^+ B
    assert np.linalg.norm(commands[3].control) > 0.0


def test_a_failed_solve_does_not_poison_the_next(build):
    controller, fresh = build().controller, build().controller
    controller.command(START, TARGET)
    controller.command(too_fast(1), TARGET)
    after = controller.command(State(2, *START[1:]), TARGET)
    expected = fresh.command(State(2, *START[1:]), TARGET)
    assert after.source is Source.OPTIMAL
    assert np.array_equal(after.control, expected.control)
    assert np.array_equal(after.report.solution.costates, expected.report.solution.costates)
    assert after.report.solution.iterations == expected.report.solution.iterations


def test_a_bad_warm_start_is_tried_once_more_from_zero(build):
    controller = build().controller
    controller._warm_start = np.full((5, 6), 1e300)
    assert controller.command(START, TARGET).source is Source.OPTIMAL


def test_a_state_that_is_none_gives_zero_torque_and_no_exception(build):
    controller = build().controller
    broken = State(7, np.full((3, 3), np.nan), np.zeros(3))
    command = controller.command(broken, TARGET)
    assert command.source is Source.ZERO
    assert command.report.solution is None
    assert np.array_equal(command.control, np.zeros(3))
