"""Distributions of directions, rotations and inertias."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from drawn import (
    INERTIA,
    POINTS3,
    SURE,
    UNIT,
    VECTOR,
    draws,
    made,
    spec,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import kstest
from strategies import inertias, rotations, unit_vectors

from spacecraft_gnc import lie
from spacecraft_gnc.campaign.distributions.directions import Cone, Turn, angle_less_sine
from spacecraft_gnc.campaign.distributions.inertia import Inertia
from spacecraft_gnc.parameters.parameter import Kind
from spacecraft_gnc.types import as_inertia, as_rotation

# Directions.


def test_directions_are_uniform_on_the_sphere():
    """Archimedes: the component along any axis is uniform in [-1, 1]."""
    drawn = draws(made("{distribution: direction, length: 2.0}", VECTOR))
    np.testing.assert_allclose(np.linalg.norm(drawn, axis=1), 2.0, rtol=1e-14)
    for axis in (*np.eye(3), np.array([0.6, -0.48, 0.64])):
        assert kstest(drawn @ axis, "uniform", args=(-2.0, 4.0)).pvalue > 1e-3


def test_a_length_may_vary_independently_of_the_direction():
    text = "{distribution: direction, length: {distribution: uniform, from: 1.0, to: 3.0}}"
    distribution = made(text, VECTOR)
    drawn = draws(distribution)
    lengths = np.linalg.norm(drawn, axis=1)
    assert distribution.dimensions == 3
    assert kstest(lengths, "uniform", args=(1.0, 2.0)).pvalue > 1e-3
    assert abs(np.corrcoef(lengths, drawn[:, 2] / lengths)[0, 1]) < SURE


@given(unit_vectors(), st.floats(1e-9, math.pi), POINTS3)
def test_directions_around_an_axis_stay_in_the_cone_and_in_its_box(axis, angle, point):
    cone = Cone.about(3.0 * axis, angle)
    direction = cone.direction(point[0], point[1])
    assert np.linalg.norm(direction) == pytest.approx(1.0, abs=1e-14)
    assert lie.vector_angle(direction, axis) <= angle * (1.0 + 1e-9) + 2e-16
    assert (direction >= cone.lowest).all()
    assert (direction <= cone.highest).all()


def test_directions_around_an_axis_are_uniform_over_the_cap():
    text = "{distribution: direction, length: 1.0, around: [1.0, 2.0, 2.0], max_angle_deg: 30.0}"
    drawn = draws(made(text, VECTOR))
    axis = np.array([1.0, 2.0, 2.0]) / 3.0
    low = math.cos(math.radians(30.0))
    assert kstest(drawn @ axis, "uniform", args=(low, 1.0 - low)).pvalue > 1e-3
    first, second = np.array([2.0, 1.0, -2.0]) / 3.0, np.array([2.0, -2.0, 1.0]) / 3.0
    turn = np.arctan2(drawn @ first, drawn @ second)
    assert kstest(turn, "uniform", args=(-math.pi, 2.0 * math.pi)).pvalue > 1e-3


# Rotations.


@given(st.floats(0.0, 1.0))
def test_an_angle_less_its_sine_keeps_its_digits(t):
    x = Fraction(t)
    series = sum((-1) ** k * x ** (2 * k + 3) / math.factorial(2 * k + 3) for k in range(10))
    assert angle_less_sine(t) == pytest.approx(float(series), rel=1e-12)


@given(st.floats(1e-9, math.pi), POINTS3)
def test_no_rotation_is_larger_than_the_angle(angle, point):
    assert np.linalg.norm(Turn(angle).vector(point)) <= angle * (1.0 + 1e-15)


@given(st.floats(1e-6, math.pi), UNIT)
def test_the_angle_is_the_inverse_of_its_distribution(largest, u):
    """Density (1 - cos t) / (A - sin A) up to A: the invariant measure of SO(3)."""
    angle = float(np.linalg.norm(Turn(largest).vector(np.array([u, 0.3, 0.4]))))
    share = angle_less_sine(angle) / angle_less_sine(largest)
    assert share == pytest.approx(u, rel=1e-12, abs=1e-300)


@pytest.mark.parametrize("degrees", [180.0, 90.0, 5.0, 1e-3])
def test_the_angle_has_the_density_one_less_cosine(degrees):
    text = f"{{distribution: rotation, max_angle_deg: {degrees}}}"
    drawn = draws(made(text, VECTOR, name="plant.initial_rotation_vector"))
    angles, largest = np.linalg.norm(drawn, axis=1), math.radians(degrees)
    share = np.vectorize(angle_less_sine)
    assert kstest(angles, lambda t: share(t) / angle_less_sine(largest)).pvalue > 1e-3
    for axis in np.eye(3):
        assert kstest(drawn @ axis / angles, "uniform", args=(-1.0, 2.0)).pvalue > 1e-3


@settings(max_examples=10)
@given(rotations())
def test_rotations_without_an_angle_are_uniform_over_the_group(fixed):
    """Moments of the trace, of 1, 3 and 6 dimensions of tensors, also of what a fixed one turns."""
    drawn = uniform_rotations()
    for stack in (drawn, fixed @ drawn, drawn @ fixed):
        assert np.abs(stack.mean(axis=0)).max() < SURE
        trace = np.trace(stack, axis1=1, axis2=2)
        for power, moment in ((1, 0.0), (2, 1.0), (3, 1.0), (4, 3.0)):
            spread = np.std(trace**power)
            assert np.mean(trace**power) == pytest.approx(moment, abs=SURE * spread)


@cache
def uniform_rotations():
    distribution = made("{distribution: rotation}", spec(Kind.DOUBLE_ARRAY, (3, 3)))
    return draws(distribution).reshape(-1, 3, 3)


@given(POINTS3)
def test_a_rotation_is_the_same_in_every_form(point):
    text = "{distribution: rotation, max_angle_deg: 120.0}"
    vector = made(text, VECTOR, name="plant.rotation_vector").value(point)
    matrix = made(text, spec(Kind.DOUBLE_ARRAY, (3, 3))).value(point)
    quaternion = made(text, spec(Kind.DOUBLE_ARRAY, (4,))).value(point)
    rotation = as_rotation("matrix", matrix)
    np.testing.assert_allclose(lie.exp(np.array(vector)), rotation, atol=1e-14)
    np.testing.assert_allclose(lie.from_quaternion_xyzw(np.array(quaternion)), rotation, atol=1e-14)


def test_a_plugins_list_of_numbers_takes_the_form_that_the_scenario_has():
    text, free = "{distribution: rotation}", spec(Kind.DOUBLE_ARRAY, (-1,))
    for count in (3, 4, 9):
        distribution = made(text, free, (1.0,) * count, name="plant.plugin.start")
        assert len(distribution.value(np.full(3, 0.5))) == count


# Inertias.


@given(
    inertias(),
    st.floats(0.0, 0.99),
    st.floats(0.0, math.pi),
    st.lists(UNIT, min_size=6, max_size=6).map(np.array),
)
def test_an_inertia_is_always_that_of_a_body(nominal, factor, angle, point):
    distribution = Inertia.about(nominal, factor, angle)
    matrix = as_inertia("inertia", distribution.value(point[: distribution.dimensions]))
    second = 0.5 * np.trace(matrix) - np.linalg.eigvalsh(matrix)[::-1]
    known = 0.5 * np.trace(nominal) - np.linalg.eigvalsh(nominal)[::-1]
    slack = 1e-12 * known[2]
    assert (second >= (1.0 - factor) * known - slack).all()
    assert (second <= (1.0 + factor) * known + slack).all()


@given(inertias(), st.floats(0.01, 0.5), st.lists(UNIT, min_size=6, max_size=6).map(np.array))
def test_the_axes_turn_by_no_more_than_the_angle(nominal, angle, point):
    turned = np.reshape(Inertia.about(nominal, 0.0, angle).value(point[:3]), (3, 3))
    turn = lie.exp(Turn(angle).vector(point[:3]))
    np.testing.assert_allclose(turned, turn @ nominal @ turn.T, atol=1e-13)
    assert lie.angle_between(np.eye(3), turn) <= angle + 1e-15


def test_inertia_factors_are_uniform_and_independent():
    text = "{distribution: inertia, factor: 0.2}"
    nominal = np.diag([5.0, 4.0, 3.0])
    drawn = draws(made(text, INERTIA, tuple(nominal.ravel()))).reshape(-1, 3, 3)
    moments = np.diagonal(drawn, axis1=1, axis2=2)
    second = 0.5 * moments.sum(axis=1, keepdims=True) - moments
    factors = second / np.array([1.0, 2.0, 3.0])
    for column in factors.T:
        assert kstest(column, "uniform", args=(0.8, 0.4)).pvalue > 1e-3
    assert np.abs(np.corrcoef(factors.T) - np.eye(3)).max() < SURE
    assert np.abs(drawn - moments[:, :, None] * np.eye(3)).max() < 1e-15
