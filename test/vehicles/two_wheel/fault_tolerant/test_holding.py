"""Laws of two wheels that cannot rest at the target: they reach what can be held, within limits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from wheeled import AFRL_ACCELERATION, AFRL_INERTIA, AFRL_SPEED, AFRL_WHEEL, ORTHOGONAL, afrl

from spacecraft_gnc import lie
from spacecraft_gnc.vehicles.two_wheel.controllers.fault_tolerant.holding import (
    TwoWheels,
    brake,
    go_to_rest,
    keep_turning,
)
from spacecraft_gnc.vehicles.two_wheel.controllers.report import Rest
from spacecraft_gnc.vehicles.two_wheel.dynamics import Gyrostat
from spacecraft_gnc.vehicles.two_wheel.hold import holdable

TILTED = np.array([[900.0, 60.0, -90.0], [60.0, 1210.0, 40.0], [-90.0, 40.0, 1000.0]])
SKEW = np.array([[1.0, 0.2, 0.1], [0.0, 1.0, 0.3], [0.2, -0.1, 1.0]])
START = np.array([0.5, 0.3, -0.4])


def fly(gyrostat, healthy, state, n_steps):
    """Fly by the laws of ten seconds; return what was held, and for each step how far it is off."""
    believed = Gyrostat(
        gyrostat.inertia, gyrostat.wheel_axes, gyrostat.wheel_inertias, 10.0, AFRL_SPEED,
        AFRL_ACCELERATION,
    )  # fmt: skip
    wheels, errors, fastest, strongest = TwoWheels(believed, healthy), [], 0.0, 0.0
    for _ in range(n_steps):
        held = holdable(
            believed.inertia, believed.wheel_axes, believed.wheel_inertias, healthy,
            state.wheel_speed, state.total_momentum, np.eye(3),
        )  # fmt: skip
        law = keep_turning if held.rest is Rest.NOWHERE else go_to_rest
        u = law(wheels, state, held, state.wheel_speed)
        assert not u[~healthy].any()
        state = gyrostat.step(state, u, 10)
        fastest = max(fastest, float(np.abs(state.wheel_speed).max()))
        strongest = max(strongest, float(np.abs(u).max()))
        errors.append((_off(state, held), np.linalg.norm(state.angular_velocity - held.rate)))
    assert fastest <= AFRL_SPEED * (1.0 + 1e-15)
    assert strongest <= AFRL_ACCELERATION * (1.0 + 1e-15)
    return held, np.array(errors)


def _off(state, held):
    if held.rest is not Rest.NOWHERE:
        return lie.angle_between(state.attitude, held.attitude)
    axis = held.rate / np.linalg.norm(held.rate)
    return float(lie.vector_angle(state.attitude @ axis, held.attitude @ axis))


def without(i):
    return np.arange(3) != i


@pytest.mark.parametrize("dead", [0, 1, 2])
@pytest.mark.parametrize("start", [START, np.array([2.5, 0.3, -0.4])], ids=["near", "far"])
def test_a_wheel_that_spins_on_leaves_a_steady_rotation_about_an_axis_that_points(dead, start):
    gyrostat, speed = afrl(ORTHOGONAL), 40.0 * np.eye(3)[dead]
    state = gyrostat.state_from_momentum(lie.exp(start), np.zeros(3), speed)
    held, errors = fly(gyrostat, without(dead), state, 100)
    assert held.rest is Rest.NOWHERE
    assert np.linalg.norm(held.rate) == pytest.approx(
        AFRL_WHEEL * 40.0 / AFRL_INERTIA[dead, dead], rel=1e-12
    )
    assert (errors[90:] < 1e-4).all()


@pytest.mark.parametrize("axes", [ORTHOGONAL, SKEW], ids=["orthogonal", "skew"])
@pytest.mark.parametrize("momentum", [[0.5, 0.2, -0.3], [-0.4, 0.9, 0.1]])
@pytest.mark.parametrize("speed", [40.0, -40.0])
def test_momentum_too_small_for_rest_leaves_a_steady_rotation_about_it(axes, momentum, speed):
    gyrostat = Gyrostat(TILTED, axes, np.full(3, AFRL_WHEEL), 1.0, AFRL_SPEED, AFRL_ACCELERATION)
    state = gyrostat.state_from_momentum(lie.exp(START), momentum, [0.0, 0.0, speed])
    held, errors = fly(gyrostat, without(2), state, 250)
    assert held.rest is Rest.NOWHERE
    assert (errors[200:] < 1e-9).all()


@pytest.mark.parametrize("dead", [0, 1, 2])
def test_with_momentum_it_comes_to_rest_where_it_can(dead):
    gyrostat = afrl(ORTHOGONAL)
    state = gyrostat.state_from_momentum(lie.exp(START), [1.0, -0.6, 0.8], np.zeros(3))
    held, errors = fly(gyrostat, without(dead), state, 300)
    assert held.rest is Rest.ELSEWHERE
    assert held.pointing_loss > 0.1
    assert errors[-1, 0] < 1e-2
    assert errors[-1, 1] < 1e-4


def test_where_the_normal_is_along_the_momentum_the_wheels_are_brought_to_rest():
    """There the linear system cannot be stabilized: H tilts only to second order."""
    gyrostat = afrl(ORTHOGONAL)
    state = gyrostat.state_from_momentum(np.eye(3), [0.0, 0.0, 0.43], [20.0, -10.0, 10.0])
    held, errors = fly(gyrostat, without(2), state, 20)
    assert held.rest is Rest.AT_TARGET
    assert errors[-1, 1] < 1e-3


def test_one_wheel_takes_in_what_it_can():
    gyrostat = afrl(ORTHOGONAL, 10.0)
    start = gyrostat.state_from_momentum(lie.exp(START), np.zeros(3), [30.0, 20.0, 10.0])
    healthy = np.array([False, True, False])
    state = start
    for _ in range(5):
        u, held = brake(gyrostat, healthy, state, np.eye(3))
        assert not u[~healthy].any()
        assert np.abs(u).max() <= AFRL_ACCELERATION
        state = gyrostat.step(state, u)
    assert held.rest is Rest.NOWHERE
    remains = -AFRL_WHEEL * np.array([30.0 / 430.0, 0.0, 10.0 / 1300.0])
    assert state.angular_velocity == pytest.approx(remains, abs=1e-15)
    assert held.rate == pytest.approx(remains, abs=1e-15)
    assert held.pointing_loss == pytest.approx(
        lie.angle_between(state.attitude, np.eye(3)), abs=0.1
    )


def test_with_no_wheel_at_all_it_says_what_remains():
    gyrostat = afrl(ORTHOGONAL, 10.0)
    still = gyrostat.state_from_rate(lie.exp(START), np.zeros(3), np.zeros(3))
    u, held = brake(gyrostat, np.zeros(3, dtype=bool), still, np.eye(3))
    assert not u.any()
    assert held.rest is Rest.ELSEWHERE
    assert held.pointing_loss == pytest.approx(float(np.linalg.norm(START)), rel=1e-12)
    assert math.isfinite(held.pointing_loss)
