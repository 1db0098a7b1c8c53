"""Distributions of numbers and lists: inside their ends, with the density promised."""

from __future__ import annotations

import math

import numpy as np
import pytest
from drawn import (
    FINITE,
    SCALAR,
    SURE,
    UNIT,
    VECTOR,
    N,
    draws,
    made,
    spec,
)
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import kstest, loguniform, truncnorm

from spacecraft_gnc.campaign.distributions.discrete import Choice
from spacecraft_gnc.campaign.distributions.laws import LogUniform, Normal, Uniform, Whole
from spacecraft_gnc.parameters.parameter import Kind

# Numbers.


@given(FINITE, FINITE, UNIT)
def test_uniform_numbers_stay_between_their_ends(a, b, u):
    low, high = sorted((a, b))
    assert low <= Uniform(low, high).number(u) <= high
    assert Uniform(low, high).number(0.0) == low


@given(st.integers(-(10**6), 10**6), st.integers(0, 10**6), UNIT)
def test_whole_numbers_include_both_ends(low, more, u):
    law = Whole(low, low + more)
    assert law.lowest <= law.number(u) <= law.highest
    assert law.number(0.0) == low
    assert law.number(1.0 - 2.0**-53) == low + more


@given(st.floats(1e-300, 1e300), st.floats(1e-300, 1e300), UNIT)
def test_log_uniform_numbers_stay_between_their_ends(a, b, u):
    low, high = sorted((a, b))
    assert low <= LogUniform(low, high).number(u) <= high


@given(FINITE, st.floats(1e-3, 1e3), st.floats(-50.0, 50.0), st.floats(1e-3, 50.0), UNIT)
def test_truncated_normal_numbers_stay_between_their_ends(mean, deviation, start, length, u):
    low = mean + start * deviation
    high = low + length * deviation
    law = Normal.truncated(mean, deviation, low, high)
    if not law.is_empty:
        assert low <= law.lowest <= law.number(u) <= law.highest <= high


@pytest.mark.parametrize(
    ("low", "high"),
    [(-1.0, 2.0), (3.0, 4.0), (-4.0, -3.0), (20.0, 21.0), (-21.0, -20.0), (-1.0, 9.0), (0.0, 0.1)],
)
def test_truncated_normal_is_that_of_scipy(low, high):
    law = Normal.truncated(10.0, 2.0, 10.0 + 2.0 * low, 10.0 + 2.0 * high)
    shares = np.linspace(0.01, 0.99, 33)
    ours = np.array([law.number(u) for u in shares])
    theirs = truncnorm.ppf(shares, low, high, loc=10.0, scale=2.0)
    np.testing.assert_allclose(ours, theirs, rtol=1e-11)


def test_a_normal_number_without_ends_stays_within_nine_deviations():
    law = Normal.truncated(0.0, 1.0)
    assert -9.0 < law.lowest < -8.0
    assert 8.0 < law.highest < 9.0
    for u in (0.0, 1e-18, 1.0 - 2.0**-53):
        assert law.lowest <= law.number(u) <= law.highest


@given(FINITE, st.floats(1e-3, 1e3), UNIT, UNIT)
def test_a_normal_number_rises_with_the_share(mean, deviation, u, v):
    law = Normal.truncated(mean, deviation, mean + deviation, math.inf)
    low, high = sorted((u, v))
    assert law.number(low) <= law.number(high)


@pytest.mark.parametrize(
    ("text", "cdf"),
    [
        ("{distribution: uniform, from: 2.0, to: 6}", lambda x: (x - 2.0) / 4.0),
        ("{distribution: normal, mean: 1.0, std: 2.0}", truncnorm(-9, 9, 1.0, 2.0).cdf),
        (
            "{distribution: normal, mean: 1.0, std: 2.0, from: 0.0, to: 2.0}",
            truncnorm(-0.5, 0.5, 1.0, 2.0).cdf,
        ),
        ("{distribution: log_uniform, from: 1e-3, to: 10}", loguniform(1e-3, 10.0).cdf),
    ],
)
def test_numbers_follow_their_law(text, cdf):
    assert kstest(draws(made(text)), cdf).pvalue > 1e-3


def test_components_vary_independently_and_what_is_fixed_needs_no_number():
    text = "{distribution: uniform, from: [0.0, 5.0, -1.0], to: [1.0, 5.0, 1.0]}"
    distribution = made(text, VECTOR)
    assert distribution.dimensions == 2
    drawn = draws(distribution)
    assert (drawn[:, 1] == 5.0).all()
    assert abs(np.corrcoef(drawn[:, 0], drawn[:, 2])[0, 1]) < SURE
    assert made("{distribution: uniform, from: -1.0, to: 1.0}", VECTOR).dimensions == 3
    several = made("{distribution: normal, mean: 0.0, std: [1.0, 2.0, 3.0]}", VECTOR)
    assert np.std(draws(several), axis=0) == pytest.approx([1.0, 2.0, 3.0], rel=0.05)


def test_integers_are_uniform_over_whole_numbers():
    drawn = draws(made("{distribution: uniform, from: 3, to: 6}", spec(Kind.INTEGER)))
    assert drawn.dtype == np.int64
    assert np.bincount(drawn, minlength=7)[3:] / N == pytest.approx(0.25, abs=SURE)


# Lists of values.


def test_each_value_of_a_choice_is_as_probable():
    distribution = made("{distribution: choice, values: [a, b, c]}", spec(Kind.STRING))
    drawn = draws(distribution)
    assert distribution.size == 3
    for value in "abc":
        assert np.mean(drawn == value) == pytest.approx(1.0 / 3.0, abs=SURE)


def test_a_constant_needs_no_number_and_takes_the_type_of_the_parameter():
    distribution = made("{distribution: constant, value: [1, 2, 3]}", VECTOR)
    assert (distribution.dimensions, distribution.size) == (0, 1)
    value = distribution.value(np.zeros(0))
    assert value == [1.0, 2.0, 3.0]
    assert all(type(number) is float for number in value)


@pytest.mark.parametrize(
    ("text", "kind", "values"),
    [
        ("{distribution: choice, linspace: [0, 1, 5]}", SCALAR, (0.0, 0.25, 0.5, 0.75, 1.0)),
        ("{distribution: choice, linspace: [1, 9, 3]}", spec(Kind.INTEGER), (1, 5, 9)),
        (
            "{distribution: choice, linspace: [[0, 0, 1], [1, 0, 1], 2]}",
            VECTOR,
            ([0.0, 0.0, 1.0], [1.0, 0.0, 1.0]),
        ),
        ("{distribution: choice, linspace: [2.5, 4.0, 1]}", SCALAR, (2.5,)),
        (
            "{distribution: choice, values: [[1, 0, 0], [0, 1, 0]]}",
            VECTOR,
            ([1.0, 0, 0], [0, 1.0, 0]),
        ),
    ],
)
def test_lists_of_values(text, kind, values):
    assert made(text, kind).values == values


@given(st.lists(st.integers(), min_size=1, max_size=9), UNIT)
def test_a_choice_takes_what_is_listed(values, u):
    assert Choice(tuple(values)).value(np.array([u])) in values
