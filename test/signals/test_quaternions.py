"""The quaternion of an attitude that was asked for lately is at hand, and is the same."""

from __future__ import annotations

from itertools import count

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.signals.attitude import quaternion_of
from spacecraft_gnc.types import read_only


def turned(angle: float) -> np.ndarray:
    return lie.exp(np.array([angle, 0.1, -0.2]))


def test_states_beside_a_reference_at_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a process with all nodes: state, pose and reference of each step."""
    original, calls = lie.to_quaternion_xyzw, count()

    def compute(rotation: np.ndarray) -> np.ndarray:
        next(calls)
        return original(rotation)

    monkeypatch.setattr(lie, "to_quaternion_xyzw", compute)
    reference = read_only(turned(2.0))
    for step in range(5):
        state = read_only(turned(0.1 * step))
        for attitude in (state, state, reference):
            np.testing.assert_array_equal(quaternion_of(attitude), original(attitude))
    assert next(calls) == 5 + 1


def test_an_attitude_that_may_change_is_never_at_hand() -> None:
    attitude = turned(0.3)
    quaternion_of(attitude)
    attitude[...] = turned(0.4)
    np.testing.assert_array_equal(quaternion_of(attitude), lie.to_quaternion_xyzw(attitude))
