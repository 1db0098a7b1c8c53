"""Each representation of the attitude is the same rotation, and continuous in time."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from strategies import rotations

from spacecraft_gnc import lie
from spacecraft_gnc.drawing import representations as forms

STEP = 0.05  # [rad] between two attitudes of a path: far less than what a jump would be


def about(axis, angle):
    return lie.exp(angle * np.eye(3)["xyz".index(axis)])


def path(axis, turns):
    """Return attitudes (n, 3, 3) that turn about a fixed axis through several whole turns."""
    angles = np.arange(0.0, 2.0 * math.pi * turns, STEP)
    return np.array([lie.exp(angle * np.asarray(axis)) for angle in angles])


@given(rotations())
def test_the_quaternion_is_that_of_the_library(rotation):
    (quaternion,) = forms.quaternions_xyzw(rotation[None])
    expected = lie.to_quaternion_xyzw(rotation)
    # At a half turn rounding may pick either sign of the same attitude.
    assert abs(quaternion @ expected) == pytest.approx(1.0, abs=1e-14)
    np.testing.assert_allclose(lie.from_quaternion_xyzw(quaternion), rotation, atol=1e-14)


@given(rotations())
def test_roll_pitch_yaw_turn_about_the_fixed_axes_x_then_y_then_z(rotation):
    ((roll, pitch, yaw),) = np.radians(forms.roll_pitch_yaw_deg(rotation[None]))
    rebuilt = about("z", yaw) @ about("y", pitch) @ about("x", roll)
    # sqrt(eps) where the cosine of the pitch vanishes: roll and yaw are lost there
    near = forms.near_gimbal_lock(rotation[None])[0]
    np.testing.assert_allclose(rebuilt, rotation, atol=1e-7 if near else 1e-13)


@given(rotations())
def test_the_rotation_vector_is_the_logarithm(rotation):
    (vector,) = forms.rotation_vectors(rotation[None])
    np.testing.assert_allclose(lie.exp(vector), rotation, atol=1e-14)
    assert np.linalg.norm(vector) <= math.pi + 1e-12


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.6, 0.0, 0.8)])
def test_the_double_cover_never_shows_as_a_jump(axis):
    attitudes = path(axis, turns=3)
    quaternions = forms.quaternions_xyzw(attitudes)
    assert quaternions[0, 3] > 0.0
    assert np.abs(np.diff(quaternions, axis=0)).max() < STEP
    assert quaternions[:, 3].min() < -0.99  # it went through -1, the same attitude


def test_a_rotation_vector_goes_on_beyond_the_half_turn():
    attitudes = path((0.6, 0.0, 0.8), turns=0.9)
    vectors = forms.rotation_vectors(attitudes)
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=1), STEP * np.arange(len(vectors)),
                               atol=1e-9)  # fmt: skip


def test_yaw_goes_on_beyond_180_deg():
    angles = forms.roll_pitch_yaw_deg(path((0.0, 0.0, 1.0), turns=2))
    np.testing.assert_allclose(angles[:, 2], np.degrees(STEP * np.arange(len(angles))), atol=1e-9)


def test_a_lost_row_is_nan_and_the_curve_goes_on_behind_it():
    attitudes = path((0.0, 0.0, 1.0), turns=2)
    whole = [forms.values(form, attitudes) for form in forms.REPRESENTATIONS]
    attitudes[[0, 70, 71]] = math.nan
    for form, expected in zip(forms.REPRESENTATIONS, whole, strict=True):
        found = forms.values(form, attitudes)
        assert np.isnan(found[[0, 70, 71]]).all()
        known = np.isfinite(found).all(axis=1)
        assert known.sum() == len(attitudes) - 3
        np.testing.assert_allclose(found[known], expected[known], atol=1e-9)


def test_gimbal_lock_is_noticed():
    pitches = np.radians([0.0, 88.9, 89.1, 90.0, -89.5, -88.0])
    attitudes = np.array([about("z", 0.3) @ about("y", p) @ about("x", 0.2) for p in pitches])
    assert forms.near_gimbal_lock(attitudes).tolist() == [False, False, True, True, True, False]
