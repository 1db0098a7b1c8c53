"""The formation problem: what it refuses, and its loop."""

from __future__ import annotations

import math

import formations
import numpy as np
import pytest

from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.governors.time_shift import Constraint, Margin, TimeShiftGovernor
from spacecraft_gnc.governors.time_shift.problem import shift_distance

RATE = formations.RATE


@pytest.mark.parametrize(
    ("changes", "error", "told"),
    [
        ({"gain": np.zeros((3, 6))}, ParameterError, r"gain: .* spectral radius 1"),
        ({"gain": np.zeros((6, 3))}, ShapeError, "gain"),
        ({"natural": formations.ellipse(49)}, ParameterError, r"natural: .* misses its next"),
        ({"natural": np.zeros((50, 4))}, ShapeError, r"natural: .* \(p, 6\)"),
        ({"phases": (1,)}, ShapeError, r"phases: .* at least 2 craft"),
        ({"phases": (1.5, 2.0, 3.0)}, ParameterError, r"phases: .* whole numbers"),
        ({"phases": (0, 10, 20, 30, 40)}, ParameterError, r"phases: received 5 craft .* at most"),
        ({"max_delta_v": 0.0}, ParameterError, "max_delta_v"),
        ({"max_delta_v": math.nan}, ParameterError, "max_delta_v"),
        ({"min_separation": -1.0}, ParameterError, "min_separation"),
        ({"max_angle": 3.2}, ParameterError, r"max_angle: .* to pi"),
        ({"shift_weight": 0.0}, ParameterError, "shift_weight"),
        ({"horizon": 0}, ParameterError, "horizon"),
        ({"substeps": 1.5}, ParameterError, "substeps"),
    ],
)
def test_what_cannot_be_is_refused(changes, error, told):
    with pytest.raises(error, match=told):
        formations.problem(**changes)


def test_the_motion_needs_the_velocities_of_its_samples():
    natural = formations.ellipse(50).copy()
    natural[:, 3:] *= 1.001
    with pytest.raises(ParameterError, match="natural"):
        formations.problem(natural=natural)


def test_errors_shrink_by_the_loop_map():
    problem = formations.problem()
    shifts, states = np.array([1, 2, 3]), formations.start(formations.ellipse(50))
    after = problem.step(states, problem.delta_v(7, states, shifts))
    error = states - problem.commanded(7, shifts)
    np.testing.assert_allclose(
        after - problem.commanded(8, shifts), error @ problem.loop_map.T, atol=1e-6
    )


def test_distances_of_shifts_go_round_the_period():
    found = shift_distance(50)
    assert found[0, 49] == found[49, 0] == 1.0
    assert found[10, 35] == 25.0
    assert found.max() == 25.0
    np.testing.assert_array_equal(found, found.T)


def test_limits_can_be_left_out():
    free = formations.problem(max_delta_v=math.inf, min_separation=0.0, max_angle=math.pi)
    decision = TimeShiftGovernor(free).decide(0, formations.start(free.natural))
    assert decision.n_admissible == decision.n_candidates == 50**3
    assert decision.margin is not None
    assert decision.margin.share == math.inf
    assert decision.refused is None


def test_margins_in_words():
    near = Margin(Constraint.SEPARATION, (0, 2), 7.0, 812.4, 1000.0, -0.1876)
    assert near.text() == "separation of craft 1 and 3: 812.4 m, limit 1000 m, in 7 steps"
    wide = Margin(Constraint.ANGLE, (1, 2), 0.0, math.radians(70.0), math.radians(60.0), -1 / 6)
    assert "of sc2 and sc3: 70 deg, limit 60 deg, now" in wide.text(("sc1", "sc2", "sc3"))
    assert not near.is_kept
