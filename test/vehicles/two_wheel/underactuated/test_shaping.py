"""Paths of turns that two wheels can make: to every attitude, by turns about axes of one plane."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spacecraft_gnc import lie
from spacecraft_gnc.vehicles.two_wheel.controllers.underactuated.shaping import (
    _products,
    path_between,
    turn_time,
)
from spacecraft_gnc.vehicles.two_wheel.ocp.problem import WheelOcp

REPORT = WheelOcp(
    np.diag([430.0, 1210.0, 1300.0]), 0.043 * np.eye(3)[:, :2], 10.0,
    max_speed=100.0, max_acceleration=5.0,
)  # fmt: skip
OBLIQUE = WheelOcp(
    np.array([[900.0, 60.0, -30.0], [60.0, 1210.0, 80.0], [-30.0, 80.0, 1300.0]]),
    np.array([[0.04, 0.02], [0.0, 0.035], [0.01, -0.02]]), 10.0, max_speed=90.0,
    max_acceleration=4.0,
)  # fmt: skip
angles = st.floats(-np.pi, np.pi)
rotations = st.builds(lambda *parts: lie.exp(np.array(parts)), angles, angles, angles)
SPECIAL = [
    np.eye(3),
    *(lie.exp(angle * axis) for angle in (1e-9, 1e-4, np.pi / 2, np.pi - 1e-9, np.pi)
      for axis in (*np.eye(3), np.array([0.6, 0.8, 0.0]), np.ones(3) / np.sqrt(3.0))),
]  # fmt: skip


def _product(turns):
    attitude = np.eye(3)
    for turn in turns:
        attitude = attitude @ lie.exp(turn)
    return attitude


@settings(max_examples=300, deadline=None)
@given(rotations)
def test_every_rotation_is_each_of_the_products(relative):
    for turns in _products(relative):
        assert len(turns) <= 3
        assert np.abs(turns[:, 2]).max() < 1e-7
        assert np.linalg.norm(turns, axis=1).max() <= np.pi + 1e-9
        np.testing.assert_allclose(_product(turns), relative, atol=1e-7)


@pytest.mark.parametrize("relative", SPECIAL)
def test_special_rotations_are_each_of_the_products(relative):
    for turns in _products(relative):
        np.testing.assert_allclose(_product(turns), relative, atol=1e-7)


@pytest.mark.parametrize("ocp", [REPORT, OBLIQUE], ids=["report", "oblique"])
@settings(max_examples=100, deadline=None)
@given(rotations, rotations)
def test_a_path_leads_to_its_end_by_turns_that_the_wheels_can_make(ocp, start, end):
    path = path_between(ocp, start, end)
    assert path.turns.shape[0] <= 3
    np.testing.assert_allclose(start @ _product(path.turns), end, atol=1e-7)
    # omega = -J^-1 (wheels nu): an axis is one of theirs where J times it lies in their plane
    normal = np.cross(*ocp.wheels.T)
    out_of_plane = path.turns @ ocp.inertia @ normal / np.linalg.norm(normal)
    np.testing.assert_allclose(out_of_plane, 0.0, atol=1e-5)


@settings(max_examples=100, deadline=None)
@given(rotations, st.floats(0.0, 1.2), st.floats(0.0, 1.2))
def test_the_rest_of_a_path_is_on_it(end, first, second):
    path = path_between(REPORT, np.eye(3), end)
    rest = path.after(first * path.time)
    np.testing.assert_allclose(rest.start @ _product(rest.turns), end, atol=1e-7)
    assert rest.time == pytest.approx(max(1.0 - first, 0.0) * path.time, abs=1e-9 * path.time)
    np.testing.assert_allclose(
        rest.after(second * path.time).start, path.after((first + second) * path.time).start,
        atol=1e-7,
    )  # fmt: skip


def test_a_turn_in_the_plane_is_one_turn():
    turn = np.array([0.4, -0.7, 0.0])
    path = path_between(REPORT, np.eye(3), lie.exp(turn))
    assert len(path.turns) == 1
    np.testing.assert_allclose(path.turns.sum(axis=0), turn, atol=1e-9)


def test_the_time_of_a_turn_is_that_of_the_wheel_at_its_limits():
    most, top, gain = 5.0, 100.0, 0.043 / 430.0
    # 20 s up, 30 s at the top, 20 s down
    assert turn_time(REPORT, np.array([gain * 50.0 * top, 0.0, 0.0])) == pytest.approx(70.0)
    assert turn_time(REPORT, np.array([gain * most * 25.0, 0.0, 0.0])) == pytest.approx(10.0)


def test_without_limits_a_wheel_turns_the_bus_by_three_tenths_of_a_radian_a_step():
    free, fast = (replace(REPORT, max_speed=v, max_acceleration=u) for v, u in ((0, 0), (1e6, 1e9)))
    turn = np.array([2.0, 0.0, 0.0])
    assert turn_time(free, turn) == pytest.approx(2.0 / 0.3 * 10.0)
    assert turn_time(fast, turn) == pytest.approx(2.0 / 0.3 * 10.0, rel=1e-5)
    assert replace(REPORT, max_speed=0.0).max_speed == pytest.approx(0.03 * 430.0 / 0.043)
    assert REPORT.max_speed == 100.0
