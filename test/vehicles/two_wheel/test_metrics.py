"""Metrics of flights written by hand."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.vehicles.two_wheel import metrics
from spacecraft_gnc.vehicles.two_wheel.summary import direction

TIME = 10.0 * np.arange(5)
TARGET = lie.exp(np.array([0.5, 0.0, 1.0]))
NONE_KNOWN = np.full((5, 3, 3), math.nan)


def attitudes(*errors):
    return np.stack([TARGET @ lie.exp(error * np.array([0.6, 0.0, 0.8])) for error in errors])


def rates(*sizes):
    return np.outer(sizes, [0.0, 1.0, 0.0])


@pytest.mark.parametrize(
    ("errors", "sizes", "expected"),
    [
        ((0.5, 0.2, 0.009, 0.009, 0.001), (0.01, 0.01, 0.0009, 0.0, 0.0), 20.0),
        ((0.5, 0.009, 0.02, 0.009, 0.001), (0.0,) * 5, 30.0),  # back out again
        ((0.009,) * 5, (0.0, 0.0, 0.0, 0.002, 0.0), 40.0),  # still turning
        ((0.009,) * 5, (0.0,) * 5, 0.0),
        ((0.009, 0.009, 0.009, 0.009, 0.0101), (0.0,) * 5, None),
        ((0.009,) * 5, (0.0, 0.0, 0.0, 0.0, 0.0011), None),
    ],
)
def test_settle_time_is_that_of_attitude_and_rate_for_good(errors, sizes, expected):
    assert metrics.settle_time(TIME, attitudes(*errors), rates(*sizes), TARGET) == expected


def test_unknown_states_are_passed_over():
    known = attitudes(0.5, 0.2, 0.005, 0.005, 0.005)
    known[3:] = math.nan
    assert metrics.settle_time(TIME, known, rates(*[0.0] * 5), TARGET) == 20.0
    assert metrics.final_error_deg(known, TARGET) == pytest.approx(math.degrees(0.005), rel=1e-9)
    assert metrics.final_error_deg(NONE_KNOWN, TARGET) is None
    assert metrics.settle_time(TIME, NONE_KNOWN, rates(*[0.0] * 5), TARGET) is None
    assert metrics.largest(np.array([[math.nan, -3.0], [2.0, math.nan]])) == 3.0
    assert metrics.largest(np.full((2, 2), math.nan)) is None


def _wheels(steps):
    """Return which of four wheels answer, false from a step on: by the wheel's index."""
    answers = np.ones((5, 4), dtype=bool)
    for wheel, step in steps.items():
        answers[step:, wheel] = False
    return answers


def _loss(wheel, lost_at, detected_at):
    return {"wheel": wheel, "lost_at": lost_at, "detected_at": detected_at}


def test_without_a_loss_there_is_none():
    assert metrics.losses(TIME, _wheels({}), _wheels({})) == ([], [])
    assert metrics.losses(TIME, None, None) == ([], [])


def test_every_loss_is_told_in_their_order_with_its_own_detection():
    found = metrics.losses(TIME, _wheels({2: 1, 0: 2, 3: 3}), _wheels({2: 2, 3: 4}))
    assert found.losses == [_loss(3, 10.0, 20.0), _loss(1, 20.0, None), _loss(4, 30.0, 40.0)]
    assert found.false_alarms == []


def test_an_alarm_before_the_loss_is_no_detection():
    alarm = {"wheel": 2, "at": 10.0}
    found = metrics.losses(TIME, _wheels({1: 3}), _wheels({1: 1}))
    assert found == ([_loss(2, 30.0, None)], [alarm])
    another = metrics.losses(TIME, _wheels({0: 3}), _wheels({1: 1, 0: 4}))
    assert another == ([_loss(1, 30.0, 40.0)], [alarm])
    assert metrics.losses(TIME, _wheels({}), _wheels({1: 1})) == ([], [alarm])


def test_an_alarm_in_the_step_of_the_loss_is_its_detection():
    assert metrics.losses(TIME, _wheels({1: 1}), _wheels({1: 1})) == ([_loss(2, 10.0, 10.0)], [])


def test_the_summary_is_json():
    healthy, diagnosed = np.ones((2, 5, 3), dtype=bool)
    healthy[1:, 0] = False
    diagnosed[2:, 0] = False
    flight = (attitudes(*[0.1] * 5), rates(*[0.0] * 5), np.full((5, 3), -7.0), np.ones((4, 3)))
    found = json.loads(json.dumps(metrics.summarize(TIME, *flight, TARGET, healthy, diagnosed)))
    assert found.pop("final_error_deg") == pytest.approx(math.degrees(0.1), rel=1e-12)
    assert found == {
        "settle_time": None, "max_wheel_speed": 7.0, "max_wheel_acceleration": 1.0,
        "wheel_lost_at": 10.0, "wheel_loss_detected_at": 20.0,
        "wheel_losses": [_loss(1, 10.0, 20.0)], "false_alarms": [],
    }  # fmt: skip


def test_a_direction_is_told_without_its_rounding():
    assert direction([-0.0, -1.22e-16, 1.0]) == "0, 0, 1"
    assert direction([0.6, -0.8, -4e-4], " ") == "0.6 -0.8 0"
