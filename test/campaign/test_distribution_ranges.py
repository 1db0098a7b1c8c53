"""What a distribution may take, the parameter has to admit; what is wrong is said."""

from __future__ import annotations

import numpy as np
import pytest
from drawn import (
    INERTIA,
    POINTS3,
    SCALAR,
    UNIT,
    VECTOR,
    made,
    read,
    spec,
)
from hypothesis import given
from hypothesis import strategies as st

from spacecraft_gnc.parameters.parameter import Kind
from spacecraft_gnc.parameters.values import admissible

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


@pytest.mark.parametrize("count", [3, 4, 9])
@given(st.floats(1e-3, 180.0), POINTS3)
def test_the_extremes_of_a_rotation_enclose_its_numbers_in_every_form(count, degrees, point):
    text = f"{{distribution: rotation, max_angle_deg: {degrees!r}}}"
    distribution = made(text, spec(Kind.DOUBLE_ARRAY, (count,)), name="plant.rotation_vector")
    ends, value = np.array(list(distribution.extremes())), np.array(distribution.value(point))
    assert (value >= ends.min(axis=0) - 4e-16).all()
    assert (value <= ends.max(axis=0) + 4e-16).all()


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


def test_an_inertia_varies_about_a_matrix_of_its_own():
    text = "{{distribution: inertia, factor: 0.1, about: {}}}"
    about = [2.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 4.0]
    distribution, problems = read(text.format(about), INERTIA, tuple(np.eye(3).ravel()))
    assert problems == []
    np.testing.assert_allclose(distribution.value(np.full(3, 0.5)), about, atol=1e-15)
    low = np.reshape(distribution.value(np.zeros(3)), (3, 3))
    np.testing.assert_allclose(low, 0.9 * np.diag([2.0, 3.0, 4.0]), atol=1e-15)
    for wrong in ([1.0, 2.0], [-value for value in about], "one"):
        _, problems = read(text.format(wrong), INERTIA, tuple(np.eye(3).ravel()))
        assert len(problems) == 1
        assert "plant.x.about" in problems[0]


def test_nothing_to_vary_of_an_inertia_is_refused():
    _, problems = read("{distribution: inertia}", INERTIA, tuple(np.eye(3).ravel()))
    assert "one of them > 0" in problems[0]


def test_lengths_nested_without_end_are_refused():
    text = "1.0"
    for _ in range(200):
        text = f"{{distribution: direction, length: {text}}}"
    _, problems = read(text, VECTOR)
    assert "a direction for plant.x.length" in problems[0]
