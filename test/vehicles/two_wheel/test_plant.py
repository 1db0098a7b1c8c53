"""The plant: periods, resets, failed wheels, invariants."""

from __future__ import annotations

import math

import numpy as np
import pytest
from wheeled import PYRAMID, momentum, small

from spacecraft_gnc import lie
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.vehicles.two_wheel.plant import GyrostatPlant

GYROSTAT = small(PYRAMID, 0.05, max_acceleration=40.0)
START = GYROSTAT.state_from_rate(
    lie.exp(np.array([0.3, 0.2, 0.1])), [0.1, -0.2, 0.3], [10.0, -20.0, 30.0, 5.0]
)
COMMAND = np.array([3.0, -2.0, 1.0, 50.0])


def plant(**changes):
    return GyrostatPlant(**({"gyrostat": GYROSTAT, "initial": START, "n_steps": 5} | changes))


def test_a_step_holds_the_command_for_one_period():
    flown = plant(substeps=4)
    assert flown.period == pytest.approx(0.2)
    state = flown.step(COMMAND)
    assert state is flown.state
    assert state.step == 1
    rise = 0.2 * np.minimum(COMMAND, 40.0)
    assert state.wheel_speed == pytest.approx(START.wheel_speed + rise, abs=1e-13)
    expected = GYROSTAT.step(START, COMMAND, 4)
    assert np.array_equal(state.attitude, expected.attitude)
    assert np.array_equal(flown.angular_velocity(), expected.angular_velocity)


def test_a_failed_wheel_holds_its_speed_and_the_others_turn_the_bus():
    flown = plant(substeps=4, lost_at=[math.inf, 0.6, math.inf, math.inf])
    speeds, healthy = [], []
    for _ in range(5):
        healthy.append(flown.healthy)
        speeds.append(flown.step(COMMAND).wheel_speed)
    assert [row.tolist() for row in healthy] == 3 * [[True] * 4] + 2 * [[True, False, True, True]]
    rises = np.diff([START.wheel_speed, *speeds], axis=0) / 0.2
    assert rises[:3] == pytest.approx(np.tile([3.0, -2.0, 1.0, 40.0], (3, 1)), abs=1e-11)
    assert rises[3:] == pytest.approx(np.tile([3.0, 0.0, 1.0, 40.0], (2, 1)), abs=1e-11)
    total = flown.invariants().inertial_momentum
    assert np.array_equal(total, START.total_momentum)
    parts = (part[None] for part in flown.state[1:4])
    assert np.abs(momentum(GYROSTAT, *parts)[0] - total).max() < 1e-15


@pytest.mark.parametrize(
    ("loss", "rises"),
    [
        ({"lost_friction": 0.11}, [2.0, 2.0]),  # 10 rad/s^2 against -20 rad/s
        ({"lost_share": 0.25}, [-0.1, -0.1]),
        ({"lost_share": 1.0}, [-0.4, -0.4]),
        ({}, [0.0, 0.0]),
    ],
    ids=["friction", "partial", "all of it", "spinning"],
)
def test_kinds_of_loss(loss, rises):
    flown = plant(substeps=4, lost_at=[math.inf, 0.2, math.inf, math.inf], **loss)
    speeds = [START.wheel_speed, *(flown.step(COMMAND).wheel_speed for _ in range(3))]
    assert np.diff(speeds, axis=0)[:, 1] == pytest.approx([-0.4, *rises], abs=1e-12)
    others = np.delete(np.diff(speeds, axis=0), 1, axis=1)
    assert others == pytest.approx(np.tile([0.6, 0.2, 8.0], (3, 1)), abs=1e-12)
    assert flown.healthy.tolist() == [True, False, True, True]
    assert np.array_equal(flown.state.applied, COMMAND)
    parts = (part[None] for part in flown.state[1:4])
    off = momentum(GYROSTAT, *parts)[0] - START.total_momentum
    assert np.abs(off).max() < 1e-15


def test_a_lost_wheel_comes_to_rest_and_stays():
    flown = plant(substeps=4, n_steps=40, lost_at=[0.0, 0.0, 0.4, 0.2], lost_friction=0.11)
    for _ in range(40):
        state = flown.step(COMMAND)
    assert np.array_equal(state.wheel_speed, np.zeros(4))
    expected = np.linalg.solve(GYROSTAT.inertia, state.attitude.T @ START.total_momentum)
    assert state.angular_velocity == pytest.approx(expected, abs=1e-14)


def test_a_wheel_is_lost_at_the_step_that_starts_then_whatever_the_last_bit():
    flown = plant(substeps=43, lost_at=[15.05, math.inf, math.inf, math.inf])
    assert 15.05 / flown.period > 7.0
    for _ in range(7):
        assert flown.healthy.all()
        flown.step(np.zeros(4))
    assert not flown.healthy[0]


def test_a_reset_flies_the_same_again():
    flown = plant(lost_at=[0.1, math.inf, math.inf, math.inf])
    flown.warm_up()
    first = [flown.step(COMMAND) for _ in range(5)]
    flown.reset()
    assert flown.state.step == 0
    assert flown.healthy.all()
    for before in first:
        for one, other in zip(flown.step(COMMAND), before, strict=True):
            assert np.array_equal(one, other)


def test_invariants():
    flown = plant()
    energy, total, defect = flown.invariants()
    assert energy == GYROSTAT.kinetic_energy(START)
    assert np.array_equal(total, START.total_momentum)
    assert defect < 1e-15


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"gyrostat": None}, "gyrostat: received None"),
        ({"initial": None}, "initial: received None"),
        ({"initial": START._replace(wheel_speed=np.zeros(3))}, r"initial.wheel_speed: .*\(4,\)"),
        ({"n_steps": 0}, "n_steps: received 0; .* lengthen the duration"),
        ({"substeps": 1.5}, "substeps: received 1.5"),
        ({"lost_at": [1.0, 2.0]}, r"lost_at: received an array of shape \(2,\)"),
        ({"lost_at": [1.0, -2.0, 1.0, 1.0]}, "lost_at: .* required times >= 0"),
        ({"lost_at": [1.0, math.nan, 1.0, 1.0]}, "lost_at: .* required times >= 0"),
        ({"lost_at": "soon"}, "lost_at: received 'soon'"),
        ({"lost_share": 1.5}, "lost_share: received 1.5; required a share of 0 to 1"),
        ({"lost_friction": -1.0}, "lost_friction: received -1.0"),
    ],
)
def test_what_is_no_plant_is_refused(changes, words):
    with pytest.raises(GncError, match=words) as caught:
        plant(**changes)
    assert "\n" not in str(caught.value)


def test_commands_that_are_none_never_reach_the_wheels():
    flown = plant(lost_at=[0.0, math.inf, math.inf, math.inf])
    bad = np.array([0.0, math.nan, 0.0, 0.0])
    for command in (np.zeros(3), bad, bad[[1, 0, 2, 3]], np.full(4, math.inf), "abc"):
        with pytest.raises(GncError, match="acceleration: received"):
            flown.step(command)
    assert flown.state.step == 0
