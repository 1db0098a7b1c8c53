"""Metrics of docking flights written by hand."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from docked import PERIOD, aborted, flight, scenario

from spacecraft_gnc import lie
from spacecraft_gnc.vehicles.docking import metrics
from spacecraft_gnc.vehicles.docking.limits import limits_exceeded

TIME = 5.0 * np.arange(5)
AXIS = np.array([0.6, 0.0, 0.8])


def offsets(*distances):
    return np.outer(distances, AXIS)


def turned(*degrees):
    return np.stack([lie.exp(np.radians(angle) * AXIS[::-1]) for angle in degrees])


@pytest.mark.parametrize(
    ("distances", "degrees", "expected"),
    [
        ((3.0, 1.0, 0.0199, 0.01, 0.0), (9.0, 3.0, 0.99, 0.5, 0.0), 10.0),
        ((3.0, 0.01, 0.0201, 0.01, 0.0), (0.0,) * 5, 15.0),  # back out again
        ((0.0,) * 5, (9.0, 9.0, 9.0, 1.01, 0.99), 20.0),  # turned for longer
        ((0.0,) * 5, (0.0,) * 5, 0.0),
        ((3.0, 0.0, 0.0, 0.0, 0.021), (0.0,) * 5, None),
        ((0.0,) * 5, (0.0, 0.0, 0.0, 0.0, 1.01), None),
    ],
)
def test_docked_is_two_centimeters_and_one_degree_for_good(distances, degrees, expected):
    assert metrics.docked_at(TIME, offsets(*distances), turned(*degrees)) == expected


def test_unknown_states_are_passed_over():
    offset, attitude = offsets(3.0, 0.0, 0.0, 0.0, 0.0), turned(*[0.0] * 5)
    offset[1], attitude[2] = math.nan, math.nan
    assert metrics.docked_at(TIME, offset, attitude) == 15.0
    assert metrics.docked_at(TIME, np.full((5, 3), math.nan), attitude) is None
    values = np.array([math.nan, 3.0, -4.0, math.nan])
    assert metrics.last_known(values) == -4.0
    assert metrics.largest(values) == 4.0
    assert metrics.least(values) == -4.0
    for function in (metrics.last_known, metrics.largest, metrics.least):
        assert function(np.full(2, math.nan)) is None


def test_the_impulse_is_that_of_the_force_within_its_limit():
    force = np.array([[3.0, 4.0, 0.0], [0.0, math.nan, 0.0], [0.0, 0.0, -2.0]])
    assert metrics.impulse(force, 5.0) == pytest.approx(35.0)
    assert metrics.impulse(force, 5.0, 1.0) == pytest.approx(5.0 * (math.sqrt(2.0) + 1.0))


def test_the_reference_settles_where_it_stays_at_the_target():
    reference, target = np.zeros((5, 6)), np.zeros((5, 6))
    reference[:2, 0], reference[2, 5] = 1.0, 1e-5
    assert metrics.settled_at(TIME, reference, target) == 15.0
    reference[4, 1] = -1e-5
    assert metrics.settled_at(TIME, reference, target) is None


def _thrusters(steps):
    """Return which of six directions answer, false from a step on: by the direction's index."""
    answers = np.ones((5, 6), dtype=bool)
    for direction, step in steps.items():
        answers[step:, direction] = False
    return answers


@pytest.mark.parametrize(
    ("lost", "concluded", "expected"),
    [
        ({}, [-1] * 5, (None, None, None, [])),
        ({4: 2}, [-1, -1, -1, 4, 4], ("-y", 10.0, 15.0, [])),
        ({4: 2}, [-1] * 5, ("-y", 10.0, None, [])),
        ({4: 2}, [-1, -1, -1, 1, 1], ("-y", 10.0, None, [("+y", 15.0)])),  # another one
        ({4: 2}, [-1, 4, 4, 4, 4], ("-y", 10.0, None, [("-y", 5.0)])),
        ({}, [-1, -1, 0, 0, 0], (None, None, None, [("+x", 10.0)])),
        ({1: 3, 2: 1}, [-1, -1, 2, 2, 1], ("+z", 5.0, 10.0, [])),
    ],
)
def test_a_loss_stands_beside_its_detection(lost, concluded, expected):
    *first, alarms = expected
    found = metrics.loss(TIME, _thrusters(lost), np.array(concluded))
    assert list(found[:3]) == first
    assert [(a["thruster"], a["at"]) for a in found.false_alarms] == alarms
    json.dumps(found._asdict())


def test_every_constraint_that_is_broken_is_named_with_how_much():
    n = 60
    force, moment = np.zeros((n, 3)), np.zeros((n, 3))
    force[7, 1], moment[3, 2] = -1.7, 0.1
    margin, clearance = np.ones(n), np.ones(n)
    margin[11] = -0.25
    flown = flight(
        force=force, moment=moment, line_of_sight_margin=margin, clearance=clearance,
        final_clearance=np.array(-0.07),
    )  # fmt: skip
    found = {each.limit: each for each in limits_exceeded(flown, scenario())}
    assert {name: str(each) for name, each in found.items()} == {
        "force": "force 1.7 times (1.7 N, limit 1 N)",
        "moment": "moment 2 times (0.1 N m, limit 0.05 N m)",
        "line of sight": "line of sight by 0.25 m",
        "clearance": "clearance by 0.05 m",
    }
    assert found["clearance"].value == pytest.approx(0.05)
    assert found["line of sight"].factor == pytest.approx(1.25)


@pytest.mark.parametrize("made", [flight, aborted])
def test_a_flight_at_its_limits_breaks_none(made):
    n = 60
    force = np.full((n, 3), -1.0005)  # within 0.1 %
    held = made(n)
    margin = held.line_of_sight_margin.copy()
    margin[5], force[6] = -0.0009, math.nan
    clearance = np.full(n, -0.0209)
    kept = type(held)(
        **{name: getattr(held, name) for name in ("period", "time", *dict(held.columns()))}
        | {"force": force, "line_of_sight_margin": margin, "clearance": clearance}
    )
    assert not limits_exceeded(kept, scenario())
    assert PERIOD * n == 300.0
