"""Laws of SO(3), with samples near 0 and near pi."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from scipy.linalg import expm
from scipy.spatial.transform import Rotation
from strategies import rotation_vectors, rotations, unit_vectors, vectors

from spacecraft_gnc import lie
from spacecraft_gnc.errors import ParameterError, ShapeError

ROUNDING = 1e-14  # a few units in the last place of numbers of size 1


@given(rotation_vectors())
def test_exp_is_a_rotation_and_the_matrix_exponential(v):
    rotation = lie.exp(v)
    assert np.abs(rotation.T @ rotation - np.eye(3)).max() < ROUNDING
    assert np.abs(rotation - expm(lie.hat(v))).max() < 2e-14


@given(rotations())
def test_exp_inverts_log(rotation):
    assert np.abs(lie.exp(lie.log(rotation)) - rotation).max() < 1e-13


@given(rotation_vectors())
def test_log_inverts_exp_up_to_the_sign_at_the_half_turn(v):
    back = lie.log(lie.exp(v))
    angle = np.linalg.norm(v)
    if angle > math.pi - 1e-7:  # v and v - 2 pi v/|v| are neighbors here
        assert (
            min(np.abs(back - v).max(), np.abs(back + v * (2 * math.pi / angle - 1)).max()) < 1e-7
        )
    else:
        assert np.abs(back - v).max() < 1e-8 * max(1.0, 1e-7 / (math.pi - angle))


@given(rotations())
def test_log_is_at_most_half_a_turn(rotation):
    assert np.linalg.norm(lie.log(rotation)) <= math.pi + ROUNDING


def test_log_of_an_exact_half_turn_has_a_positive_largest_component():
    assert lie.log(np.diag([-1.0, -1.0, 1.0])) == pytest.approx([0.0, 0.0, math.pi])


@given(vectors(), vectors())
def test_hat_is_the_cross_product_and_vee_its_inverse(a, b):
    assert np.abs(lie.hat(a) @ b - np.cross(a, b)).max() < ROUNDING
    assert np.array_equal(lie.vee(lie.hat(a)), a)


@given(rotations(), vectors())
def test_conjugation_turns_the_axis(rotation, a):
    turned = rotation @ lie.hat(a) @ rotation.T
    assert np.abs(turned - lie.hat(rotation @ a)).max() < ROUNDING


@given(rotations())
def test_quaternion_round_trip_agrees_with_scipy(rotation):
    q = lie.to_quaternion_xyzw(rotation)
    assert abs(np.linalg.norm(q) - 1.0) < ROUNDING
    assert q[3] >= 0.0
    assert np.abs(lie.from_quaternion_xyzw(q) - rotation).max() < ROUNDING
    other = Rotation.from_matrix(rotation).as_quat()
    assert min(np.abs(q - other).max(), np.abs(q + other).max()) < 1e-13


@given(rotations(), unit_vectors())
def test_angle_between_is_the_angle_turned(rotation, axis):
    for angle in (0.0, 1e-9, 0.3, math.pi - 1e-6):
        turned = rotation @ lie.exp(angle * axis)
        assert lie.angle_between(rotation, turned) == pytest.approx(angle, abs=1e-13)
        assert lie.angles_between(rotation[None], turned)[0] == pytest.approx(angle, abs=1e-13)


@given(rotations(), vectors(1e-3))
def test_orthonormalize_returns_the_nearest_rotation(rotation, noise):
    mended = lie.orthonormalize(rotation + np.outer(noise, noise[::-1]))
    assert lie.is_rotation(mended, ROUNDING)
    assert np.abs(mended - rotation).max() < 1e-5


@pytest.mark.parametrize(
    "matrix",
    [np.diag([1.0, 1.0, -1.0]), 1.01 * np.eye(3), np.full((3, 3), np.nan), np.eye(2)],
)
def test_is_rotation_refuses(matrix):
    assert not lie.is_rotation(matrix)


def test_quaternions_that_are_none_are_refused():
    with pytest.raises(ParameterError, match="non-zero norm"):
        lie.from_quaternion_xyzw(np.zeros(4))
    with pytest.raises(ParameterError, match="finite"):
        lie.from_quaternion_xyzw(np.array([math.nan, 0.0, 0.0, 1.0]))
    with pytest.raises(ShapeError, match="x, y, z, w"):
        lie.from_quaternion_xyzw(np.zeros(3))


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-3, 1.0, math.pi - 1e-9, math.pi])
def test_the_angle_between_vectors_is_exact_at_both_ends(angle):
    first = np.array([[3.0, 0.0, 0.0], [0.0, 0.0, 0.5]])
    second = np.array([math.cos(angle), math.sin(angle), 0.0])
    found = lie.vector_angle(first, 2.0 * second)
    assert found == pytest.approx([angle, 0.5 * math.pi], abs=1e-15)
    assert lie.vector_angle(first, np.stack([second, second])) == pytest.approx(found, abs=1e-15)
    assert np.isnan(lie.vector_angle(np.full(3, np.nan), second))
