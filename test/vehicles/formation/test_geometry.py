"""Pairs of craft: order, distances, and the angles of communication."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from spacecraft_gnc import lie
from spacecraft_gnc.vehicles.formation.geometry import (
    UNDEFINED_DEG,
    communication_angles_deg,
    pairs,
    separations,
)

POSITIONS = arrays(np.float64, (3, 3), elements=st.floats(-1e4, 1e4, allow_subnormal=False))


def test_pairs_are_in_the_order_of_the_arrays() -> None:
    assert pairs(3).tolist() == [[0, 1], [0, 2], [1, 2]]
    assert pairs(4)[:, 1].tolist() == [1, 2, 3, 2, 3, 3]


def test_separations_of_a_triangle() -> None:
    position = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 4.0, 0.0]])
    assert separations(position).tolist() == [3.0, 4.0, 5.0]
    assert separations(np.stack([position, 2.0 * position]))[1].tolist() == [6.0, 8.0, 10.0]


@given(POSITIONS, st.floats(-3.14159, 3.14159))
def test_a_turn_of_all_places_is_the_angle_of_each_pair(position: np.ndarray, turn: float) -> None:
    flat = position * [1.0, 1.0, 0.0]
    apart = separations(flat)
    turned = flat @ lie.exp(np.array([0.0, 0.0, turn])).T
    angles = communication_angles_deg(turned, flat)
    far = apart > 1.0  # else rounding decides on the direction
    np.testing.assert_allclose(angles[far], abs(np.degrees(turn)), rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("turn", [0.0, 1e-9, np.pi - 1e-9, np.pi])
def test_small_and_opposite_directions_keep_their_digits(turn: float) -> None:
    wanted = np.array([[0.0, 0.0, 0.0], [1e3, 0.0, 0.0]])
    actual = np.array([[0.0, 0.0, 0.0], [1e3 * np.cos(turn), 1e3 * np.sin(turn), 0.0]])
    angle = communication_angles_deg(actual, wanted)
    np.testing.assert_allclose(angle, np.degrees(turn), rtol=1e-12, atol=1e-16)


def test_craft_at_one_place_have_the_worst_angle() -> None:
    apart = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    assert communication_angles_deg(np.zeros((2, 3)), apart).tolist() == [UNDEFINED_DEG]
    assert communication_angles_deg(apart, np.zeros((2, 3))).tolist() == [UNDEFINED_DEG]
