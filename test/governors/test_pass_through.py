"""The governor that does not govern."""

from __future__ import annotations

import math

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors import PassThroughGovernor
from spacecraft_gnc.loop import State

STATE = State(0, np.eye(3), np.zeros(3))


def test_the_reference_is_the_target_until_a_new_one_is_set():
    first, second = lie.exp(np.array([0.1, 0.0, 0.0])), lie.exp(np.array([0.0, 2.0, 0.0]))
    governor = PassThroughGovernor(first)
    decision = governor.decide(STATE)
    assert np.array_equal(decision.reference.attitude, first)
    assert (decision.alpha, decision.admissible, decision.active_constraint) == (1.0, True, "")
    assert math.isinf(decision.margin)
    governor.set_target(second)
    assert np.array_equal(governor.decide(STATE).reference.attitude, second)
    governor.reset()
    assert np.array_equal(governor.decide(STATE).reference.attitude, first)


def test_targets_that_are_no_rotation_are_refused_and_change_nothing():
    governor = PassThroughGovernor(np.eye(3))
    with pytest.raises(ParameterError, match="target"):
        governor.set_target(np.diag([1.0, 1.0, -1.0]))
    assert np.array_equal(governor.target, np.eye(3))
