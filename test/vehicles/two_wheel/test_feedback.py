"""The feedback law: its equation, its linear loop, convergence from anywhere, refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from independent import vee
from strategies import inertias, rotations, vectors
from wheeled import AFRL_ACCELERATION, AFRL_SPEED, ORTHOGONAL, PYRAMID, afrl, small

from spacecraft_gnc import lie
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.vehicles.two_wheel.controllers.feedback.law import WheelFeedback
from spacecraft_gnc.vehicles.two_wheel.dynamics import Gyrostat
from spacecraft_gnc.vehicles.two_wheel.metrics import summarize

TARGET = lie.exp(np.array([0.4, -0.8, 1.2]))
THREE_LEFT = np.array([True, True, False, True])


def fly(gyrostat, law, state, n_steps, substeps=1):
    """Return the arguments of `summarize` up to the target."""
    states, commands = [state], []
    for _ in range(n_steps):
        commands.append(law.acceleration(state, TARGET))
        state = gyrostat.step(state, commands[-1], substeps)
        states.append(state)
    _, attitudes, rates, speeds, *_ = map(np.array, zip(*states, strict=True))
    times = gyrostat.time_step * substeps * np.arange(n_steps + 1)
    return times, attitudes, rates, speeds, np.array(commands)


def at_rest(gyrostat, error, speeds=None):
    """A start at rest, off the target by a rotation vector."""
    speeds = np.zeros(gyrostat.n_wheels) if speeds is None else speeds
    return gyrostat.state_from_rate(TARGET @ lie.exp(error), np.zeros(3), speeds)


@given(rotations(), vectors(1.0), vectors(20.0), inertias())
def test_the_bus_gets_the_torque_of_the_law(attitude, rate, speeds, inertia):
    """J omega' = -2 zeta w J omega - e, with omega' from the equations of motion."""
    gyrostat = Gyrostat(inertia, PYRAMID[:, :3], np.full(3, 0.01), 0.1)
    state = gyrostat.state_from_rate(attitude, rate, speeds)
    u = WheelFeedback(gyrostat, 0.3, 0.7).acceleration(state, TARGET)
    wheels = gyrostat.wheel_axes * gyrostat.wheel_inertias
    reaction = -np.cross(rate, inertia @ rate + wheels @ speeds) - wheels @ u
    A, E = 0.09 * (0.5 * np.trace(inertia) * np.eye(3) - inertia), TARGET.T @ attitude
    expected = -2.0 * 0.7 * 0.3 * inertia @ rate - 2.0 * vee(A @ E)
    assert np.abs(reaction - expected).max() < 1e-13


@pytest.mark.parametrize("axes", [ORTHOGONAL, PYRAMID], ids=["three", "pyramid"])
def test_near_the_target_every_axis_is_critically_damped(axes):
    w, error, stored = 0.2, np.array([1e-3, -2e-3, 3e-3]), 80.0 * np.ones(axes.shape[1])
    gyrostat = small(axes, 0.01)
    start = at_rest(gyrostat, error, stored)
    assert np.linalg.norm(start.total_momentum) > 1.0  # the law cancels it
    times, attitudes, *_ = fly(gyrostat, WheelFeedback(gyrostat, w), start, 2000)
    found = np.array([lie.log(TARGET.T @ attitude) for attitude in attitudes[::100]])
    decay = (1.0 + w * times[::100]) * np.exp(-w * times[::100])
    # The command is held over the period: it comes late by half of it.
    assert np.abs(found - np.outer(decay, error)).max() < 2e-3 * np.linalg.norm(error)


def errors(rng, n):
    """Rotation vectors: random rotations, and half turns to within 1e-3 and 1e-6."""
    random = [lie.log(lie.from_quaternion_xyzw(rng.normal(size=4))) for _ in range(n)]
    axes = [*np.eye(3), *rng.normal(size=(3, 3))]
    short = [(math.pi - off) * axis / np.linalg.norm(axis) for off in (1e-3, 1e-6) for axis in axes]
    return random + short


CASES = {
    "three": (ORTHOGONAL, {}, None),
    "pyramid": (PYRAMID, {}, None),
    "pyramid, one wheel lost": (PYRAMID, {}, THREE_LEFT),
    "saturated": (ORTHOGONAL, {"max_acceleration": 0.5}, None),
    "saturated, slow wheels": (PYRAMID, {"max_acceleration": 0.5, "max_speed": 4.0}, None),
}


@pytest.mark.parametrize(("axes", "limits", "healthy"), CASES.values(), ids=CASES)
def test_it_turns_from_anywhere_to_the_target(axes, limits, healthy):
    gyrostat = small(axes, 0.25, **limits)
    law = WheelFeedback(gyrostat, 0.2, healthy=healthy)
    for error in errors(np.random.default_rng(4), 12):
        flight = fly(gyrostat, law, at_rest(gyrostat, error), 500, 2)
        found = summarize(*flight, TARGET)
        assert found["settle_time"] is not None, error
        assert found["final_error_deg"] < 1e-3
        for name, limit in limits.items():
            assert found[name.replace("max_", "max_wheel_")] <= limit * (1.0 + 1e-15)
        if healthy is not None:
            assert not flight[3][:, ~healthy].any()


def test_the_limits_of_the_last_two_cases_act():
    gyrostat = small(PYRAMID, 0.25, max_acceleration=0.5, max_speed=4.0)
    found = summarize(
        *fly(gyrostat, WheelFeedback(gyrostat, 0.2), at_rest(gyrostat, [1.5, 1.0, -1.0]), 500, 2),
        TARGET,
    )
    assert found["max_wheel_acceleration"] == pytest.approx(0.5, rel=1e-15)
    assert found["max_wheel_speed"] == 4.0


def test_the_reports_spacecraft_with_a_third_wheel():
    """From (0.5, 0.3, -0.4) rad; the two-wheel controller of the report takes some 550 s."""
    gyrostat = afrl(ORTHOGONAL)
    start = at_rest(gyrostat, [0.5, 0.3, -0.4])
    found = summarize(*fly(gyrostat, WheelFeedback(gyrostat, 0.012), start, 100, 10), TARGET)
    assert found["settle_time"] == pytest.approx(530.0, abs=30.0)
    assert found["max_wheel_acceleration"] < AFRL_ACCELERATION
    assert found["max_wheel_speed"] < AFRL_SPEED


@given(rotations(), vectors(1.0))
def test_at_the_limit_the_direction_of_the_torque_stays(attitude, rate):
    free, limited = small(PYRAMID, 0.1), small(PYRAMID, 0.1, max_acceleration=0.5)
    state = free.state_from_rate(attitude, rate, np.zeros(4))
    wanted = WheelFeedback(free, 0.3).acceleration(state, TARGET)
    given_ = WheelFeedback(limited, 0.3).acceleration(state, TARGET)
    size = np.abs(wanted).max()
    assert np.abs(given_ * max(size, 0.5) - wanted * 0.5).max() < 1e-13 * max(size, 1.0)


@given(rotations(), vectors(0.05))
def test_in_short_steps_the_lyapunov_function_falls(attitude, rate):
    gyrostat = small(ORTHOGONAL, 1e-4)
    law = WheelFeedback(gyrostat, 0.3)
    state = gyrostat.state_from_rate(attitude, rate, [50.0, -20.0, 10.0])

    def level(state):
        own = gyrostat.inertia @ state.angular_velocity
        nonstandard = 0.5 * np.trace(gyrostat.inertia) * np.eye(3) - gyrostat.inertia
        off = np.eye(3) - TARGET.T @ state.attitude
        return 0.5 * own @ state.angular_velocity + 0.09 * np.trace(nonstandard @ off)

    after = gyrostat.step(state, law.acceleration(state, TARGET))
    fall = 1e-4 * 0.6 * rate @ gyrostat.inertia @ rate
    assert level(state) - level(after) == pytest.approx(fall, abs=2e-9)  # of order h^2


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"gyrostat": small(np.eye(3)[:, :2], 0.1)}, r"2 healthy wheel\(s\) .* span 2 dim"),
        ({"gyrostat": small(np.ones((3, 4)), 0.1)}, "span 1 dimension"),
        ({"healthy": [True, True, False]}, "span 2 dimension.*; add a wheel, or use"),
        ({"healthy": [False] * 3}, r"0 healthy wheel\(s\)"),
        ({"healthy": [True, True]}, "healthy: .* required 3 bools"),
        ({"healthy": [1, 1, 1]}, "healthy: .* required 3 bools"),
        ({"gyrostat": 1.0}, "gyrostat: received 1.0"),
        ({"bandwidth": 0.0}, "bandwidth: received 0.0"),
        ({"damping_ratio": -1.0}, "damping_ratio: received -1.0"),
    ],
)
def test_what_cannot_point_the_spacecraft_is_refused(changes, words):
    with pytest.raises(GncError, match=words) as caught:
        WheelFeedback(**({"gyrostat": small(ORTHOGONAL, 0.1), "bandwidth": 0.2} | changes))
    assert "\n" not in str(caught.value)
