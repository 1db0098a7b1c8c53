"""The failure ladder, every rung by a forced failure."""

from __future__ import annotations

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.loop import Reference, Source, State
from spacecraft_gnc.loop.ladder import SaturatedFeedback
from spacecraft_gnc.ocp import Status

INERTIA = np.diag([1.0, 0.8, 0.8])
TARGET = Reference(np.eye(3), np.zeros(3), np.zeros(3))
START = State(0, lie.exp(np.array([0.25, 0.5, 0.5])), np.zeros(3))


def too_fast(step):
    """A state from which no prediction exists, so that every solve fails."""
    return State(step, START.attitude, np.array([0.0, 3.0, 0.0]))


def test_the_plan_is_shifted_until_it_ends_then_feedback_takes_over(build):
    controller = build().controller
    good = controller.command(START, TARGET)
    assert good.source is Source.OPTIMAL
    for ahead in range(1, 5):
        command = controller.command(too_fast(ahead), TARGET)
        assert command.source is Source.SHIFTED_PLAN
        assert np.array_equal(command.torque, good.solution.torques[ahead])
        assert command.solution.status is Status.UNSOLVABLE_STEP
    assert controller.command(too_fast(5), TARGET).source is Source.FEEDBACK


def test_a_failed_solve_does_not_poison_the_next(build):
    controller, fresh = build().controller, build().controller
    controller.command(START, TARGET)
    controller.command(too_fast(1), TARGET)
    after = controller.command(State(2, *START[1:]), TARGET)
    expected = fresh.command(State(2, *START[1:]), TARGET)
    assert after.source is Source.OPTIMAL
    assert np.array_equal(after.torque, expected.torque)


def test_a_bad_warm_start_is_tried_once_more_from_zero(build):
    controller = build().controller
    controller._warm_start = np.full((5, 6), 1e300)
    assert controller.command(START, TARGET).source is Source.OPTIMAL


def test_a_state_that_is_none_gives_zero_torque_and_no_exception(build):
    controller = build().controller
    broken = State(7, np.full((3, 3), np.nan), np.zeros(3))
    command = controller.command(broken, TARGET)
    assert command.source is Source.ZERO
    assert command.solution is None
    assert np.array_equal(command.torque, np.zeros(3))


def test_feedback_respects_the_limit_and_points_home():
    law = SaturatedFeedback(INERTIA, 0.125, 0.01)
    torque = law.torque(START, TARGET)
    assert np.linalg.norm(torque) <= 0.01 * (1 + 1e-12)
    assert torque @ np.array([0.25, 0.5, 0.5]) < 0.0
    assert law.torque(State(0, np.eye(3), np.zeros(3)), TARGET) == pytest.approx(np.zeros(3))


def test_feedback_alone_brings_the_spacecraft_home(build):
    plant = build().plant
    law = SaturatedFeedback(INERTIA, 0.125, 0.01)
    for _ in range(1000):
        plant.step(law.torque(plant.state, TARGET))
    assert lie.angle_between(plant.state.attitude, np.eye(3)) < 1e-3
    assert np.linalg.norm(plant.state.momentum) < 1e-4
