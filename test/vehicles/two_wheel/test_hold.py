"""What can be held: rest and rotation from the equation of momentum, and that nothing is better."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize
from strategies import inertias, rotations, unit_vectors, vectors
from wheeled import AFRL_INERTIA, AFRL_WHEEL, ORTHOGONAL, PYRAMID

from spacecraft_gnc import lie
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.vehicles.two_wheel.controllers.report import Rest
from spacecraft_gnc.vehicles.two_wheel.hold import Held, holdable, on_cone, plane_normal
from spacecraft_gnc.vehicles.two_wheel.wheels import span_of

TARGET = lie.exp(np.array([0.4, -0.8, 1.2]))
TWO_OF_THREE = np.array([True, True, False])


def held(inertia, momentum, speed=(0.0, 0.0, 0.0), axes=ORTHOGONAL, healthy=TWO_OF_THREE):
    """What can be held with wheels of 0.02 kg m^2."""
    axial = np.full(axes.shape[1], 0.02)
    return holdable(inertia, axes, axial, healthy, np.array(speed), np.array(momentum), TARGET)


def unbalanced(inertia, momentum, speed, found: Held):
    """Momentum that the two wheels left would have to take, along the normal of their axes."""
    total = found.attitude.T @ momentum - inertia @ found.rate - [0.0, 0.0, 0.02 * speed[2]]
    return total[2]


def brute_rate(inertia, momentum, kappa):
    """Least size of a steady rotation about the momentum, over all body axes."""

    def rate(angles):
        a, b = angles
        axis = np.array([math.sin(a) * math.cos(b), math.sin(a) * math.sin(b), math.cos(a)])
        return abs((momentum * axis[2] - kappa) / (inertia[2] @ axis))

    starts = [(a, b) for a in (0.3, 1.2, 2.0, 2.9) for b in (0.0, 1.6, 3.1, 4.7)]
    return min(minimize(rate, s, method="Nelder-Mead", options={"xatol": 1e-9}).fun for s in starts)


def test_four_wheels_less_one_rest_anywhere():
    axes = PYRAMID / np.linalg.norm(PYRAMID, axis=0)
    found = held(np.eye(3), [1.0, 2.0, 3.0], (5.0,) * 4, axes, np.array([1, 1, 0, 1], dtype=bool))
    assert found.rest is Rest.AT_TARGET
    assert found.attitude is TARGET
    assert found.pointing_loss == 0.0
    assert not found.rate.any()


@given(inertias(), st.floats(-50.0, 50.0))
def test_without_momentum_two_wheels_rest_at_the_target_or_nowhere(inertia, speed):
    found = held(inertia, np.zeros(3), (7.0, -3.0, speed))
    still = abs(speed * 0.02) <= 1e-9 * np.linalg.norm(inertia[2])
    assert found.rest is (Rest.AT_TARGET if still else Rest.NOWHERE)
    assert np.array_equal(found.attitude, TARGET)
    if not still:
        assert abs(unbalanced(inertia, np.zeros(3), (0, 0, speed), found)) < 1e-12
        # n . J omega = -kappa, so that no motion is slower: Cauchy and Schwarz.
        least = abs(0.02 * speed) / np.linalg.norm(inertia[2])
        assert np.linalg.norm(found.rate) == pytest.approx(least, rel=1e-12)


@given(inertias(), vectors(2.0), st.floats(-150.0, 150.0))
@settings(max_examples=200)
def test_the_wheels_left_can_hold_what_is_said(inertia, momentum, speed):
    found = held(inertia, momentum, (7.0, -3.0, speed))
    assert lie.is_rotation(found.attitude, 1e-12)
    assert abs(unbalanced(inertia, momentum, (0, 0, speed), found)) < 2e-8
    size = np.linalg.norm(momentum)
    if size < 1e-8:
        return
    assert (found.rest is Rest.NOWHERE) == (abs(0.02 * speed) > size)
    if found.rest is Rest.NOWHERE:  # it stays a steady rotation: about the momentum
        rate = found.attitude @ found.rate
        assert np.linalg.norm(np.cross(rate, momentum)) < 1e-12 * max(1.0, np.linalg.norm(rate))
        assert lie.angle_between(found.attitude, TARGET) == pytest.approx(
            found.pointing_loss, abs=1e-7
        )
    else:
        assert not found.rate.any()
        assert lie.angle_between(found.attitude, TARGET) == pytest.approx(
            found.pointing_loss, abs=1e-7
        )


@pytest.mark.parametrize("speed", [60.0, -60.0, 140.0])
@pytest.mark.parametrize("size", [1e-3, 0.3, 1.1])
def test_no_steady_rotation_is_slower(speed, size):
    inertia = np.array([[1.0, 0.05, -0.3], [0.05, 0.8, 0.2], [-0.3, 0.2, 0.9]])
    found = held(inertia, size * np.array([0.6, 0.0, 0.8]), (0.0, 0.0, speed))
    assert found.rest is Rest.NOWHERE
    least = brute_rate(inertia, size, 0.02 * speed)
    assert np.linalg.norm(found.rate) == pytest.approx(least, rel=1e-6)


def test_on_principal_axes_the_slowest_rotation_is_about_the_normal():
    found = held(np.diag([1.0, 2.0, 3.0]), [0.1, 0.0, 0.0], (0.0, 0.0, 10.0))
    assert found.rate == pytest.approx([0.0, 0.0, -(0.2 - 0.1) / 3.0], abs=1e-15)


@given(rotations(), unit_vectors(), unit_vectors(), st.floats(-1.0, 1.0), st.integers(0, 2**32 - 1))
def test_no_attitude_of_the_cone_is_nearer(attitude, n, direction, cosine, seed):
    nearest, angle = on_cone(attitude, n, direction, cosine)
    assert (nearest @ n) @ direction == pytest.approx(cosine, abs=1e-7)
    assert lie.angle_between(nearest, attitude) == pytest.approx(angle, abs=1e-7)
    rng = np.random.default_rng(seed)
    for _ in range(20):  # others of the cone: turned about the momentum, and about the normal
        about, own = rng.uniform(-math.pi, math.pi, 2)
        other = lie.exp(about * direction) @ nearest @ lie.exp(own * n)
        assert lie.angle_between(other, attitude) > angle - 1e-7


def test_the_reports_spacecraft_turns_on_with_a_wheel_that_keeps_its_speed():
    axial = np.full(3, AFRL_WHEEL)
    found = holdable(
        AFRL_INERTIA, ORTHOGONAL, axial, TWO_OF_THREE, np.array([0.0, 0.0, 40.0]), np.zeros(3),
        TARGET,
    )  # fmt: skip
    assert found.rest is Rest.NOWHERE
    assert found.rate == pytest.approx([0.0, 0.0, -0.043 * 40.0 / 1300.0], rel=1e-15)
    assert found.pointing_loss == 0.0


def test_a_wheel_that_the_others_can_cancel_does_no_harm():
    """Its axis lies in their plane: it may spin on."""
    axes = np.array([[1.0, 0.0, math.sqrt(0.5)], [0.0, 1.0, math.sqrt(0.5)], [0.0, 0.0, 0.0]])
    found = held(np.eye(3), np.zeros(3), (0.0, 0.0, 40.0), axes)
    assert found.rest is Rest.AT_TARGET


@pytest.mark.parametrize("healthy", [[False, True, False], [False] * 3])
def test_with_fewer_than_two_axes_nothing_is_held(healthy):
    with pytest.raises(ParameterError, match=r"span \d dimension.*; required 2 or more") as caught:
        held(np.eye(3), np.zeros(3), healthy=np.array(healthy))
    assert "\n" not in str(caught.value)


@given(st.integers(0, 2**32 - 1))
def test_the_normal_of_a_plane(seed):
    axes = np.random.default_rng(seed).normal(size=(3, 2))
    axes /= np.linalg.norm(axes, axis=0)
    n = plane_normal(axes)
    assert np.abs(n @ axes).max() < 1e-14
    assert np.linalg.norm(n) == pytest.approx(1.0, abs=1e-14)
    assert span_of(axes) == 2
    assert span_of(axes[:, :1]) == 1
    assert span_of(axes[:, :0]) == 0
