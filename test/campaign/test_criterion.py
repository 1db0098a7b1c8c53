"""Criterion of success: what it means, what is unknown, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spacecraft_gnc.campaign.criterion import Criterion
from spacecraft_gnc.parameters.problems import InvalidScenario

NUMBERS = st.floats(-1e6, 1e6)
METRICS = ("a", "b", "c")


@pytest.mark.parametrize(
    ("text", "row", "holds"),
    [
        ("a < 0.1", {"a": 0.05}, True),
        ("a < 0.1", {"a": 0.1}, False),
        ("a <= 0.1 and b > 0", {"a": 0.1, "b": 1}, True),
        ("0 < a < b", {"a": 1, "b": 2}, True),
        ("0 < a < b", {"a": 2, "b": 2}, False),
        ("a + 2*b - c/4 >= -(1)", {"a": 0, "b": -0.5, "c": 0.0}, True),
        ("not (a < 1 or b < 1)", {"a": 1, "b": 1}, True),
        ("a == true", {"a": True}, True),
        ("a != false", {"a": np.bool_(False)}, False),
        ("'settle_time_0.1deg' < 60", {"settle_time_0.1deg": 59.0}, True),
        ('"zone_margin_deg.sun" > 0', {"zone_margin_deg.sun": np.float32(1.0)}, True),
        ("a < 1", {"a": math.inf}, False),
        ("a < 1\n  and b < 1\n", {"a": 0, "b": 0}, True),
    ],
)
def test_what_an_expression_means(text, row, holds):
    assert Criterion.parse(text).holds(row) is holds


@pytest.mark.parametrize("unknown", [None, math.nan, "late", [1.0], np.nan])
def test_a_metric_without_a_value_never_passes_by_itself(unknown):
    row = {"a": unknown, "b": 1.0}
    for text in ("a < 1", "not a < 1", "a >= 1 or a < 1", "b > 0 and a == a", "a / b < 1"):
        assert not Criterion.parse(text).holds(row), text
    for text in ("b > 0 or a < 1", "not (b < 0 and a < 1)"):
        assert Criterion.parse(text).holds(row), text


def test_an_absent_metric_and_a_division_by_zero_are_unknown():
    assert not Criterion.parse("a < 1").holds({})
    assert not Criterion.parse("1/a > 0").holds({"a": 0.0})
    assert not Criterion.parse("not 1/a > 0").holds({"a": 0.0})
    assert not Criterion.parse("a - a < 1").holds({"a": math.inf})


def test_a_number_is_no_truth_value_of_a_flight():
    assert not Criterion.parse("a == true").holds({"a": 1.0})
    assert not Criterion.parse("a < 1").holds({"a": False})


@st.composite
def expressions(draw, depth=3):
    """Text of a random criterion, which Python would read alike, and its metrics."""

    def number(depth):
        if depth == 0 or draw(st.booleans()):
            is_metric = draw(st.booleans())
            return draw(st.sampled_from(METRICS)) if is_metric else repr(draw(NUMBERS))
        operator = draw(st.sampled_from("+-*"))
        return f"({number(depth - 1)} {operator} {number(depth - 1)})"

    def truth(depth):
        kind = draw(
            st.sampled_from(["compare", "chain", "not", "and", "or"][: 2 + 3 * (depth > 0)])
        )
        if kind == "compare":
            sign = draw(st.sampled_from(["<", "<=", ">", ">=", "==", "!="]))
            return f"{number(2)} {sign} {number(2)}"
        if kind == "chain":
            return f"{number(1)} < {number(1)} <= {number(1)}"
        if kind == "not":
            return f"not ({truth(depth - 1)})"
        return f"({truth(depth - 1)}) {kind} ({truth(depth - 1)})"

    return f"a < 1 and ({truth(depth)})"


@given(expressions(), st.tuples(NUMBERS, NUMBERS, NUMBERS))
def test_with_every_metric_known_it_is_what_python_says(text, numbers):
    row = dict(zip(METRICS, numbers, strict=True))
    assert Criterion.parse(text).holds(row) == eval(text, {}, dict(row))


@given(expressions(), st.tuples(NUMBERS, NUMBERS, NUMBERS), st.sampled_from(METRICS), NUMBERS)
def test_what_passes_with_a_metric_unknown_passes_with_every_value_of_it(
    text, numbers, name, other
):
    row = dict(zip(METRICS, numbers, strict=True))
    criterion = Criterion.parse(text)
    if criterion.holds(row | {name: None}):
        assert criterion.holds(row | {name: other})


@given(expressions(), st.tuples(NUMBERS, NUMBERS, NUMBERS), st.floats(1e-3, 1e6))
def test_a_worse_metric_never_turns_a_failure_into_a_success(text, numbers, by):
    row = dict(zip(METRICS, numbers, strict=True))
    criterion = Criterion.parse(text)
    for name, sign in criterion.worse.items():
        if not criterion.holds(row):
            assert not criterion.holds(row | {name: row[name] + sign * by})


@pytest.mark.parametrize(
    ("text", "worse"),
    [
        ("a < 1", {"a": 1}),
        ("1 > a and b >= 0", {"a": 1, "b": -1}),
        ("not a < 1", {"a": -1}),
        ("a - b < 1 or -c > 2", {"a": 1, "b": -1, "c": 1}),
        ("-2*a < 1", {"a": -1}),
        ("a / -4 < b", {"a": -1, "b": -1}),
        ("0 < a < 1", {}),
        ("a == 1 and b < 2", {"b": 1}),
        ("a * b < 1", {}),
        ("a / b < 1", {}),
    ],
)
def test_the_worse_side_of_each_metric(text, worse):
    criterion = Criterion.parse(text)
    assert dict(criterion.worse) == worse
    assert criterion.worse.keys() <= criterion.names


def test_the_names_are_those_of_the_metrics():
    criterion = Criterion.parse("a < 1 and 'b.c' > 0 or not (true == (d < 2))")
    assert criterion.names == {"a", "b.c", "d"}
    criterion.check(["a", "b.c", "d", "e"])


def test_an_unknown_metric_is_refused_with_the_nearest():
    criterion = Criterion.parse("fianl_error_deg < 1 and zzz > 0", "v.yaml", 7)
    with pytest.raises(InvalidScenario) as caught:
        criterion.check({"final_error_deg": 1.0, "max_torque": 2.0})
    first, second = str(caught.value).split("\n")
    assert first.startswith("v.yaml:7: pass: received 'fianl_error_deg'; required a metric")
    assert first.endswith("did you mean 'final_error_deg'?")
    assert "'zzz'" in second


@pytest.mark.parametrize(
    "text",
    [
        "",
        "   ",
        "1 < 2",
        "true",
        "a",
        "a + 1",
        "not a",
        "a and b < 1",
        "a.b < 1",
        "a() < 1",
        "__import__('os').system('true') < 1",
        "().__class__ < a",
        "a[0] < 1",
        "[a < 1]",
        "{a: 1} < 1",
        "(a, b) < 1",
        "lambda: a < 1",
        "(b := a) < 1",
        "a if a < 1 else b < 1",
        "[x for x in a] < 1",
        "f'{a}' < 1",
        "b'a' < 1",
        "'' < 1",
        "a ** 9 < 1",
        "a % 2 < 1",
        "a // 2 < 1",
        "a & b < 1",
        "~a < 1",
        "a in b",
        "a is b",
        "True == a",
        "None == a",
        "... < a",
        "1j < a",
        "1e999 < a",
        "9" * 3000 + " < a",
        "(a < 1) < 2",
        "(a < 1) + 1 < 2",
        "-(a < 1) < 2",
        "a < 1; b < 1",
        "a = 1",
        "import os",
        "await a",
        "a < 1\nb < 2",
        "a \0 < 1",
        "a < 1 # degrees\nand b < 1",
        "(" * 500 + "a < 1" + ")" * 500,
        "not " * 900 + "a < 1",
        "-" * 3900 + "a < 1",
        "+".join(["a"] * 1900) + " < 1",
        "a < 1" + " " * 5000,
        "a" * 10**6 + " < 1",
        "1if a < 1else b",
    ],
)
def test_everything_else_is_refused_in_one_line(text):
    with pytest.raises(InvalidScenario) as caught:
        Criterion.parse(text)
    message = str(caught.value)
    assert message.startswith("criterion: pass: received ")
    assert "; required " in message
    assert "\n" not in message
    assert len(message) < 500


@given(st.text(max_size=40) | st.text("abc<>=()+-*/.'\" 019notrued", max_size=40))
def test_any_text_is_read_or_refused(text):
    try:
        criterion = Criterion.parse(text)
    except InvalidScenario:
        return
    assert criterion.names
    assert criterion.holds({}) in (True, False)
