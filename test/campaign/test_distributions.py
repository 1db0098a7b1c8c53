"""Distributions: values inside their ends, with the density that the name promises."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import kstest, loguniform, truncnorm
from strategies import inertias, rotations, unit_vectors

from spacecraft_gnc import lie
from spacecraft_gnc.campaign.distributions.directions import Cone, Turn, angle_less_sine
from spacecraft_gnc.campaign.distributions.discrete import Choice
from spacecraft_gnc.campaign.distributions.distribution import Target
from spacecraft_gnc.campaign.distributions.inertia import Inertia
from spacecraft_gnc.campaign.distributions.laws import LogUniform, Normal, Uniform, Whole
from spacecraft_gnc.campaign.distributions.read import read_distribution
from spacecraft_gnc.parameters.parameter import Kind, MatrixRule, ParameterSpec
from spacecraft_gnc.parameters.values import admissible
from spacecraft_gnc.parameters.yaml_node import compose
from spacecraft_gnc.plant.random_numbers import uniforms
from spacecraft_gnc.types import as_inertia, as_rotation

N = 20_000
SURE = 5.0 / math.sqrt(N)  # five deviations of the mean of N numbers of variance 1
UNIT = st.floats(0.0, 1.0, exclude_max=True)
POINTS3 = st.tuples(UNIT, UNIT, UNIT).map(np.array)
FINITE = st.floats(-1e9, 1e9)


def spec(kind=Kind.DOUBLE, shape=(), **options):
    return ParameterSpec(kind=kind, default=0.0, description="", shape=shape, **options)


SCALAR = spec()
VECTOR = spec(Kind.DOUBLE_ARRAY, (3,))
INERTIA = spec(Kind.DOUBLE_ARRAY, (3, 3), matrix=MatrixRule.INERTIA)


def read(text, target=SCALAR, nominal=(), name="plant.x"):
    """Return the distribution that a text describes, and what is wrong with it."""
    problems = []
    nominal = list(nominal) if isinstance(nominal, tuple) else nominal
    node = compose(text)
    found = read_distribution(node, Target(name, target, nominal), "v.yaml", problems)
    assert (found is None) == bool(problems)
    return found, [str(problem) for problem in problems]


def made(*arguments, **options):
    distribution, problems = read(*arguments, **options)
    assert not problems
    return distribution


def draws(distribution, seed=1, n=N):
    d = distribution.dimensions
    points = uniforms(seed, 0, "test", 0, n * d).reshape(n, d)
    return np.array([distribution.value(point) for point in points])


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


# Ranges: what a distribution may take, the parameter has to admit.

RANGES = st.fixed_dictionaries(
    {},
    optional={
        "minimum": st.floats(-2.0, 0.0),
        "maximum": st.floats(1.0, 3.0),
        "nonzero": st.booleans(),
    },
)
TEXTS = st.sampled_from(
    [
        "{distribution: uniform, from: -1.0, to: 2.0}",
        "{distribution: uniform, from: [0.0, -1.5, 0.5], to: [1.0, 0.5, 2.5]}",
        "{distribution: normal, mean: 0.5, std: 0.1}",
        "{distribution: normal, mean: 0.0, std: 1.0, from: -1.0, to: [1.0, 2.0, 3.0]}",
        "{distribution: log_uniform, from: 0.1, to: 2.0}",
        "{distribution: direction, length: 1.2}",
        "{distribution: direction, length: {distribution: choice, values: [0.0, 2.0]}}",
        "{distribution: direction, length: 2.0, around: [1.0, 1.0, 1.0], max_angle_deg: 20.0}",
        "{distribution: rotation, max_angle_deg: 90.0}",
        "{distribution: choice, values: [[0.5, 0.5, 0.5], [2.0, 2.0, 2.0]]}",
        "{distribution: choice, linspace: [[0.5, 0.5, 0.5], [-1.0, 2.0, 2.0], 4]}",
        "{distribution: constant, value: [0.0, 0.0, 0.0]}",
    ]
)


@given(TEXTS, RANGES, st.lists(UNIT, min_size=3, max_size=3).map(np.array))
def test_what_is_not_refused_never_leaves_the_range(text, options, point):
    target = spec(Kind.DOUBLE_ARRAY, (3,), **options)
    distribution, _ = read(text, target, name="plant.rotation_vector")
    if distribution is not None:
        for u in (point, np.zeros(3), np.full(3, 1.0 - 2.0**-53)):
            value = distribution.value(u[: distribution.dimensions])
            assert admissible(target, value, coerce=False) == value


@pytest.mark.parametrize(
    ("text", "target", "reason"),
    [
        (
            "{distribution: uniform, from: 0.0, to: 2.0}",
            spec(maximum=1.0),
            "received 2.0 as a value",
        ),
        ("{distribution: uniform, from: 0.0, to: 1.0}", spec(above=0.0), "received 0.0 as a value"),
        ("{distribution: normal, mean: 1.0, std: 0.2}", spec(minimum=0.0), "cut it off by from"),
        ("{distribution: log_uniform, from: 1.0, to: 9.0}", spec(below=9.0), "received 9.0 as"),
        ("{distribution: constant, value: 2.0}", spec(maximum=1.0), "x.value: received 2.0;"),
        ("{distribution: choice, values: [1, 2.5]}", spec(Kind.INTEGER), "values: received 2.5"),
        ("{distribution: choice, linspace: [0, 3, 3]}", spec(Kind.INTEGER), "linspace: received"),
        (
            "{distribution: direction, length: 3.0}",
            spec(Kind.DOUBLE_ARRAY, (3,), minimum=-2.0, maximum=2.0),
            "as a value that direction may take",
        ),
        (
            "{distribution: direction, length: 0.0}",
            spec(Kind.DOUBLE_ARRAY, (3,), nonzero=True),
            "of non-zero",
        ),
        ("{distribution: direction, length: -1.0}", VECTOR, "x.length: received -1.0"),
        (
            "{distribution: direction, length: {distribution: normal, mean: 1.0, std: 1.0}}",
            VECTOR,
            "x.length: received -7.29",
        ),
        ("{distribution: rotation}", VECTOR, "x.distribution: received a rotation for plant.x"),
        ("{distribution: rotation}", SCALAR, "a rotation for plant.x"),
        ("{distribution: rotation, max_angle_deg: 181}", VECTOR, "max_angle_deg: received 181.0"),
        ("{distribution: inertia, factor: 0.1}", VECTOR, "an inertia for plant.x"),
        ("{distribution: inertia, factor: 0.1}", INERTIA, "required plant.x in the scenario"),
        ("{distribution: uniform, from: 1.0, to: 2.0}", INERTIA, "choose inertia, or choice"),
        ("{distribution: uniform, from: a, to: 2.0}", SCALAR, "from: received 'a'"),
        ("{distribution: uniform, from: [1.0], to: 2.0}", SCALAR, "from: received [1.0]"),
        ("{distribution: uniform, from: [1.0, 2.0], to: 3.0}", VECTOR, "or a list of 3; write 3"),
        ("{distribution: uniform, from: [[1.0]], to: 3.0}", VECTOR, "or a list of 3"),
        (
            "{distribution: uniform, from: 2.0, to: 1.0}",
            SCALAR,
            "to: received 1.0; required at least",
        ),
        ("{distribution: uniform, from: 2.0, to: 2.0}", SCALAR, "choose constant"),
        ("{distribution: uniform, from: 0.5, to: 2}", spec(Kind.INTEGER), "from: received 0.5"),
        ("{distribution: uniform, from: 0, to: 2}", spec(Kind.STRING), "numbers for plant.x"),
        ("{distribution: uniform, from: 0.0, to: .nan}", SCALAR, "to: received nan"),
        ("{distribution: uniform, from: -.inf, to: 1.0}", SCALAR, "from: received -inf"),
        ("{distribution: uniform, to: 1.0}", SCALAR, "from: received nothing"),
        ("{distribution: uniform, from: {a: 1}, to: 1.0}", SCALAR, "from: received a mapping"),
        (
            "{distribution: uniform, from: 0.0, to: 1.0}",
            spec(Kind.DOUBLE_ARRAY, (-1,)),
            "no value in",
        ),
        ("{distribution: normal, mean: 0, std: 0}", SCALAR, "std: received 0; required > 0"),
        ("{distribution: normal, mean: 0, std: 1}", spec(Kind.INTEGER), "received real numbers"),
        ("{distribution: normal, mean: 0, std: 1, from: 50, to: 60}", SCALAR, "within 37 std"),
        ("{distribution: log_uniform, from: 0, to: 1}", SCALAR, "from: received 0; required > 0"),
        ("{distribution: choice, values: []}", SCALAR, "values: received []"),
        ("{distribution: choice, values: 3}", SCALAR, "values: received '3'"),
        ("{distribution: choice}", SCALAR, "values: received nothing"),
        (
            "{distribution: choice, values: [1], linspace: [1, 2, 3]}",
            SCALAR,
            "remove one of the two",
        ),
        ("{distribution: choice, linspace: [0, 1, 0]}", SCALAR, "linspace: received 0"),
        ("{distribution: choice, linspace: [0, [1, 2], 2]}", SCALAR, "two ends of one length"),
        ("{distribution: choice, linspace: [0, 1]}", SCALAR, "2 items"),
        (
            "{distribution: direction, length: 1, max_angle_deg: 3}",
            VECTOR,
            "around: received nothing",
        ),
        ("{distribution: direction, length: 1, around: [0, 0, 0]}", VECTOR, "non-zero length"),
        ("{distribution: direction}", VECTOR, "length: received nothing"),
        ("{distribution: direction, length: 1.0}", SCALAR, "a parameter that takes 3 numbers"),
        ("{distribution: unifrom, from: 0, to: 1}", SCALAR, "did you mean 'uniform'?"),
        ("{from: 0.0, to: 1.0}", SCALAR, "distribution: received nothing"),
        ("{distribution: uniform, from: 0, to: 1, form: 2}", SCALAR, "did you mean 'from'?"),
        ("{distribution: uniform, from: 0, from: 1, to: 2}", SCALAR, "the key a second time"),
        ("{distribution: !!str uniform}", SCALAR, "without a YAML tag"),
        ("{distribution: uniform, from: , to: 1.0}", SCALAR, "write one, or remove the key"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(text, target, reason):
    _, problems = read(text, target)
    assert any(reason in problem for problem in problems), problems
    for problem in problems:
        assert problem.startswith("v.yaml:1: plant.x")
        assert "\n" not in problem


def test_a_flat_body_has_no_inertia_to_vary():
    flat = np.diag([1.0, 1.0, 2.0 - 1e-13])
    _, problems = read("{distribution: inertia, axes_deg: 5.0}", INERTIA, tuple(flat.ravel()))
    assert "a smallest second moment" in problems[0]


def test_nothing_to_vary_of_an_inertia_is_refused():
    _, problems = read("{distribution: inertia}", INERTIA, tuple(np.eye(3).ravel()))
    assert "one of them > 0" in problems[0]


def test_lengths_nested_without_end_are_refused():
    text = "1.0"
    for _ in range(200):
        text = f"{{distribution: direction, length: {text}}}"
    _, problems = read(text, VECTOR)
    assert "a direction for plant.x.length" in problems[0]
