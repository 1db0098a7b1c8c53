"""The nominal loop flown ahead: the same numbers as the flight, and each constraint by its name."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from kalabic_loop import BODY, EARTH, FEEDBACK, INERTIA, START, H, predictor
from strategies import inertias, rotations, vectors

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors.feedback import AttitudeFeedback
from spacecraft_gnc.governors.feedback_loop import FeedbackPredictor
from spacecraft_gnc.governors.reference_set import ReferenceSet
from spacecraft_gnc.loop import State
from spacecraft_gnc.scenario import load

FREE = ReferenceSet()
STEADY = math.radians(0.1)
CONFIG = Path(__file__).resolve().parents[2] / "config" / "kalabic2014_governor.yaml"


def flown(feedback, body, substeps, state, reference, n):
    """Fly ``n`` steps as the closed loop does; return states and torques."""
    states, torques = [state], []
    for k in range(n):
        torques.append(feedback.torque(states[-1], reference))
        after = body.step(*states[-1][1:], torques[-1], substeps)
        states.append(State(k + 1, *after))
    return states, torques


def size(vector):
    """Euclidean norm, summed as the kernels do."""
    x, y, z = (float(v) for v in vector)
    return math.sqrt(x * x + y * y + z * z)


@given(
    rotations(), rotations(), vectors(), inertias(), st.integers(1, 3), st.integers(1, 40),
    st.sampled_from([0.0, 0.02]),
)  # fmt: skip
def test_the_prediction_is_the_flight_to_the_last_bit(
    attitude, reference, momentum, J, substeps, n, saturation
):
    feedback = AttitudeFeedback(0.1 * J, 0.3, J, saturation)
    body = RigidBody(J, 0.1)
    state = State(0, attitude, 0.3 * momentum)
    states, torques = flown(feedback, body, substeps, state, reference, n)
    for kind, values in (("max_torque", torques), ("max_momentum", [s[2] for s in states[:n]])):
        tested = FeedbackPredictor(feedback, 0.1, substeps, FREE, **{kind: 10.0}, horizon=n)
        tested._problem[4][2] = 1e300  # the invariant set out of the way
        found = tested.predict(state, reference)
        assert found.admissible
        assert found.margin == 10.0 - max(size(v) for v in values)


@given(rotations(), vectors(0.4), st.floats(0.0, 0.01))
def test_the_first_violation_is_found_where_the_flight_has_it(attitude, momentum, reserve):
    state = State(0, attitude, momentum)
    references = ReferenceSet((EARTH,), STEADY, ("earth",))
    found = predictor(references, max_torque=0.2, horizon=60).predict(state, np.eye(3), reserve)
    states, torques = flown(FEEDBACK, BODY, 1, state, np.eye(3), 60)
    room = [
        {
            "torque limit": 0.2 * (1 - reserve) - size(torque),
            "earth": float(EARTH.margin(state.attitude)) - reserve,
            "invariant set": 0.98 * 0.6 * (1 - reserve) - FEEDBACK.lyapunov(state, np.eye(3)),
        }
        for state, torque in zip(states[:60], torques, strict=True)
    ]
    violated = [k for k, margins in enumerate(room) if min(margins.values()) < 0.0]
    assert found.admissible == (not violated)
    assert found.violation_step == (violated[0] if violated else -1)
    if violated:
        # near half a turn the angle keeps fewer digits
        assert found.margin == pytest.approx(room[violated[0]][found.constraint], abs=1e-10)
        assert found.margin < 0.0
    else:
        assert found.margin == pytest.approx(min(m[found.constraint] for m in room), abs=1e-12)


def test_each_constraint_is_called_by_its_name():
    fast = State(0, np.eye(3), np.array([0.0, 0.05, 0.0]))
    assert predictor(max_torque=0.009).predict(fast, np.eye(3))[2:] == ("torque limit", 0)
    found = predictor(max_torque=0.0, max_momentum=0.04).predict(fast, np.eye(3))
    assert found == (False, pytest.approx(-0.01), "momentum limit", 0)
    # Half a turn off about body z: W = 0.6.
    opposite = State(0, lie.exp(np.array([0.0, 0.0, 3.1])), np.zeros(3))
    found = predictor(max_torque=0.0).predict(opposite, np.eye(3))
    assert (found.constraint, found.violation_step) == ("invariant set", 0)
    assert found.margin == pytest.approx(0.98 * 0.6 - 0.3 * (1 - math.cos(3.1)))
    tilted = State(0, lie.exp(np.array([1.1, 0.0, 0.0])), np.zeros(3))
    found = predictor(max_torque=0.0).predict(tilted, np.eye(3))
    assert found == (False, pytest.approx(math.radians(60) - 1.1), "earth", 0)
    # (4) is far beyond the level of W of ordinary gains: 2 lambda_min(Jd) / h = 60 N m s.
    stiff = AttitudeFeedback(1e4, 0.2, INERTIA)
    tumbling = FeedbackPredictor(stiff, H, 1, FREE, horizon=5)
    found = tumbling.predict(State(0, np.eye(3), np.array([0.0, 0.0, 110.0])), np.eye(3))
    assert found[2:] == ("momentum condition (4)", 0)
    assert found.margin < 0.0
    # Too short to arrive: the tail set is asked for.
    short = predictor(max_torque=1.0)
    short.horizon = 20
    found = short.predict(State(0, lie.exp(np.array([0.0, 0.0, 2.0])), np.zeros(3)), np.eye(3))
    assert found[2:] == ("convergence", 19)
    assert -2.0 < found.margin < -1.5


def test_without_a_limit_in_reach_the_margin_belongs_to_the_invariant_set():
    found = predictor(FREE, max_torque=0.0).predict(State(0, np.eye(3), np.zeros(3)), np.eye(3))
    assert found == (True, pytest.approx(0.98 * 0.6), "invariant set", -1)


def test_a_state_that_is_none_is_not_admissible():
    nowhere = State(0, np.full((3, 3), np.nan), np.zeros(3))
    for tested in (predictor(), predictor(horizon=5), predictor(FREE, max_torque=0.0)):
        assert not tested.predict(nowhere, np.eye(3)).admissible
        assert not tested.predict(START, np.full((3, 3), np.nan)).admissible
    spinning = State(0, np.eye(3), np.array([0.0, np.nan, 0.0]))
    assert not predictor().predict(spinning, np.eye(3)).admissible


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"level": 0.6}, r"lyapunov_level: received 0.6; required a number less than 0.6 \[J\]"),
        ({"level": -0.1}, r"lyapunov_level: received -0.1"),
        ({"max_torque": -1.0}, "max_torque: received -1.0"),
        ({"max_momentum": math.inf}, "max_momentum: received inf"),
    ],
)
def test_bad_limits_are_refused(changes, said):
    with pytest.raises(ParameterError, match=said):
        predictor(**changes)


def test_a_loop_that_its_sampling_makes_unstable_is_refused():
    harsh = AttitudeFeedback(0.1, 40.0, INERTIA)
    with pytest.raises(ParameterError, match=r"spectral radius 2\..* required less than 1"):
        FeedbackPredictor(harsh, H, 1, FREE)


def test_the_body_flown_ahead_is_the_one_that_the_controller_believes():
    """The gains are given, so the belief changes the governor's prediction and not the law."""
    believed = {"nmpc_controller.inertia": (2.0 * INERTIA).ravel().tolist()}
    same = {"nmpc_controller.inertia": INERTIA.ravel().tolist()}
    short = {"plant.duration": 10.0}
    right, stated, wrong = (load(CONFIG, {**short, **c}).build() for c in ({}, same, believed))
    ahead = wrong.governor.predictor.loop.feedback
    assert np.array_equal(ahead.inertia, 2.0 * INERTIA)
    assert np.array_equal(ahead.law, right.governor.predictor.loop.feedback.law)
    assert np.array_equal(wrong.plant.inertia, INERTIA)
    flights = [loop.run() for loop in (right, stated, wrong)]
    assert np.array_equal(flights[0].reference, flights[1].reference)
    off = lie.angle_between(flights[0].reference[-1], flights[2].reference[-1])
    assert off > math.radians(1.0)


def test_the_guarantee_holds_as_far_as_the_belief_does():
    """A momentum limit that the believed body keeps is exceeded by a heavier one."""
    limit = {"reference_governor.max_momentum": 0.1, "reference_governor.max_torque": 0.0}
    believed = {"nmpc_controller.inertia": (0.5 * INERTIA).ravel().tolist()}
    kept, exceeded = (
        float(np.linalg.norm(load(CONFIG, {**limit, **c}).build().run().momentum, axis=1).max())
        for c in ({}, believed)
    )
    assert kept <= 0.1
    assert exceeded > 0.12
