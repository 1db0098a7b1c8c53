"""Numbers from outside: what is let in and what is not."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import rotations, vectors

from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.signals import Refused
from spacecraft_gnc.signals.attitude import GOVERNOR_STATUS, REFERENCE, TARGET, at_rest
from spacecraft_gnc.signals.graph import WALL_TIMING
from spacecraft_gnc.signals.rules import reject_infinite, reject_nan, reject_rotation
from spacecraft_gnc.types import GovernorDecision
from spacecraft_gnc.vehicles.rigid_body.signals import (
    SOLVER_STATUS,
    STATE,
    TORQUE,
    Torque,
)

ZERO = np.zeros(3)
STAMP = (1, 2)


def state(attitude=None, momentum=ZERO, rate=ZERO, step=2):
    attitude = np.eye(3) if attitude is None else attitude
    values = attitude.ravel(), np.zeros(4), momentum, rate
    return replace(STATE, pack=None).encode(STAMP, step, values)


@given(rotations(), vectors())
def test_every_rotation_and_momentum_is_let_in(rotation, momentum):
    message = STATE.decode(state(rotation, momentum, step=3), 3)
    found = STATE.value(message)
    assert (found.step, message.stamp) == (3, STAMP)
    assert np.array_equal(found.attitude, rotation)
    assert np.array_equal(found.momentum, momentum)
    reference = REFERENCE.value(REFERENCE.decode(REFERENCE.encode(STAMP, 4, at_rest(rotation)), 3))
    assert np.array_equal(reference.attitude, rotation)


def changed(index, value):
    matrix = np.eye(3)
    matrix.flat[index] = value
    return matrix


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (state(step=1), "older"),
        (state(changed(0, math.nan)), "attitude holds NaN or infinity"),
        (state(changed(1, math.inf)), "NaN or infinity; required 9"),
        (state(changed(0, 1.01)), r"R\^T R"),
        (state(changed(0, -1.0)), "determinant"),
        (state(momentum=np.array([0.0, math.nan, 0.0])), "angular_momentum holds NaN"),
        (state(rate=np.array([0.0, math.inf, 0.0])), "angular_velocity .* required 3 finite"),
        (state()[:-8], "no AttitudeState"),
        (b"", "0 bytes that are no AttitudeState"),
        (b"\x00\x07" + state()[2:], "do not begin as CDR"),
    ],
)
def test_states_that_are_none_are_refused_with_the_reason(data, words):
    with pytest.raises(Refused, match=words) as refused:
        STATE.decode(data, 2)
    assert "required" in str(refused.value) or "bytes" in str(refused.value)


def test_references_and_targets_that_are_none_are_refused():
    with pytest.raises(Refused, match="older"):
        REFERENCE.decode(REFERENCE.encode(STAMP, 1, at_rest(np.eye(3))), 2)
    with pytest.raises(Refused, match="rotation"):
        TARGET.decode(TARGET.encode(STAMP, 2, at_rest(2.0 * np.eye(3))))


@pytest.mark.parametrize("source", Source)
def test_every_source_is_let_in(source):
    data = TORQUE.encode(STAMP, 2, Torque(ZERO, source))
    assert TORQUE.value(TORQUE.decode(data)).source is source


def test_a_source_that_is_none_is_refused():
    data = TORQUE.encode(STAMP, 2, Torque(ZERO, 9))
    with pytest.raises(Refused, match="source is 9; required 0 to 5"):
        TORQUE.decode(data)


def solved(status, residual):
    nothing = [ZERO.repeat(2), 0.0, (), math.nan, math.nan, "", (), (), (), 0.0, 0.0]
    return SOLVER_STATUS.encode(STAMP, 2, ["shooting", "", status, 1, residual, 0.0, *nothing])


def test_what_was_found_is_finite_where_a_solve_converged():
    assert math.isnan(SOLVER_STATUS.decode(solved(1, math.nan))["residual"])
    with pytest.raises(Refused, match="residual is nan; required a finite number"):
        SOLVER_STATUS.decode(solved(0, math.nan))


def test_a_margin_may_be_infinite_and_a_latency_unknown():
    decision = GovernorDecision(at_rest(np.eye(3)), 1.0, True, math.inf, "", 0)
    data = GOVERNOR_STATUS.encode(STAMP, 0, decision)
    assert GOVERNOR_STATUS.decode(data)["margin"] == math.inf
    data = GOVERNOR_STATUS.encode(STAMP, 0, decision._replace(margin=math.nan))
    with pytest.raises(Refused, match="margin"):
        GOVERNOR_STATUS.decode(data)
    timing = WALL_TIMING.encode(STAMP, 0, (1.0, math.nan, math.nan, 0, 0, 0))
    assert math.isnan(WALL_TIMING.decode(timing)["wall_latency"])


@given(st.lists(st.floats(), min_size=1, max_size=9))
def test_the_checks_of_numbers_say_what_numpy_says(numbers):
    array = np.array(numbers)
    assert (reject_infinite("x", tuple(numbers)) is None) == bool(np.isfinite(array).all())
    assert (reject_nan("x", tuple(numbers)) is None) == (not np.isnan(array).any())


def test_large_finite_numbers_are_let_in():
    assert reject_infinite("x", (1e308, 1e308, 1e308)) is None
    assert "NaN" in (reject_rotation("x", [1e200] * 9) or "")
