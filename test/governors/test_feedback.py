"""The nominal controller of Kalabic (8)-(10): law, Lyapunov function, levels, refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from kalabic_loop import BODY, FEEDBACK, INERTIA, H
from strategies import inertias, rotations, vectors, weights

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors.feedback import AttitudeFeedback
from spacecraft_gnc.loop import State

HOME = np.eye(3)
GUPTA = np.diag([1.0, 0.8, 0.8])


@given(rotations(), rotations(), vectors(), inertias(), weights(0.1), weights(0.1))
def test_law_and_lyapunov_function_are_those_of_the_paper(attitude, reference, momentum, J, A, K):
    law = AttitudeFeedback(A, K, J)
    state = State(0, attitude, momentum)
    E = reference.T @ attitude
    e_hat = A @ E - E.T @ A
    e = np.array([e_hat[2, 1], e_hat[0, 2], e_hat[1, 0]])
    assert np.abs(law.torque(state, reference) - (-K @ momentum - e)).max() < 1e-13
    W = 0.5 * momentum @ np.linalg.solve(J, momentum) + np.trace(A @ (np.eye(3) - E))
    assert law.lyapunov(state, reference) == pytest.approx(W, abs=1e-12)


@given(rotations(), vectors())
def test_the_torque_of_the_error_is_the_gradient_of_the_potential(attitude, direction):
    step = 1e-5
    ahead, behind = (
        FEEDBACK.lyapunov(State(0, attitude @ lie.exp(s * direction), np.zeros(3)), HOME)
        for s in (step, -step)
    )
    torque = FEEDBACK.torque(State(0, attitude, np.zeros(3)), HOME)
    assert (ahead - behind) / (2.0 * step) == pytest.approx(-torque @ direction, abs=1e-9)


def test_the_unstable_equilibria_lie_half_a_turn_off_and_the_lowest_at_0_6():
    assert FEEDBACK.unstable_level == pytest.approx(0.6)
    levels = []
    for axis in np.eye(3):
        state = State(0, lie.exp(math.pi * axis), np.zeros(3))
        assert np.abs(FEEDBACK.torque(state, HOME)).max() < 1e-15
        levels.append(FEEDBACK.lyapunov(state, HOME))
    assert levels == pytest.approx([1.0, 0.8, 0.6])


@given(rotations(), weights(0.1))
def test_levels_do_not_depend_on_the_axes(axes, A):
    turned = axes @ A @ axes.T
    law = AttitudeFeedback(A, 0.2, INERTIA)
    other = AttitudeFeedback(0.5 * (turned + turned.T), 0.2, INERTIA)
    assert other.unstable_level == pytest.approx(law.unstable_level, rel=1e-12)


@given(rotations())
def test_from_rest_the_lyapunov_function_first_grows(attitude):
    """h^2 e . J^-1 e / 2 to leading order: the set {W <= level} is not invariant as it stands."""
    state = State(0, attitude, np.zeros(3))
    torque = FEEDBACK.torque(state, HOME)
    after = State(1, *BODY.step(*state[1:], torque))
    growth = FEEDBACK.lyapunov(after, HOME) - FEEDBACK.lyapunov(state, HOME)
    assert growth == pytest.approx(
        0.5 * H**2 * torque @ np.linalg.solve(INERTIA, torque), abs=1e-15
    )


@given(rotations(), vectors(0.5))
def test_in_short_steps_it_falls_after_the_first_one(attitude, momentum):
    """The damping takes h Omega . K J Omega a step; the sampling adds terms of order h^2."""
    body = RigidBody(INERTIA, 1e-4)
    state = State(0, attitude, momentum)
    torque = FEEDBACK.torque(state, HOME)
    after = State(1, *body.step(attitude, momentum, torque))
    rate = np.linalg.solve(INERTIA, momentum)
    fall = FEEDBACK.lyapunov(state, HOME) - FEEDBACK.lyapunov(after, HOME)
    assert fall == pytest.approx(1e-4 * rate @ (0.2 * momentum), abs=2e-8)


def test_the_default_gains_are_critically_damped():
    law = AttitudeFeedback.critically_damped(GUPTA, 0.4, 0.01)
    assert np.allclose(law.attitude_gain, 0.5 * 0.125**2 * GUPTA)
    assert np.allclose(law.momentum_gain, 0.25 * np.eye(3))


def test_it_respects_its_limit_and_points_home():
    law = AttitudeFeedback.critically_damped(GUPTA, 0.4, 0.01)
    state = State(0, lie.exp(np.array([0.25, 0.5, 0.5])), np.zeros(3))
    torque = law.torque(state, HOME)
    assert np.linalg.norm(torque) <= 0.01 * (1 + 1e-12)
    assert torque @ np.array([0.25, 0.5, 0.5]) < 0.0
    assert law.torque(State(0, HOME, np.zeros(3)), HOME) == pytest.approx(np.zeros(3))


def test_alone_it_brings_the_spacecraft_home():
    law, body = AttitudeFeedback.critically_damped(GUPTA, 0.4, 0.01), RigidBody(GUPTA, 0.4)
    state = State(0, lie.exp(np.array([0.25, 0.5, 0.5])), np.zeros(3))
    for k in range(1000):
        state = State(k + 1, *body.step(*state[1:], law.torque(state, HOME)))
    assert lie.angle_between(state.attitude, HOME) < 1e-3
    assert np.linalg.norm(state.momentum) < 1e-4


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"attitude_gain": np.diag([0.1, 0.2, 0.0])}, "attitude_gain: .* eigenvalue 0; required"),
        ({"attitude_gain": np.diag([0.1, 0.2, -0.1])}, "attitude_gain: .* eigenvalue -0.1"),
        ({"momentum_gain": -0.2}, "momentum_gain: .* eigenvalue -0.2; required a positive"),
        ({"inertia": np.diag([1.0, 1.0, 3.0])}, r"inertia: .*\(triangle"),
        ({"max_torque": -1.0}, "max_torque: received -1.0"),
    ],
)
def test_what_cannot_stabilise_is_refused(changes, said):
    arguments = {"attitude_gain": 0.1, "momentum_gain": 0.2, "inertia": INERTIA} | changes
    with pytest.raises(ParameterError, match=said):
        AttitudeFeedback(**arguments)
