"""Steps, limits and refusals of the gyrostat."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import inertias, vectors
from wheeled import (
    ATTITUDE,
    FULL_INERTIA,
    ORTHOGONAL,
    PYRAMID,
    RATE,
    SPEEDS,
    momentum,
    small,
    start,
)

from spacecraft_gnc import lie
from spacecraft_gnc.errors import GncError, ParameterError, ShapeError
from spacecraft_gnc.vehicles.two_wheel import _gyrostat_kernels as kernels
from spacecraft_gnc.vehicles.two_wheel.dynamics import Gyrostat


def test_simulate_is_step_after_step():
    gyrostat = small(PYRAMID, 0.05)
    commands = np.random.default_rng(3).normal(size=(30, 4))
    motion = gyrostat.simulate(start(gyrostat), commands)
    state = start(gyrostat)
    for k, command in enumerate(commands):
        state = gyrostat.step(state, command)
        for part, expected in zip(state[1:4], motion, strict=True):
            assert np.array_equal(part, expected[k + 1])
    assert state.step == 30
    assert not any(part.flags.writeable for part in state[1:6])


def test_substeps_hold_the_command():
    gyrostat, command = small(PYRAMID, 0.05), np.array([1.0, 2.0, -3.0, 4.0])
    once, state = gyrostat.step(start(gyrostat), command, 7), start(gyrostat)
    for _ in range(7):
        state = gyrostat.step(state, command)
    assert once.step == 1
    for one, other in zip(once[1:5], state[1:5], strict=True):
        assert np.abs(one - other).max() < 1e-13


@given(st.lists(st.floats(-1e6, 1e6), min_size=4, max_size=4), st.integers(1, 30))
def test_limits_hold_and_momentum_is_conserved_at_them(command, substeps):
    gyrostat = small(PYRAMID, 0.05, max_speed=105.0, max_acceleration=30.0)
    state = start(gyrostat)
    after = gyrostat.step(state, np.array(command), substeps)
    rise = np.clip(command, -30.0, 30.0) * 0.05 * substeps
    assert np.abs(after.wheel_speed - np.clip(SPEEDS + rise, -105.0, 105.0)).max() < 1e-12
    assert np.abs(after.wheel_speed).max() <= 105.0
    total = momentum(gyrostat, *(part[None] for part in after[1:4]))[0]
    assert np.abs(total - state.total_momentum).max() < 1e-14


def test_a_wheel_beyond_its_limit_may_only_slow_down():
    fast = small(ORTHOGONAL, 0.1).state_from_rate(ATTITUDE, RATE, [120.0, -120.0, 0.0])
    gyrostat = small(ORTHOGONAL, 0.1, max_speed=100.0)
    speeds = gyrostat.step(fast, np.array([10.0, 10.0, 10.0])).wheel_speed
    assert speeds == pytest.approx([120.0, -119.0, 1.0], abs=1e-12)
    with pytest.raises(ParameterError, match=r"wheel_speed: received .* at most 100 rad/s"):
        gyrostat.state_from_rate(ATTITUDE, RATE, [120.0, -120.0, 0.0])


@settings(max_examples=50)
@given(inertias(), vectors(3.0), vectors(1.0), st.floats(1e-3, 10.0))
def test_a_stage_solves_its_equation_or_says_that_it_does_not(J, Pi, g, h):
    body = small(ORTHOGONAL, 1.0).body.copy()
    body[:18] = np.concatenate([J.ravel(), np.linalg.inv(J).ravel()])
    q0, q, ok = kernels.midpoint_turn(body, h, tuple(Pi), tuple(g))
    turn = lie.from_quaternion_xyzw(np.array([*q, q0])) if ok else np.eye(3)
    mean = np.linalg.solve(J, 0.5 * (Pi + turn.T @ Pi) - g)
    f = np.array(q) / q0
    assert not ok or np.abs(2.0 * f - h * mean).max() < 1e-12
    # A step that is short for the rate is always taken.
    assert ok or h * np.linalg.norm(np.linalg.solve(J, Pi - g)) > 0.3


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"inertia": np.diag([2.0, 0.5, 0.5])}, "inertia: .*triangle"),
        ({"wheel_axes": np.zeros((3, 3))}, "wheel_axes: received a column 0 of zeros; required"),
        ({"wheel_axes": np.eye(3)[:2]}, r"wheel_axes: .* required \(3, m\)"),
        ({"wheel_axes": np.empty((3, 0))}, r"wheel_axes: .* required \(3, m\)"),
        ({"wheel_axes": np.full((3, 3), math.nan)}, "wheel_axes: .* finite"),
        ({"wheel_inertias": [0.01, 0.01]}, "wheel_inertias: .* required 3 numbers"),
        ({"wheel_inertias": [0.01, 0.0, 0.01]}, "wheel_inertias: .* required positive"),
        ({"wheel_inertias": [0.01, 0.9, 0.01]}, "wheel_inertias: .* leaves the bus"),
        ({"time_step": 0.0}, "time_step: received 0.0"),
        ({"max_speed": -1.0}, "max_speed: received -1.0"),
        ({"max_acceleration": math.inf}, "max_acceleration: received inf"),
    ],
)
def test_what_is_no_gyrostat_is_refused(changes, words):
    arguments = {
        "inertia": FULL_INERTIA, "wheel_axes": np.eye(3), "wheel_inertias": [0.01] * 3,
        "time_step": 0.1,
    }  # fmt: skip
    with pytest.raises(GncError, match=words) as caught:
        Gyrostat(**(arguments | changes))
    assert "\n" not in str(caught.value)


def test_states_and_commands_are_checked():
    gyrostat = small(ORTHOGONAL, 0.1)
    good = gyrostat.state_from_rate(ATTITUDE, RATE, np.zeros(3))
    with pytest.raises(ShapeError, match=r"acceleration: .* 3 numbers \[rad/s\^2\]"):
        gyrostat.step(good, np.zeros(4))
    with pytest.raises(ParameterError, match=r"acceleration: received .*finite"):
        gyrostat.step(good, np.array([0.0, math.nan, 0.0]))
    with pytest.raises(ParameterError, match="substeps"):
        gyrostat.step(good, np.zeros(3), 0)
    with pytest.raises(ShapeError, match=r"state.wheel_speed"):
        gyrostat.step(good._replace(wheel_speed=np.zeros(2)), np.zeros(3))
    with pytest.raises(ParameterError, match=r"accelerations: .*one row for each step"):
        gyrostat.simulate(good, np.zeros((2, 3)), 3)
    with pytest.raises(ParameterError, match="attitude"):
        gyrostat.state_from_rate(1.1 * np.eye(3), RATE, np.zeros(3))
    with pytest.raises(ParameterError, match="total_momentum"):
        gyrostat.state_from_momentum(np.eye(3), [0.0, math.inf, 0.0], np.zeros(3))
    for unknown in (np.full(3, math.nan), np.full(3, 1e3)):
        wild = good._replace(angular_velocity=unknown, total_momentum=unknown)
        with pytest.raises(ParameterError, match=r"quarter turn .* use a smaller time step"):
            gyrostat.step(wild, np.zeros(3))
        with pytest.raises(ParameterError, match="use a smaller time step"):
            gyrostat.simulate(wild, np.zeros(3), 2)
