"""Numbers from outside: what is let in and what is not."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from hypothesis import given
from strategies import rotations, vectors

from spacecraft_gnc.loop import guards

EYE = np.eye(3).ravel().tolist()


@given(rotations(), vectors())
def test_every_rotation_and_momentum_is_let_in(rotation, momentum):
    assert guards.reject_state(3, rotation.ravel().tolist(), momentum.tolist(), 3) is None
    assert guards.reject_reference(4, rotation.ravel().tolist(), 3) is None


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((1, EYE, [0.0, 0.0, 0.0], 2), "older"),
        ((2, [math.nan, *EYE[1:]], [0.0, 0.0, 0.0], 2), "NaN"),
        ((2, [math.inf, *EYE[1:]], [0.0, 0.0, 0.0], 2), "NaN or infinity"),
        ((2, [1.01, *EYE[1:]], [0.0, 0.0, 0.0], 2), r"R\^T R"),
        ((2, [-1.0, *EYE[1:]], [0.0, 0.0, 0.0], 2), "determinant"),
        ((2, EYE, [0.0, math.nan, 0.0], 2), "angular_momentum"),
        ((2, EYE, [0.0, math.inf, 0.0], 2), "finite"),
    ],
)
def test_states_that_are_none_are_refused_with_the_reason(arguments, words):
    reason = guards.reject_state(*arguments)
    assert reason is not None
    assert re.search(words, reason)
    assert "required" in reason


def test_references_that_are_none_are_refused():
    assert "older" in guards.reject_reference(1, EYE, 2)
    assert "rotation" in guards.reject_reference(2, [2.0, *EYE[1:]], 2)
