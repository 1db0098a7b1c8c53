"""The integrator against its equation, conservation laws and a high-order method."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from strategies import inertias, rotations, unit_vectors, vectors

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.solvability import largest_step

FULL_INERTIA = np.array([[1.0, 0.05, -0.1], [0.05, 0.8, 0.02], [-0.1, 0.02, 0.9]])
MOMENTUM = np.array([0.3, -0.5, 0.8])
ZERO = np.zeros(3)


@given(inertias(), rotations(), unit_vectors(), st.floats(0.001, 0.999))
def test_a_step_satisfies_the_implicit_equation_up_to_the_limit(inertia, attitude, axis, share):
    body = RigidBody(inertia, 0.1)
    momentum = axis * (share * largest_step(inertia, axis) / 0.1)
    after, rotated = body.step(attitude, momentum, ZERO)
    turn = attitude.T @ after
    nonstandard = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    left, right = 0.1 * lie.hat(momentum), turn @ nonstandard - nonstandard @ turn.T
    assert np.abs(left - right).max() < 1e-14 * max(1.0, np.abs(left).max())
    assert np.abs(rotated - turn.T @ momentum).max() < 1e-14 * max(1.0, np.abs(momentum).max())


@given(inertias(), unit_vectors())
def test_solvability_ends_exactly_where_kalabic_3_says(inertia, axis):
    body = RigidBody(inertia, 0.1)
    limit = largest_step(inertia, axis) / 0.1
    nonstandard = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    for share, exists in ((1.0 - 1e-9, True), (1.0 + 1e-9, False)):
        momentum = axis * limit * share
        matrix = 0.01 * lie.hat(momentum) @ lie.hat(momentum) + 4.0 * nonstandard @ nonstandard
        assert (np.linalg.eigvalsh(matrix)[0] >= 0.0) == exists
        assert body.is_solvable(momentum) == exists


def test_a_momentum_that_grows_beyond_the_limit_inside_a_flight_is_refused():
    body = RigidBody(np.diag([1.0, 0.8, 0.8]), 0.4)
    with pytest.raises(ParameterError, match="at step"):
        body.simulate(np.eye(3), ZERO, np.array([0.0, 1.0, 0.0]), 100)
    with pytest.raises(ParameterError, match="Kalabic"):
        body.step(np.eye(3), ZERO, np.array([0.0, 1.0, 0.0]), n_steps=100)


def test_free_motion_keeps_its_invariants_over_a_million_steps():
    body = RigidBody(FULL_INERTIA, 0.01)
    attitudes, momenta = body.simulate(lie.exp([0.3, 0.2, 0.1]), MOMENTUM, ZERO, 1_000_000)
    inertial = np.einsum("nij,nj->ni", attitudes, momenta)
    drift = np.abs(inertial - inertial[0]).max() / np.linalg.norm(MOMENTUM)
    assert drift < 1e-12
    gram = np.einsum("nji,njk->nik", attitudes, attitudes)
    assert np.abs(gram - np.eye(3)).max() < 1e-12
    energy = 0.5 * np.einsum("ni,ni->n", momenta, momenta @ np.linalg.inv(FULL_INERTIA))
    # The discrete free body keeps the energy itself (Moser and Veselov): no drift, no oscillation.
    assert np.abs(energy / energy[0] - 1.0).max() < 1e-12


@settings(max_examples=25)
@given(inertias(), rotations(), vectors(0.5))
def test_free_motion_keeps_its_invariants_for_any_body(inertia, attitude, momentum):
    body = RigidBody(inertia, 0.05)
    attitudes, momenta = body.simulate(attitude, momentum, ZERO, 200)
    inertial = np.einsum("nij,nj->ni", attitudes, momenta)
    assert np.abs(inertial - inertial[0]).max() < 1e-14
    assert abs(body.kinetic_energy(momenta[-1]) - body.kinetic_energy(momenta[0])) < 1e-14


def continuous(inertia, attitude, momentum, torque, duration):
    """DOP853 on R' = R hat(omega), Pi' = Pi x omega + u."""
    inverse = np.linalg.inv(inertia)

    def rate(_, x):
        rotation, p = x[:9].reshape(3, 3), x[9:]
        omega = inverse @ p
        return np.concatenate([(rotation @ lie.hat(omega)).ravel(), np.cross(p, omega) + torque])

    start = np.concatenate([attitude.ravel(), momentum])
    end = solve_ivp(rate, (0.0, duration), start, method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    return end[:9].reshape(3, 3), end[9:]


def orders(torque, kick):
    """Orders of the error in attitude and momentum over 4 s, as the step is halved.

    ``kick`` is the share of one step's impulse that is moved from the end to the start.
    """
    start = lie.exp([0.25, 0.5, 0.5])
    expected, expected_momentum = continuous(FULL_INERTIA, start, MOMENTUM, torque, 4.0)
    errors = []
    for n in (400, 800, 1600, 3200):
        impulse = kick * 4.0 / n * torque
        body = RigidBody(FULL_INERTIA, 4.0 / n)
        rotation, momentum = body.step(start, MOMENTUM + impulse, torque, n)
        off = np.linalg.norm(momentum - impulse - expected_momentum)
        errors.append([lie.angle_between(rotation, expected), off])
    assert max(errors[-1]) < 2e-4  # to the continuous motion, not to another
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


def test_free_motion_is_of_second_order():
    assert np.all(np.abs(orders(ZERO, 0.0) - 2.0) < 0.05)


TORQUE = np.array([0.05, -0.02, 0.03])


def test_a_held_torque_is_of_first_order():
    """Its impulse comes at the end of each step; half of it moved ahead restores the second."""
    found = orders(TORQUE, 0.0)
    assert np.all(found < 1.0 + 0.05)
    assert np.all(np.abs(found[-1] - 1.0) < 0.05)
    assert np.all(np.abs(orders(TORQUE, 0.5) - 2.0) < 0.05)


def test_spin_about_a_principal_axis_is_exact_in_closed_form():
    body = RigidBody(np.diag([1.0, 0.8, 0.6]), 0.5)
    momentum = np.array([0.0, 0.0, 0.3])
    rotation, after = body.step(np.eye(3), momentum, ZERO)
    # h Pi = J3 sin(theta) for a turn theta about the third axis.
    assert np.abs(rotation - lie.exp([0.0, 0.0, math.asin(0.5 * 0.3 / 0.6)])).max() < 1e-15
    assert after == pytest.approx(momentum, abs=1e-16)


@pytest.mark.parametrize(
    ("inertia", "words"),
    [
        (np.diag([1.0, 0.8, -0.1]), "positive definite"),
        (np.diag([2.0, 0.5, 0.5]), "triangle inequality"),
        (np.array([[1.0, 0.1, 0.0], [0.0, 0.8, 0.0], [0.0, 0.0, 0.8]]), "symmetric"),
        (np.diag([1.0, math.nan, 0.8]), "finite"),
    ],
)
def test_matrices_that_are_no_inertia_are_refused(inertia, words):
    with pytest.raises(ParameterError, match=words):
        RigidBody(inertia, 0.1)


def test_shapes_and_time_steps_are_checked():
    with pytest.raises(ShapeError, match="3x3"):
        RigidBody(np.eye(4), 0.1)
    for step in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(ParameterError, match="time_step"):
            RigidBody(np.eye(3), step)
    body = RigidBody(np.eye(3), 0.1)
    with pytest.raises(ParameterError, match="torques"):
        body.simulate(np.eye(3), ZERO, np.zeros((4, 3)), 5)
    with pytest.raises(ParameterError, match="attitude"):
        body.simulate(1.1 * np.eye(3), ZERO, ZERO, 5)
