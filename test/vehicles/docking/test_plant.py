"""Docking plant: limits, lost thrusters, margins, noise of navigation, messages."""

from __future__ import annotations

import math

import numpy as np
import pytest
from docking_pair import T, pair, rotation

from spacecraft_gnc import lie
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.vehicles.docking.navigation import NavigationNoise
from spacecraft_gnc.vehicles.docking.plant import DockingPlant
from spacecraft_gnc.vehicles.docking.signals import POSE, STATE
from spacecraft_gnc.vehicles.docking.state import DIRECTIONS, Navigation

START = Navigation(
    np.array([5.0, 0.4, -0.3]),
    np.array([-0.1, 0.05, 0.02]),
    rotation([0.3, -0.2, 0.25]),
    np.array([0.02, -0.01, 0.015]),
)
COMMAND = np.array([0.4, -0.3, 0.2, 0.01, 0.02, -0.01])


def plant(**changes):
    given = {
        "motion": pair(),
        "initial": START,
        "n_steps": 5,
        "max_force": 1.0,
        "max_moment": 0.05,
    }
    return DockingPlant(**(given | changes))


def same(first, second):
    return all(np.array_equal(a, b) for a, b in zip(first[1:5], second[1:5], strict=True))


def test_a_step_holds_the_wrench_for_one_period():
    flown = plant()
    state = flown.step(COMMAND)
    assert state is flown.state
    assert state.step == 1
    expected = flown.motion.advance(0.0, *START, COMMAND[:3], COMMAND[3:])
    assert all(np.array_equal(a, b) for a, b in zip(state[1:5], expected[:4], strict=True))
    assert np.array_equal(state.applied, COMMAND)
    second = flown.step(np.zeros(6))
    later = flown.motion.advance(T, *state[1:5], np.zeros(3), np.zeros(3))
    assert np.array_equal(second.port_offset, later.port_offset)
    flown.reset()
    assert flown.state.step == 0
    assert same(flown.step(COMMAND), state)


def test_each_component_is_limited_in_the_chief_frame_and_what_was_asked_for_is_kept():
    asked = np.array([2.0, -3.0, 0.2, 0.01, 0.2, -0.01])
    given = np.array([1.0, -1.0, 0.2, 0.01, 0.05, -0.01])
    limited = plant().step(asked)
    assert same(limited, plant(saturates=False).step(given))
    assert not same(limited, plant(saturates=False).step(asked))
    assert np.array_equal(limited.applied, asked)


@pytest.mark.parametrize("lost", DIRECTIONS)
def test_a_lost_direction_of_the_deputy_gives_no_force_from_its_step_on(lost):
    axis = "xyz".index(lost[1])
    sign = 1.0 if lost[0] == "+" else -1.0
    start = START._replace(attitude=rotation([0.0, 0.0, 0.5 * math.pi]), angular_velocity=[0, 0, 0])
    flown = plant(initial=start, lost=lost, lost_at=T + 0.1)  # in the second step: the third
    direction = start.attitude @ (sign * np.eye(3)[axis])  # chief frame
    wrench = np.concatenate([0.5 * direction, np.zeros(3)])
    for k in range(4):
        before = flown.state
        assert before.thrusters.tolist() == [name != lost or k < 2 for name in DIRECTIONS]
        after = flown.step(wrench)
        free = flown.motion.advance(T * k, *before[1:5], np.zeros(3), np.zeros(3))
        push = direction @ (after.port_velocity - free.port_velocity)
        expected = 0.5 * T / flown.motion.mass
        assert push == pytest.approx(expected if k < 2 else 0.0, abs=0.01 * expected)


def test_margins_are_the_least_of_all_substeps_of_the_step_that_ended():
    fine = pair(substeps=1, period=T / 20)
    flown = plant()
    at_start = flown.motion.margins(START.port_offset, START.attitude)
    assert (flown.state.line_of_sight_margin, flown.state.clearance) == at_start
    start = START._replace(port_velocity=np.array([-0.01, 0.01, 0.0]))  # turns back in the step
    flown = plant(motion=pair(substeps=20), initial=start)
    swerve = np.array([0.9, -0.9, 0.0, 0.0, 0.0, 0.05])
    state, sight, clear = start, [], []
    for i in range(20):
        end = fine.advance(T / 20 * i, *state, swerve[:3], swerve[3:])
        state = Navigation(*end[:4])
        sight.append(end.line_of_sight_margin)
        clear.append(end.clearance)
    told = flown.step(swerve)
    assert told.line_of_sight_margin == pytest.approx(min(sight), abs=1e-9)
    assert told.clearance == pytest.approx(min(clear), abs=1e-9)
    assert min(sight) < min(sight[0], sight[-1])


NOISE = NavigationNoise(position=0.01, velocity=0.002, attitude=0.003, rate=4e-4, seed=7)


def test_without_noise_the_truth_itself_is_measured():
    state = plant().step(COMMAND)
    assert all(a is b for a, b in zip(state.measured, state[1:5], strict=True))
    only = plant(noise=NavigationNoise(velocity=0.1)).state
    assert only.measured.port_offset is only.port_offset
    assert only.measured.port_velocity is not only.port_velocity


def test_noise_has_its_deviation_and_leaves_the_motion_alone():
    noisy, quiet = plant(noise=NOISE, n_steps=400), plant(n_steps=400)
    errors = []
    for _ in range(400):
        a, b = noisy.step(np.zeros(6)), quiet.step(np.zeros(6))
        assert same(a, b)
        m = a.measured
        assert m.attitude @ m.attitude.T == pytest.approx(np.eye(3), abs=1e-12)
        errors.append(
            [
                *(m.port_offset - a.port_offset),
                *(m.port_velocity - a.port_velocity),
                *lie.log(m.attitude @ a.attitude.T),
                *(m.angular_velocity - a.angular_velocity),
            ]
        )
    scaled = np.array(errors) / np.repeat([0.01, 0.002, 0.003, 4e-4], 3)
    assert scaled.std(axis=0) == pytest.approx(np.ones(12), abs=0.15)  # 4 deviations of it
    apart = np.corrcoef(scaled.T) - np.eye(12)
    assert np.abs(apart).max() < 0.25


def test_noise_depends_on_seed_run_and_step_alone():
    def measured(step, **changes):
        given = {"position": 0.01, "attitude": 0.003, "seed": 7} | changes
        return NavigationNoise(**given).measure(step, START)

    first = measured(3)
    assert np.array_equal(first.port_offset, measured(3).port_offset)
    assert np.array_equal(first.port_offset, measured(3, velocity=1.0, rate=1.0).port_offset)
    doubled = measured(3, position=0.02).port_offset - START.port_offset
    assert doubled == pytest.approx(2.0 * (first.port_offset - START.port_offset), rel=1e-9)
    for other in (measured(4), measured(3, seed=8), measured(3, run=1)):
        assert not np.array_equal(first.port_offset, other.port_offset)
        assert not np.array_equal(first.attitude, other.attitude)


def test_outputs_are_the_motion_and_poses_now_and_then():
    flown = plant(pose_every=2)
    applied = (np.zeros(6), Source.ZERO)
    (signal, motion), (pose_signal, pose) = flown.outputs(applied)
    assert signal is STATE
    assert pose_signal is POSE
    assert motion.state is flown.state
    assert motion.applied == applied
    deputy, chief = flown.motion.deputy, flown.motion.chief_body
    center = chief.port + START.port_offset - START.attitude @ deputy.port
    assert pose[0][:3] == pytest.approx(center)
    assert lie.from_quaternion_xyzw(np.array(pose[0][3:])) == pytest.approx(START.attitude)
    flown.step(COMMAND)
    [(_, motion)] = flown.outputs((COMMAND, Source.METHOD))
    assert motion.chief_attitude == pytest.approx(flown.motion.chief.attitude(T))
    assert len(plant(pose_every=0).outputs(applied)) == 1


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"lost": "x"}, "lost: received 'x'"),
        ({"lost": "+x", "lost_at": -1.0}, "lost_at: received -1"),
        ({"n_steps": 0}, "n_steps: received 0"),
        ({"max_force": -1.0}, "max_force: received -1"),
        ({"initial": START._replace(attitude=np.zeros((3, 3)))}, "initial.attitude"),
        ({"initial": START._replace(port_offset=[math.nan, 0.0, 0.0])}, "initial.port_offset"),
    ],
)
def test_impossible_arguments_are_refused(changes, message):
    with pytest.raises(GncError, match=message):
        plant(**changes)


@pytest.mark.parametrize("wrench", [np.zeros(3), np.full(6, math.nan)])
def test_a_wrench_that_is_not_six_numbers_is_refused(wrench):
    with pytest.raises(GncError, match="wrench: received"):
        plant().step(wrench)


def test_noise_is_not_negative():
    with pytest.raises(GncError, match="attitude_noise: received -1"):
        NavigationNoise(attitude=-1.0)
