"""Governors whose reference moves: interpolation, torque, refusals, and who follows them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import vectors

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.governors._rotation_spline import RotationSpline
from spacecraft_gnc.governors.feedback import AttitudeFeedback
from spacecraft_gnc.governors.moving import StoredTrajectory, TurningReference
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.ocp import AttitudeOcp, NeighboringExtremal, ShootingSolver, Weights
from spacecraft_gnc.types import State
from spacecraft_gnc.vehicles.rigid_body.controllers.feedback.controller import FeedbackController
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import (
    OnlineNeighboringController,
    ShootingController,
)

J = np.array([[1.0, 0.05, -0.1], [0.05, 0.8, 0.02], [-0.1, 0.02, 0.9]])
PERIOD = 0.4
OMEGA = np.array([0.05, 0.1, -0.07])  # 7.6 deg/s, about no principal axis
WEIGHTS = Weights(1.0, 0.01, 1.0, 1.0, 0.01)
NOWHERE = State(0, np.eye(3), np.zeros(3))
LARGEST = 0.01  # [deg] after settling


def swing(time, period=100.0, size=0.4):
    """A smooth motion about two axes that never repeats within a test."""
    first = size * math.sin(2.0 * math.pi * time / period) * np.array([1.0, 0.0, 0.0])
    second = size * math.sin(2.0 * math.pi * time / (1.7 * period)) * np.array([0.14, 0.35, 0.7])
    return lie.exp(first) @ lie.exp(second)


def rate_of(attitude, time, step=1e-4):
    return lie.log(attitude(time - step).T @ attitude(time + step)) / (2.0 * step)


def table(spacing=1.0, duration=300.0, motion=swing):
    times = np.arange(0.0, duration, spacing)
    return (
        times,
        np.array([motion(time) for time in times]),
        np.array([rate_of(motion, time) for time in times]),
    )


def at(step):
    return NOWHERE._replace(step=step)


def errors(controller, governor, n, substeps=1):
    """Angles [deg] from the reference at each step, from rest at the identity; the sources."""
    body, state, found, sources = RigidBody(J, PERIOD / substeps), NOWHERE, [], set()
    for k in range(n):
        reference = governor.decide(state).reference
        found.append(math.degrees(lie.angle_between(state.attitude, reference.attitude)))
        command = controller.command(state, reference)
        sources.add(command.source)
        state = State(k + 1, *body.step(*state[1:], command.control, substeps))
    return np.array(found), sources


@settings(max_examples=40)
@given(vectors(1.0), vectors(0.3), vectors(0.1), vectors(0.02), st.floats(0.01, 0.99))
def test_the_spline_meets_its_rows_and_its_rate_is_that_of_its_attitude(start, w0, dw, miss, s):
    span = 2.0
    ends = (
        lie.exp(start),
        lie.exp(start) @ lie.exp(span * (w0 + 0.5 * dw + miss * np.linalg.norm(w0))),
    )
    spline = RotationSpline([0.0, span], ends, [w0, w0 + dw])
    for i, time in enumerate((0.0, span)):
        assert lie.angle_between(spline.attitude(time), ends[i]) < 1e-13
        assert np.abs(spline.motion(time - 1e-13 * i)[0] - (w0, w0 + dw)[i]).max() < 1e-11
    time, step = s * span, 1e-4
    rate, acceleration = spline.motion(time)
    assert np.abs(rate_of(spline.attitude, time, step) - rate).max() < 1e-8
    difference = (spline.motion(time + step)[0] - spline.motion(time - step)[0]) / (2.0 * step)
    assert np.abs(difference - acceleration).max() < 1e-7


def test_the_spline_converges_with_the_fourth_power_of_the_spacing():
    off = []
    for spacing in (8.0, 4.0, 2.0):
        spline = RotationSpline(*table(spacing))
        times = np.linspace(10.0, 200.0, 301)
        off.append(max(lie.angle_between(spline.attitude(t), swing(t)) for t in times))
    assert 13.0 < off[0] / off[1] < 19.0
    assert 13.0 < off[1] / off[2] < 19.0
    assert off[2] < 1e-6


def test_a_turn_has_the_rate_and_the_torque_of_its_body():
    governor = TurningReference(swing(20.0), OMEGA, J, PERIOD)
    for k in (0, 1, 1000):
        decision = governor.decide(at(k))
        attitude, rate, torque = decision.reference
        assert lie.angle_between(attitude, swing(20.0) @ lie.exp(k * PERIOD * OMEGA)) < 1e-12
        assert np.array_equal(rate, OMEGA)
        assert np.allclose(torque, np.cross(OMEGA, J @ OMEGA), rtol=1e-14)
        assert np.array_equal(governor.target, attitude)
        assert decision.admissible
        assert (decision.alpha, decision.margin) == (1.0, math.inf)


def test_a_turn_goes_on_from_a_new_target_and_starts_again_after_a_reset():
    governor = TurningReference(np.eye(3), OMEGA, J, PERIOD)
    governor.set_target(swing(3.0))
    governor.decide(at(7))
    ahead = governor.decide(at(9)).reference.attitude
    assert lie.angle_between(ahead, swing(3.0) @ lie.exp(2 * PERIOD * OMEGA)) < 1e-14
    governor.reset()
    again = governor.decide(at(9)).reference.attitude
    fresh = TurningReference(np.eye(3), OMEGA, J, PERIOD).decide(at(9)).reference.attitude
    assert again.tobytes() == fresh.tobytes()


def test_a_trajectory_has_the_torque_that_its_motion_needs():
    governor = StoredTrajectory(*table(), J, PERIOD)
    for k in (0, 33, 500):
        time, middle = k * PERIOD, (k + 0.5) * PERIOD
        attitude, rate, torque = governor.decide(at(k)).reference
        assert lie.angle_between(attitude, swing(time)) < 1e-7
        assert np.abs(rate - rate_of(swing, time)).max() < 1e-6
        step = 0.05
        ends = rate_of(swing, middle + step), rate_of(swing, middle - step)
        turning, acceleration = rate_of(swing, middle), (ends[0] - ends[1]) / (2.0 * step)
        expected = J @ acceleration + np.cross(turning, J @ turning)
        assert np.abs(torque - expected).max() < 2e-3 * np.abs(expected).max() + 1e-6


def test_a_trajectory_takes_the_torques_that_it_is_given():
    torques = np.outer(np.arange(300.0), [1e-4, -2e-4, 3e-4])
    governor = StoredTrajectory(*table(), J, PERIOD, torques)
    torque = governor.decide(at(10)).reference.torque
    assert np.allclose(torque, 4.2 * np.array([1e-4, -2e-4, 3e-4]), rtol=1e-12)


def test_after_its_end_a_trajectory_goes_on_at_the_last_rate():
    times, attitudes, rates = table(1.0, 20.0)
    for last in (rates[-1], np.zeros(3)):
        rates[-1] = last
        attitudes[-1] = attitudes[-2] @ lie.exp(0.5 * (rates[-2] + last))
        reference = StoredTrajectory(times, attitudes, rates, J, PERIOD).decide(at(100)).reference
        expected = attitudes[-1] @ lie.exp((100 * PERIOD - times[-1]) * last)
        assert lie.angle_between(reference.attitude, expected) < 1e-12
        assert np.array_equal(reference.angular_velocity, last)
        assert np.allclose(reference.torque, np.cross(last, J @ last), atol=1e-18)


def test_a_trajectory_is_the_same_whenever_it_is_asked():
    governor, again = (StoredTrajectory(*table(), J, PERIOD) for _ in range(2))
    for k in range(5):
        governor.decide(at(k))
    first, second = governor.decide(at(7)).reference, again.decide(at(7)).reference
    assert all(a.tobytes() == b.tobytes() for a, b in zip(first, second, strict=True))
    assert np.array_equal(governor.target, first.attitude)
    governor.reset()
    assert np.array_equal(governor.target, np.eye(3))
    with pytest.raises(ParameterError, match="target: received an attitude; required none"):
        governor.set_target(np.eye(3))


TIMES, ATTITUDES, RATES = table(1.0, 10.0)


def changed(array, row, value):
    other = array.copy()
    other[row] = value
    return other


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"times": TIMES[:1]}, ShapeError, "times.*n >= 2"),
        ({"times": TIMES + 1.0}, ParameterError, "times: received 1 s in row 0.*start at 0"),
        ({"times": changed(TIMES, 4, 3.0)}, ParameterError, "received 3 s in row 4.*increase"),
        ({"times": changed(TIMES, 4, np.nan)}, ParameterError, "times: received nan s in row 4"),
        ({"attitudes": ATTITUDES[:-1]}, ShapeError, r"attitudes.*required \(10, 3, 3\)"),
        ({"attitudes": changed(ATTITUDES, 3, 2.0 * np.eye(3))}, ParameterError, r"attitudes\[3\]"),
        (
            {"attitudes": changed(ATTITUDES, 3, lie.exp(np.array([0.0, 3.0, 0.0])))},
            ParameterError, "attitudes: received rows 2 and 3 that are .* deg apart",
        ),
        ({"angular_velocities": RATES[:-1]}, ShapeError, "angular_velocities"),
        ({"angular_velocities": np.degrees(RATES)}, ParameterError, "angular_velocities.*rad/s"),
        ({"angular_velocities": -RATES}, ParameterError, "angular_velocities.*own frame"),
        ({"angular_velocities": changed(RATES, 2, np.inf)}, ParameterError, "angular_velocities"),
        ({"torques": np.zeros((4, 3))}, ShapeError, "torques"),
        ({"inertia": -J}, ParameterError, "inertia"),
        ({"period": 0.0}, ParameterError, "period"),
        ({"plant_step": -1.0}, ParameterError, "plant_step"),
    ],
)  # fmt: skip
def test_a_table_that_is_none_is_refused(change, error, words):
    good = {
        "times": TIMES, "attitudes": ATTITUDES, "angular_velocities": RATES, "inertia": J,
        "period": PERIOD,
    }  # fmt: skip
    StoredTrajectory(**good)
    with pytest.raises(error, match=words) as caught:
        StoredTrajectory(**good | change)
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"attitude": np.ones((3, 3))}, "attitude"),
        ({"angular_velocity": [0.0, math.nan, 0.0]}, "angular_velocity"),
        ({"inertia": np.diag([1.0, 0.1, 0.1])}, "inertia"),
        ({"period": -1.0}, "period"),
    ],
)
def test_a_turn_that_is_none_is_refused(change, words):
    good = {"attitude": np.eye(3), "angular_velocity": OMEGA, "inertia": J, "period": PERIOD}
    with pytest.raises(ParameterError, match=words):
        TurningReference(**good | change)


def nmpc(substeps):
    ocp = AttitudeOcp(J, PERIOD, 10, WEIGHTS, max_torque=0.1, plant_step=PERIOD / substeps)
    return ShootingController(ShootingSolver(ocp))


def neighboring(substeps):
    ocp = AttitudeOcp(J, PERIOD, 10, WEIGHTS, max_torque=0.1, plant_step=PERIOD / substeps)
    return OnlineNeighboringController(NeighboringExtremal(ocp))


def feedback(substeps):
    return FeedbackController(AttitudeFeedback(0.1 * J, 1.0, J, 0.1, PERIOD / substeps), PERIOD)


@pytest.mark.parametrize("make", [nmpc, neighboring, feedback])
@pytest.mark.parametrize("substeps", [1, 8])
def test_a_turn_about_no_principal_axis_is_tracked_without_lag(make, substeps):
    off, sources = errors(
        make(substeps), TurningReference(np.eye(3), OMEGA, J, PERIOD), 400, substeps
    )
    assert off[:20].max() > 1.0  # from rest
    assert off[300:].max() < 1e-6
    assert not any(Source(source).is_fallback for source in sources)


@pytest.mark.parametrize("make", [nmpc, neighboring, feedback])
@pytest.mark.parametrize("substeps", [1, 8])
def test_a_stored_trajectory_is_tracked_without_lag(make, substeps):
    governor = StoredTrajectory(*table(), J, PERIOD, plant_step=PERIOD / substeps)
    off, sources = errors(make(substeps), governor, 700, substeps)
    assert off[:20].max() > 0.1  # from rest
    assert off[300:].max() < LARGEST
    assert not any(Source(source).is_fallback for source in sources)


def test_without_its_feedforward_the_same_trajectory_lags():
    class Bare(StoredTrajectory):
        def decide(self, state):
            decision = super().decide(state)
            still = decision.reference._replace(angular_velocity=np.zeros(3), torque=np.zeros(3))
            return decision._replace(reference=still)

    off, _ = errors(nmpc(1), Bare(*table(), J, PERIOD), 700)
    assert off[300:].max() > 100.0 * LARGEST
