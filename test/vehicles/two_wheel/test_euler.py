"""3-2-1 Euler angles: laws, the singularity, and the textbook's factors."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import rotations

from spacecraft_gnc import lie
from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.vehicles.two_wheel.euler import from_euler_321, to_euler_321

ANGLES = st.one_of(st.floats(-math.pi, math.pi), st.sampled_from([0.0, 1e-9, math.pi, -math.pi]))
STEEP = st.one_of(
    st.sampled_from([math.pi / 2, -math.pi / 2]),
    st.floats(0.0, 1e-3).map(lambda off: math.pi / 2 - off),
    st.floats(1e-18, 1e-3).map(lambda off: off - math.pi / 2),
)


@given(ANGLES, st.one_of(STEEP, st.floats(-math.pi / 2, math.pi / 2)), ANGLES)
def test_angles_are_turns_about_z_then_y_then_x(roll, pitch, yaw):
    x, y, z = np.eye(3)
    expected = lie.exp(yaw * z) @ lie.exp(pitch * y) @ lie.exp(roll * x)
    assert np.abs(from_euler_321(np.array([roll, pitch, yaw])) - expected).max() < 1e-15


@given(rotations())
def test_any_rotation_comes_back(attitude):
    angles = to_euler_321(attitude)
    assert np.abs(from_euler_321(angles) - attitude).max() < 3e-15
    assert np.abs(angles).max() <= math.pi
    assert abs(angles[1]) <= math.pi / 2


@given(ANGLES, STEEP, ANGLES)
def test_a_rotation_at_the_singularity_comes_back(roll, pitch, yaw):
    attitude = from_euler_321(np.array([roll, pitch, yaw]))
    angles = to_euler_321(attitude)
    assert np.abs(from_euler_321(angles) - attitude).max() < 3e-15
    # Next to it the cosine of pitch is known to rounding, so pitch to that too.
    assert angles[1] == pytest.approx(pitch, abs=1e-15)


@given(st.floats(-3.1, 3.1), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1))
def test_angles_come_back_away_from_the_singularity(roll, pitch, yaw):
    angles = to_euler_321(from_euler_321(np.array([roll, pitch, yaw])))
    assert np.abs(angles - [roll, pitch, yaw]).max() < 1e-15 / math.cos(pitch)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_at_the_singularity_roll_is_zero_and_yaw_takes_all(sign):
    exact = np.array([[0.0, 0.6 * -1.0, 0.8 * sign], [0.0, 0.8, 0.6 * sign], [-sign, 0.0, 0.0]])
    angles = to_euler_321(exact)
    assert angles == pytest.approx([0.0, sign * math.pi / 2, math.atan2(0.6, 0.8)], abs=1e-15)
    assert angles[0] == 0.0
    for zero in (0.0, -0.0):
        exact[2, 1:] = zero
        assert np.array_equal(to_euler_321(exact), angles)


def test_stacks_and_unknown_attitudes():
    stack = np.stack(
        [np.eye(3), from_euler_321(np.array([0.1, -0.2, 0.3])), np.full((3, 3), np.nan)]
    )
    angles = to_euler_321(stack)
    assert angles.shape == (3, 3)
    assert np.array_equal(angles[0], np.zeros(3))
    assert angles[1] == pytest.approx([0.1, -0.2, 0.3], abs=1e-15)
    assert np.isnan(angles[2]).all()


def test_small_angles_are_the_rotation_vector():
    vector = np.array([1e-5, -2e-5, 3e-5])
    assert np.abs(to_euler_321(lie.exp(vector)) - vector).max() < 1e-9


def test_what_are_no_angles_and_no_rotations_is_refused():
    with pytest.raises(ShapeError, match="angles: received"):
        from_euler_321(np.zeros(4))
    with pytest.raises(ParameterError, match="angles: received"):
        from_euler_321(np.array([0.0, math.nan, 0.0]))
    with pytest.raises(ShapeError, match="attitude: received"):
        to_euler_321(np.zeros(9))
