"""Metrics of flights written by hand."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.vehicles.two_wheel import metrics

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


def test_losses_are_the_first_of_any_wheel():
    healthy = np.ones((5, 4), dtype=bool)
    assert metrics.first_loss(TIME, healthy) is None
    assert metrics.first_loss(TIME, None) is None
    healthy[3:, 2] = False
    healthy[4:, 0] = False
    assert metrics.first_loss(TIME, healthy) == 30.0


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
    }  # fmt: skip
