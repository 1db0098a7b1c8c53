"""Metrics of flights in formation written by hand."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from formed import PERIOD, flight, loss, scenario

from spacecraft_gnc.vehicles.formation import metrics
from spacecraft_gnc.vehicles.formation.limits import (
    all_separations,
    communication_angles,
    limits_exceeded,
)

TIME = PERIOD * np.arange(5)
ALL = np.ones((5, 3), dtype=bool)


@pytest.mark.parametrize(
    ("errors", "equal", "expected"),
    [
        ((90.0, 20.0, 9.9, 1.0, 0.0), (1, 1, 1, 1, 1), 2),
        ((90.0, 9.0, 10.0, 1.0, 0.0), (1, 1, 1, 1, 1), 3),  # back out again
        ((90.0, 9.0, 2.0, 1.0, 0.0), (1, 1, 1, 0, 1), 4),  # another shift for one step
        ((0.0,) * 5, (1,) * 5, 0),
        ((0.0,) * 5, (1, 1, 1, 1, 0), None),
        ((0.0, 0.0, 0.0, 0.0, 11.0), (1,) * 5, None),
        ((90.0, math.nan, 9.0, math.nan, 0.0), (1,) * 5, 2),  # unknown steps are passed over
        ((math.nan,) * 5, (1,) * 5, None),
    ],
)
def test_formed_is_equal_shifts_and_small_errors_for_good(errors, equal, expected):
    found = metrics.formed_at_step(np.array(errors), np.array(equal, dtype=bool), 10.0)
    assert found == expected


def test_a_lost_craft_is_no_part_of_the_formation():
    position = np.zeros((2, 3, 3))
    position[:, 0, 0], position[:, 1, 1], position[:, 2, 2] = 3.0, -4.0, 500.0
    healthy = np.array([[True, True, True], [True, True, False]])
    errors = metrics.position_errors(position, np.zeros((2, 3, 3)), healthy)
    assert errors.tolist() == [500.0, 4.0]
    shift = np.array([[4, 4, 9], [4, 4, 9]])
    assert metrics.equal_shifts(shift, healthy).tolist() == [False, True]
    assert metrics.equal_shifts(np.full((2, 3), -1), healthy).tolist() == [False, False]
    norms = metrics.delta_v_norms(position, healthy)
    assert norms.tolist() == [[3.0, 4.0, 500.0], [3.0, 4.0, 0.0]]
    assert metrics.healthy_pairs(healthy).tolist() == [[True] * 3, [True, False, False]]


def test_an_unknown_position_makes_an_unknown_error():
    position = np.zeros((2, 3, 3))
    position[0, 1] = math.nan
    errors = metrics.position_errors(position, np.zeros((2, 3, 3)), ALL[:2])
    assert np.isnan(errors[0])
    assert errors[1] == 0.0
    none = metrics.position_errors(position, np.zeros((2, 3, 3)), ~ALL[:2])
    assert np.isnan(none).all()


def test_numbers_that_are_not_known_count_for_nothing():
    values = np.array([math.nan, 3.0, -4.0, math.inf])
    assert (metrics.largest(values), metrics.least(values)) == (3.0, -4.0)
    assert metrics.last_known(values) == -4.0
    for function in (metrics.largest, metrics.least, metrics.last_known):
        assert function(np.full(2, math.nan)) is None


def test_a_deadlock_is_counted_each_time_that_it_begins():
    assert metrics.occurrences(np.array([True, True, False, True, False])) == 2
    assert metrics.occurrences(np.zeros(4, dtype=bool)) == 0


def test_each_step_to_another_parked_formation_is_a_passage():
    passing = np.array([False, True, True, True, False, True])
    shift = np.array([[0, 9], [3, 9], [3, 9], [3, 3], [4, 3], [4, 3]])
    assert metrics.passages(passing, shift) == 2
    assert metrics.passages(~ALL[:, 0], shift[:5]) == 0


def _columns(steps):
    """Return flags (5, 3), true from a step on: by the index of the craft."""
    flags = np.zeros((5, 3), dtype=bool)
    for craft, step in steps.items():
        flags[step:, craft] = True
    return flags


@pytest.mark.parametrize(
    ("lost", "concluded", "expected"),
    [
        ({}, {}, (None, None, None, [])),
        ({1: 2}, {1: 3}, ("b", TIME[2], TIME[3], [])),
        ({1: 2}, {}, ("b", TIME[2], None, [])),
        ({1: 2}, {0: 3}, ("b", TIME[2], None, [("a", TIME[3])])),  # another one
        ({1: 2}, {1: 1}, ("b", TIME[2], None, [("b", TIME[1])])),
        ({}, {2: 0}, (None, None, None, [("c", 0.0)])),
        ({2: 1, 0: 3}, {2: 2, 0: 4}, ("c", TIME[1], TIME[2], [])),
    ],
)
def test_a_loss_stands_beside_its_detection(lost, concluded, expected):
    *first, alarms = expected
    found = metrics.loss(TIME, ~_columns(lost), _columns(concluded), ("a", "b", "c"))
    assert list(found[:3]) == first
    assert [(a["spacecraft"], a["at"]) for a in found.false_alarms] == alarms
    json.dumps(found._asdict())


def test_every_constraint_that_is_broken_is_named_with_how_much():
    flown = flight()
    delta_v = flown.delta_v.copy()
    delta_v[7, 1] = [0.6, 0.8, 0.9]
    position = np.concatenate([flown.position, flown.final_position[None]])
    position[-1, 1] = position[-1, 0] + [0.0, 0.0, 400.0]  # at the end alone
    broken = flight(all_positions=position, delta_v=delta_v)
    found = {each.limit: each for each in limits_exceeded(broken, scenario())}
    assert {name: str(each) for name, each in found.items()} == {
        "delta-v": "delta-v 1.345 times (1.345 m/s, limit 1 m/s)",
        "separation": "separation 400 m, at least 1000 m",
    }
    assert found["separation"].factor == pytest.approx(1.6)
    narrow = scenario(plant={"max_communication_angle_deg": 0.5})
    (angle,) = [e for e in limits_exceeded(flown, narrow) if e.limit.startswith("comm")]
    widest = communication_angles(flown).max()
    assert str(angle) == f"communication angle {widest:.4g} deg, limit 0.5 deg"


def test_a_flight_within_its_limits_breaks_none():
    assert not limits_exceeded(flight(), scenario())
    delta_v = np.zeros((60, 3, 3))
    delta_v[3, 0, 1] = 1.0005  # within 0.1 %
    delta_v[4, 0, 1] = math.nan
    assert not limits_exceeded(flight(delta_v=delta_v), scenario())


def test_a_lost_craft_keeps_its_distance_but_no_other_limit():
    flown = loss()
    assert np.linalg.norm(flown.delta_v, axis=-1).max() == 5.0
    assert not limits_exceeded(flown, scenario())
    assert np.isnan(communication_angles(flown)[20:, 1:]).all()
    assert np.isfinite(communication_angles(flown)[:, 0]).all()
    position = np.concatenate([flown.position, flown.final_position[None]])
    position[40, 2] = position[40, 0] + [10.0, 0.0, 0.0]
    near = flight(all_positions=position, healthy=flown.healthy)
    (found,) = limits_exceeded(near, scenario())
    assert (found.limit, found.value) == ("separation", pytest.approx(10.0))
    assert all_separations(near).shape == (61, 3)
