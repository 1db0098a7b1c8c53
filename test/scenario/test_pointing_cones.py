"""Two zones and what they leave: against random attitudes, and against one that is constructed."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from strategies import rotations, unit_vectors

from spacecraft_gnc import lie
from spacecraft_gnc.vehicles.rigid_body.checks.pointing_cones import (
    Cone,
    direction,
    implies,
    leave_nothing,
)

KINDS = st.sampled_from(["exclusion", "inclusion"])
CONSTRUCTED = 1e-7  # [rad], above ANGLE_TOLERANCE: rounding of the frames of nearly parallel axes
N_ATTITUDES = 4000


@st.composite
def cones(draw, body_axes=None):
    """Return a zone, of an axis of its own or out of ``body_axes``."""
    body = draw(unit_vectors()) if body_axes is None else draw(st.sampled_from(body_axes))
    room = draw(st.one_of(st.floats(0.01, 0.5), st.floats(0.01, math.pi - 0.01)))
    kind = draw(KINDS)
    half = room if kind == "inclusion" else math.pi - room
    return Cone("a", kind, np.array(body), draw(unit_vectors()), half)


AXES = [(1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.6, 0.8, 0.0)]
PAIRS = st.one_of(st.tuples(cones(), cones()), st.tuples(cones(AXES), cones(AXES)))


def attitudes() -> np.ndarray:
    """Return rotations (n, 3, 3), uniform on SO(3)."""
    quaternions = np.random.default_rng(7).normal(size=(N_ATTITUDES, 4))
    return np.array([lie.from_quaternion_xyzw(q) for q in quaternions])


ATTITUDES = attitudes()


def satisfied(cone: Cone) -> np.ndarray:
    """Return which of ATTITUDES satisfy a zone, as (n,) booleans, by its definition."""
    cosine = np.einsum("nij,j,i->n", ATTITUDES, cone.body_axis, cone.cone_axis)
    inside = cosine >= math.cos(cone.half_angle)
    return ~inside if cone.kind == "exclusion" else inside


def frame(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the right-handed frame (3, 3) of two directions, the first being its first column."""
    normal = np.cross(first, second)
    if np.linalg.norm(normal) < 1e-12:  # parallel: any normal will do
        normal = np.cross(first, np.eye(3)[np.argmin(np.abs(first))])
    normal /= np.linalg.norm(normal)
    return np.column_stack([first, np.cross(normal, first), normal])


def attitude_for(first: Cone, second: Cone) -> np.ndarray:
    """Return the attitude that shares the misfit of the angles out among the two cones."""
    (axis_1, half_1), (axis_2, half_2) = first.allowed, second.allowed
    misfit = lie.vector_angle(first.body_axis, second.body_axis) - lie.vector_angle(axis_1, axis_2)
    plane = frame(axis_1, axis_2)
    angle_1 = -misfit * half_1 / (half_1 + half_2)
    seen_1 = plane @ [math.cos(angle_1), math.sin(angle_1), 0.0]
    beside = plane @ [-math.sin(angle_1), math.cos(angle_1), 0.0]
    return frame(seen_1, beside) @ frame(first.body_axis, second.body_axis).T


@given(PAIRS)
def test_where_nothing_is_left_no_attitude_satisfies_both(pair: tuple[Cone, Cone]) -> None:
    assume(leave_nothing(*pair))
    assert not (satisfied(pair[0]) & satisfied(pair[1])).any()


@given(PAIRS)
def test_where_something_is_left_an_attitude_satisfies_both(pair: tuple[Cone, Cone]) -> None:
    assume(not leave_nothing(*pair))
    attitude = attitude_for(*pair)
    for cone in pair:
        axis, half = cone.allowed
        assert lie.vector_angle(attitude @ cone.body_axis, axis) <= half + CONSTRUCTED


@given(cones(), st.floats(0.0, 1.5), st.floats(-0.5, 0.5), st.booleans())
def test_an_implied_zone_forbids_nothing_more(
    first: Cone, tilt: float, spare: float, mirror: bool
) -> None:
    """Beside a zone, another of the same axis, tilted, that leaves ``spare`` around the first."""
    axis, room = first.allowed
    room_2 = room + tilt + spare
    assume(0.0 < room_2 < math.pi and abs(spare) > CONSTRUCTED)
    aside = frame(axis, np.roll(first.body_axis, 1)) @ [math.cos(tilt), math.sin(tilt), 0.0]
    allowed = Cone("b", "inclusion", first.body_axis, aside, room_2)
    if first.is_exclusion:
        allowed = Cone("b", "exclusion", first.body_axis, -aside, math.pi - room_2)
    second = allowed.mirrored() if mirror else allowed
    assert implies(first, second) == (spare > 0.0)
    if spare > 0.0:
        assert not (satisfied(first) & ~satisfied(second)).any()


@given(PAIRS)
def test_the_order_of_the_zones_does_not_matter(pair: tuple[Cone, Cone]) -> None:
    assert leave_nothing(*pair) == leave_nothing(*reversed(pair))


@given(cones(), cones(), rotations())
def test_the_opposite_axis_in_the_opposite_cone_is_the_same(
    first: Cone, second: Cone, attitude: np.ndarray
) -> None:
    assert first.mirrored().angle(attitude) == pytest.approx(first.angle(attitude), abs=1e-12)
    assert leave_nothing(first.mirrored(), second) == leave_nothing(first, second)


@given(cones())
def test_a_zone_implies_itself(cone: Cone) -> None:
    assert implies(cone, cone)
    assert implies(cone, cone.mirrored())
    assert not leave_nothing(cone, cone)


@given(unit_vectors(), st.floats(-308.0, 308.0))
@example(np.array([1.0, 0.0, 0.0]), -308.0)
def test_a_direction_of_any_length(vector: np.ndarray, exponent: float) -> None:
    np.testing.assert_allclose(direction(10.0**exponent * vector), vector, atol=1e-12)
