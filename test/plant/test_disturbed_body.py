"""A rigid body under disturbances: bookkeeping of momentum, accuracy, and bits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from strategies import inertias, rotations, vectors

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.plant.disturbances.constant import ConstantTorque
from spacecraft_gnc.plant.disturbances.gravity_gradient import GravityGradient
from spacecraft_gnc.plant.disturbances.noise import NoiseTorque
from spacecraft_gnc.plant.disturbances.push import Push
from spacecraft_gnc.plant.disturbances.torques import Disturbances, Motion
from spacecraft_gnc.scenario import load
from spacecraft_gnc.vehicles.rigid_body.plant import RigidBodyPlant

INERTIA = np.array([[1.0, 0.05, -0.1], [0.05, 0.8, 0.02], [-0.1, 0.02, 0.9]])
START = lie.exp([0.25, 0.5, 0.5])
MOMENTUM = np.array([0.06, -0.1, 0.16])
ZERO = np.zeros(3)


def disturbances(inertia=INERTIA, rate=0.2):
    return Disturbances(
        {
            "constant": ConstantTorque([1e-3, -2e-3, 5e-4]),
            "gravity_gradient": GravityGradient(inertia, rate, [0.1, 0.3, 1.0], [3.0, -1.0, 0.0]),
            "noise": NoiseTorque([1e-3, 1e-3, 2e-3], 7, 1),
        }
    )


def plant(substeps=1, parts=None, momentum=MOMENTUM, period=0.4):
    return RigidBodyPlant(
        RigidBody(INERTIA, period / substeps), START, momentum, 60, substeps, parts
    )


def torques(n):
    return 0.02 * np.random.default_rng(4).normal(size=(n, 3))


@pytest.mark.parametrize("substeps", [1, 3])
def test_without_disturbances_no_bit_changes(substeps):
    flown, body = plant(substeps, Disturbances()), RigidBody(INERTIA, 0.4 / substeps)
    attitude, momentum = START, MOMENTUM
    for u in torques(60):
        attitude, momentum = body.step(attitude, momentum, u, substeps)
        state = flown.step(u)
        assert (state.attitude == attitude).all()
        assert (state.momentum == momentum).all()
        assert (flown.external_torque == 0.0).all()


@pytest.mark.parametrize("substeps", [1, 2, 3, 4])
def test_the_published_torque_integrates_the_flight_again_bit_for_bit(substeps):
    flown, body = plant(substeps, disturbances()), RigidBody(INERTIA, 0.4 / substeps)
    assert (flown.external_torque == 0.0).all()
    attitude, momentum, seen = START, MOMENTUM, []
    for u in torques(60):
        state = flown.step(u)
        seen.append(flown.external_torque)
        attitude, momentum = body.step(attitude, momentum, u + flown.external_torque, substeps)
        assert (state.attitude == attitude).all()
        assert (state.momentum == momentum).all()
    flown.reset()
    assert (flown.external_torque == 0.0).all()
    for u, external in zip(torques(60), seen, strict=True):
        flown.step(u)
        assert (flown.external_torque == external).all()


@settings(max_examples=25)
@given(inertias(), rotations(), vectors(0.2), vectors(0.05), st.integers(1, 3))
def test_inertial_momentum_changes_by_the_impulse_of_both_torques(J, R, Pi, u, substeps):
    h = 0.3 / substeps
    body = RigidBody(J, h)
    flown = RigidBodyPlant(body, R, Pi, 20, substeps, disturbances(J))
    for _ in range(20):
        before = flown.state
        after = flown.step(u)
        total = u + flown.external_torque
        attitudes, _ = body.simulate(before.attitude, before.momentum, total, substeps)
        impulse = h * np.einsum("nij,j->i", attitudes[1:], total)
        gained = after.attitude @ after.momentum - before.attitude @ before.momentum
        assert np.abs(gained - impulse).max() < 1e-15


@pytest.mark.parametrize("substeps", [1, 2, 5])
def test_a_constant_torque_is_applied_as_it_is_and_its_momentum_grows_linearly(substeps):
    """About a principal axis from rest there is no gyroscopic torque: Pi = t d."""
    d = np.array([0.0, 3e-3, 0.0])
    body = RigidBody(np.diag([1.0, 0.8, 0.6]), 0.4 / substeps)
    flown = RigidBodyPlant(body, START, ZERO, 60, substeps, Disturbances({"c": ConstantTorque(d)}))
    for k in range(1, 61):
        momentum = flown.step(ZERO).momentum
        assert (flown.external_torque == d).all()
        assert np.abs(momentum - 0.4 * k * d).max() < 1e-15


def test_one_integrator_step_takes_the_torque_at_its_end_which_no_torque_moves():
    parts = disturbances()
    for u in (ZERO, np.array([0.05, 0.02, -0.03])):
        flown = plant(1, parts)
        state = flown.step(u)
        rate = np.linalg.inv(INERTIA) @ (state.momentum - 0.4 * flown.external_torque)
        assert (flown.external_torque == parts.torque(Motion(0, 0.4, state.attitude, rate))).all()


def continuous(part, torque, duration):
    """DOP853 on R' = R hat(omega), Pi' = Pi x omega + u + d(t, R)."""
    inverse = np.linalg.inv(INERTIA)

    def rate(time, x):
        rotation, p = x[:9].reshape(3, 3), x[9:]
        omega = inverse @ p
        d = part.torque(Motion(0, time, rotation, omega))
        return np.concatenate(
            [(rotation @ lie.hat(omega)).ravel(), np.cross(p, omega) + torque + d]
        )

    start = np.concatenate([START.ravel(), MOMENTUM])
    end = solve_ivp(rate, (0.0, duration), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    return end[:9].reshape(3, 3), end[9:]


GRADIENT = GravityGradient(INERTIA, 0.3, [0.1, 0.3, 1.0], [3.0, -1.0, 0.0])


@pytest.mark.parametrize("substeps", [1, 2, 3])
def test_the_order_of_a_gravity_gradient_is_that_of_the_held_torque(substeps):
    """First order, as any held torque (docs/dynamics.md), and second with half a kick ahead.

    The half kick is h/2 times the torque at the start, taken back at the end: it centers the
    impulses that come at the ends of integrator steps.
    """
    duration = 8.0
    expected, expected_momentum = continuous(GRADIENT, ZERO, duration)
    plain, centered = [], []
    for n in (80, 160, 320, 640):
        h = duration / n / substeps
        for kick, errors in ((0.0, plain), (0.5 * h, centered)):
            begin = MOMENTUM + kick * GRADIENT.torque(Motion(0, 0.0, START, ZERO))
            flown = plant(substeps, Disturbances({"g": GRADIENT}), begin, duration / n)
            for _ in range(n):
                state = flown.step(ZERO)
            last = kick * GRADIENT.torque(Motion(0, duration, state.attitude, ZERO))
            off = np.linalg.norm(state.momentum - last - expected_momentum)
            errors.append([lie.angle_between(state.attitude, expected), off])
    order = np.log2(np.array(plain[:-1]) / np.array(plain[1:]))
    assert np.abs(order[-1] - 1.0).max() < 0.15
    order = np.log2(np.array(centered[:-1]) / np.array(centered[1:]))
    assert np.abs(order - 2.0).max() < 0.1


def test_the_momentum_gained_is_the_integral_of_the_external_torque():
    """Sum of T R d over a flight, against the momentum that DOP853 gains under the same law."""
    duration, n = 8.0, 2000
    flown = plant(1, Disturbances({"g": GRADIENT}), MOMENTUM, duration / n)
    impulse = np.zeros(3)
    for _ in range(n):
        state = flown.step(ZERO)
        impulse += flown.period * state.attitude @ flown.external_torque
    assert np.abs(state.attitude @ state.momentum - START @ MOMENTUM - impulse).max() < 1e-14
    expected, momentum = continuous(GRADIENT, ZERO, duration)
    gained = expected @ momentum - START @ MOMENTUM
    assert np.linalg.norm(gained) > 0.01
    assert np.linalg.norm(impulse - gained) < 2e-3 * np.linalg.norm(gained)


@pytest.fixture(scope="module")
def case_1():
    return load("config/gupta2015_case1.yaml").build().run()


def kicked(part, flight, substeps):
    """Case I by DOP853: the commands as impulses, as the integrator has them, d all the time."""
    inertia = np.diag([1.0, 0.8, 0.8])
    inverse, h = np.linalg.inv(inertia), flight.period / substeps

    def rate(time, x):
        rotation, p = x[:9].reshape(3, 3), x[9:]
        omega = inverse @ p
        d = part.torque(Motion(0, time, rotation, omega)) if part else ZERO
        return np.concatenate([(rotation @ lie.hat(omega)).ravel(), np.cross(p, omega) + d])

    x = np.concatenate([flight.attitude[0].ravel(), flight.momentum[0]])
    for k, u in enumerate(np.repeat(flight.torque, substeps, axis=0)):
        x = solve_ivp(rate, (k * h, k * h + h), x, method="DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
        x[9:] += h * u
    return x[:9].reshape(3, 3)


@pytest.mark.parametrize(("substeps", "share"), [(1, 0.035), (2, 0.0175)])
def test_the_effect_on_case_1_is_right_to_a_share_that_goes_with_the_step(case_1, substeps, share):
    """Case I in a low orbit: what 150 s of the gravity gradient turn the body by, 0.025 deg."""
    inertia = np.diag([1.0, 0.8, 0.8])
    part = GravityGradient(inertia, 1.1e-3, [0.0, 0.3, 1.0], [1.0, 0.0, 0.0])
    body, ends = RigidBody(inertia, 0.4 / substeps), []
    for parts in (Disturbances({"g": part}), Disturbances()):
        flown = RigidBodyPlant(
            body, case_1.attitude[0], case_1.momentum[0], len(case_1.torque), substeps, parts
        )
        for u in case_1.torque:
            flown.step(u)
        ends.append(flown.state.attitude)
    effect = lie.log(ends[1].T @ ends[0])
    expected = lie.log(kicked(None, case_1, substeps).T @ kicked(part, case_1, substeps))
    assert math.degrees(np.linalg.norm(expected)) == pytest.approx(0.025, abs=0.001)
    assert np.linalg.norm(effect - expected) < share * np.linalg.norm(expected)


@pytest.mark.parametrize("substeps", [1, 2, 3, 4])
@pytest.mark.parametrize(("time", "duration"), [(0.0, 0.4), (1.2, 2.0), (2.8, 0.8), (100.0, 5.0)])
def test_a_push_gives_its_impulse_and_nothing_else(substeps, time, duration):
    push = [2e-4, -1e-4, 3e-4]
    flown = plant(substeps, Disturbances({"push": Push(push, time, duration)}))
    impulse, acted = np.zeros(3), []
    for k in range(60):
        state = flown.step(ZERO)
        impulse += 0.4 * flown.external_torque
        if flown.external_torque.any():
            acted.append(k)
    assert state.step == 60
    if time > 24.0:
        assert acted == []
        return
    first, last = round(time / 0.4), round((time + duration) / 0.4) - 1
    assert set(range(first, last + 1)) <= set(acted) <= set(range(first - 1, last + 2))
    assert impulse == pytest.approx(duration * np.array(push), rel=1e-12)
    if substeps % 2:
        assert acted == list(range(first, last + 1))
