"""The gyrostat against first principles, its conservation laws and a high-order method."""

from __future__ import annotations

import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from independent import hat
from scipy.integrate import solve_ivp
from strategies import inertias, rotations, vectors
from wheeled import (
    ATTITUDE,
    FULL_INERTIA,
    ORTHOGONAL,
    PYRAMID,
    RATE,
    SPEEDS,
    WHEEL_SETS,
    afrl,
    momentum,
    small,
    start,
)

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.vehicles.two_wheel import _gyrostat_kernels as kernels
from spacecraft_gnc.vehicles.two_wheel.dynamics import Gyrostat

MILLION = 10_000 if os.environ.get("NUMBA_DISABLE_JIT") == "1" else 1_000_000


# --- conservation ---------------------------------------------------------------------------


@pytest.mark.parametrize("moving", [False, True])
def test_total_momentum_is_conserved_over_a_million_steps(moving):
    gyrostat = small(PYRAMID, 0.01, max_speed=200.0)
    commands = np.random.default_rng(0).normal(scale=20.0, size=(MILLION, 4))
    motion = gyrostat.simulate(start(gyrostat), commands if moving else np.zeros((MILLION, 4)))
    total = momentum(gyrostat, *motion)
    # Rounding of the formula above; none of it adds up.
    assert np.abs(total - total[0]).max() < 1e-14 * np.linalg.norm(total[0])
    gram = np.einsum("nji,njk->nik", motion[0], motion[0])
    assert np.abs(gram - np.eye(3)).max() < 1e-14
    assert not moving or np.ptp(motion[2], axis=0).min() > 5.0


def test_zero_momentum_stays_zero_while_the_wheels_turn_the_bus():
    gyrostat = afrl(WHEEL_SETS["two"])
    state = gyrostat.state_from_rate(ATTITUDE, np.zeros(3), np.zeros(2))
    commands = np.random.default_rng(1).normal(scale=3.0, size=(MILLION // 10, 2))
    motion = gyrostat.simulate(state, commands)
    total = momentum(gyrostat, *motion)
    exchanged = np.abs(motion[1] @ gyrostat.inertia).max()
    assert exchanged > 1.0
    assert np.abs(total).max() < 1e-15 * exchanged
    # Kolmanovsky et al. 2016 (2): omega_i = -(Js / J_i) nu_i, and no rate about the third axis.
    expected = -0.043 * motion[2] / np.array([430.0, 1210.0])
    assert np.abs(motion[1][:, :2] - expected).max() < 1e-15
    assert np.abs(motion[1][:, 2]).max() == 0.0


@pytest.mark.parametrize("axes", WHEEL_SETS.values(), ids=WHEEL_SETS)
def test_the_energy_of_the_bus_is_conserved_while_the_wheels_keep_their_speeds(axes):
    """omega . J omega / 2: the motors work on the wheels, so that the kinetic energy oscillates."""
    gyrostat = small(axes, 0.05)
    state = start(gyrostat, 0.2)
    _, rates, _ = gyrostat.simulate(state, np.zeros(gyrostat.n_wheels), MILLION)
    energy = 0.5 * np.einsum("ni,ni->n", rates, rates @ gyrostat.inertia)
    assert np.abs(energy / energy[0] - 1.0).max() < 1e-11
    assert np.ptp(np.abs(rates)) > 0.1  # a tumble, not a steady spin


@settings(max_examples=50)
@given(inertias(), vectors(2.0), vectors(1.0), vectors(0.5), st.floats(-0.2, 0.2))
def test_a_stage_changes_the_energy_by_exactly_the_work_of_the_motors(J, Pi, g, change, h):
    """Every stage; h < 0 too, which the composition has."""
    body = small(ORTHOGONAL, 1.0).body.copy()
    body[:18] = np.concatenate([J.ravel(), np.linalg.inv(J).ravel()])
    mean = tuple(g + 0.5 * change)
    q0, q, ok = kernels.midpoint_turn(body, h, tuple(Pi), mean)
    assert ok
    turn = lie.from_quaternion_xyzw(np.array([*q, q0]))
    after = turn.T @ Pi
    before_rate, after_rate = np.linalg.solve(J, Pi - g), np.linalg.solve(J, after - g - change)
    gain = 0.5 * (after_rate @ J @ after_rate - before_rate @ J @ before_rate)
    assert gain == pytest.approx(-0.5 * (before_rate + after_rate) @ change, abs=2e-14)
    # The same for all of it: mean speed times axial impulse, wheel by wheel.
    axial = 0.1
    speeds = g / axial, (g + change) / axial
    kinetic = [
        0.5 * rate @ J @ rate + axial * (rate @ nu + 0.5 * nu @ nu)
        for rate, nu in zip((before_rate, after_rate), speeds, strict=True)
    ]
    impulse = axial * (speeds[1] + after_rate) - axial * (speeds[0] + before_rate)
    assert kinetic[1] - kinetic[0] == pytest.approx(0.5 * sum(speeds) @ impulse, abs=1e-13)


def test_kinetic_energy_is_the_sum_over_the_bodies():
    gyrostat = small(PYRAMID, 0.1)
    state = start(gyrostat)
    axes, axial = gyrostat.wheel_axes, gyrostat.wheel_inertias
    bus = FULL_INERTIA - (axes * axial) @ axes.T  # all but the wheels' spins
    spins = axes.T @ RATE + SPEEDS
    assert gyrostat.kinetic_energy(state) == pytest.approx(
        0.5 * RATE @ bus @ RATE + 0.5 * axial @ spins**2, rel=1e-14
    )


# --- the equations of motion ----------------------------------------------------------------


class Bodies:
    """Bus and wheels as separate rigid bodies, each with its own momentum and angular rate."""

    def __init__(self, rng, axes):
        self.axes = axes / np.linalg.norm(axes, axis=0)
        self.bus = np.array([[0.9, 0.04, -0.08], [0.04, 0.7, 0.01], [-0.08, 0.01, 0.8]])
        self.axial = rng.uniform(0.01, 0.02, axes.shape[1])
        self.transverse = 0.6 * self.axial
        self.offsets = [rng.uniform(0.0, 0.1) for _ in self.axial]  # m r^2 of each wheel's center

    def wheel_tensor(self, i):
        along = np.outer(self.axes[:, i], self.axes[:, i])
        return self.axial[i] * along + self.transverse[i] * (np.eye(3) - along)

    def momentum(self, rate, speeds):
        """Sum of the momenta of bus, wheels and wheels' centers, body frame."""
        total = self.bus @ rate
        for i, speed in enumerate(speeds):
            total = total + self.wheel_tensor(i) @ (rate + speed * self.axes[:, i])
            total = total + self.offsets[i] * (np.eye(3) - np.diag([0.0, 0.0, 1.0])) @ rate
        return total

    def locked(self):
        return np.column_stack([self.momentum(e, np.zeros(len(self.axial))) for e in np.eye(3)])

    def fly(self, attitude, rate, speeds, acceleration, duration, friction=(0.0, 0.0)):
        """DOP853 on d/dt (R h(omega, nu)) = 0, that is h' = -omega x h; returns R, omega, nu.

        ``friction`` is c [N m s] and tau [N m] of every wheel.
        """
        mass = self.locked()

        def derivative(_, x):
            rotation, omega, nu = x[:9].reshape(3, 3), x[9:12], x[12:]
            rub = (friction[0] * nu + friction[1] * np.sign(nu)) / self.axial
            torque = -np.cross(omega, self.momentum(omega, nu))
            torque = torque - self.momentum(np.zeros(3), acceleration - rub)
            turn = rotation @ hat(omega)
            return np.concatenate([turn.ravel(), np.linalg.solve(mass, torque), acceleration - rub])

        x = np.concatenate([attitude.ravel(), rate, speeds])
        end = solve_ivp(derivative, (0.0, duration), x, method="DOP853", rtol=1e-13, atol=1e-13)
        return end.y[:9, -1].reshape(3, 3), end.y[9:12, -1], end.y[12:, -1]


@pytest.mark.parametrize("axes", WHEEL_SETS.values(), ids=WHEEL_SETS)
@pytest.mark.parametrize("driven", [False, True])
@pytest.mark.parametrize("friction", [(0.0, 0.0), (2e-3, 0.02)], ids=["free", "rubbing"])
def test_it_converges_to_the_motion_of_separate_bodies_with_fourth_order(axes, driven, friction):
    rng = np.random.default_rng(2)
    bodies = Bodies(rng, axes)
    speeds = SPEEDS[: axes.shape[1]]
    acceleration = rng.normal(scale=10.0, size=len(speeds)) if driven else np.zeros(len(speeds))
    acceleration *= 0.1 if any(friction) else 1.0  # so that no wheel comes to rest
    turned, turning, spun = bodies.fly(ATTITUDE, RATE, speeds, acceleration, 4.0, friction)
    assert np.array_equal(np.sign(spun), np.sign(speeds)) or not any(friction)
    rub = {
        f"{name}_friction": np.full(len(speeds), value)
        for name, value in zip(("viscous", "coulomb"), friction, strict=True)
    }
    errors = []
    for n in (40, 80, 160):
        gyrostat = Gyrostat(bodies.locked(), axes, bodies.axial, 4.0 / n, **rub)
        state = gyrostat.step(gyrostat.state_from_rate(ATTITUDE, RATE, speeds), acceleration, n)
        assert np.abs(state.wheel_speed - spun).max() < 1e-10
        off = np.linalg.norm(state.angular_velocity - turning)
        errors.append([lie.angle_between(state.attitude, turned), off])
    assert max(errors[-1]) < 1e-7
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.abs(orders - 4.0).max() < 0.1


def test_locked_wheels_make_a_rigid_body():
    """Two integrators of one motion: they differ by the second order of the LGVI's own error."""
    rest = np.zeros(3)
    differences = []
    for n in (400, 800):
        gyrostat = small(ORTHOGONAL, 4.0 / n)
        state = gyrostat.step(gyrostat.state_from_rate(ATTITUDE, RATE, rest), rest, n)
        body = RigidBody(FULL_INERTIA, 4.0 / n)
        attitude, after = body.step(ATTITUDE, FULL_INERTIA @ RATE, rest, n)
        off = np.linalg.norm(state.angular_velocity - body.angular_velocity(after))
        differences.append([lie.angle_between(state.attitude, attitude), off])
    assert max(differences[1]) < 1e-3
    assert np.abs(np.log2(np.divide(*differences)) - 2.0).max() < 0.05


def test_spin_about_a_principal_axis_follows_the_momentum_exchange_in_closed_form():
    gyrostat = Gyrostat(np.diag([1.0, 0.8, 0.6]), [[0.0], [0.0], [1.0]], [0.01], 0.5)
    state = gyrostat.state_from_rate(np.eye(3), np.zeros(3), np.zeros(1))
    for _ in range(4):
        state = gyrostat.step(state, np.array([6.0]))
    rate = -0.01 * 12.0 / 0.6
    assert np.abs(state.angular_velocity - [0.0, 0.0, rate]).max() < 1e-16
    assert np.abs(state.attitude - lie.exp(np.array([0.0, 0.0, 0.5 * rate * 2.0]))).max() < 1e-4


@settings(max_examples=30)
@given(inertias(), rotations(), vectors(1.0), st.integers(0, 2**32 - 1), st.sampled_from([1, 2, 4]))
def test_it_goes_back_the_way_it_came(inertia, attitude, rate, seed, n_wheels):
    rng = np.random.default_rng(seed)
    axes = rng.normal(size=(3, n_wheels))
    gyrostat = Gyrostat(inertia, axes, np.full(n_wheels, 0.005), 0.05)
    commands = rng.normal(scale=20.0, size=(20, n_wheels))
    state = gyrostat.state_from_rate(attitude, rate, rng.normal(scale=20.0, size=n_wheels))
    there = [part[-1] for part in gyrostat.simulate(state, commands)]
    reverse = gyrostat.state_from_rate(there[0], -there[1], -there[2])
    back = [part[-1] for part in gyrostat.simulate(reverse, commands[::-1])]
    assert np.abs(back[0] - attitude).max() < 1e-12
    assert np.abs(back[1] + rate).max() < 1e-12
    assert np.abs(back[2] + state.wheel_speed).max() < 1e-12


@given(rotations(), vectors(2.0), vectors(50.0))
def test_a_momentum_gives_the_rate_that_gives_the_momentum(attitude, total, speeds):
    gyrostat = small(ORTHOGONAL, 0.1)
    state = gyrostat.state_from_momentum(attitude, total, speeds)
    again = gyrostat.state_from_rate(attitude, state.angular_velocity, speeds)
    assert np.abs(again.total_momentum - total).max() < 1e-14
    assert state.total_momentum is not total
    assert np.array_equal(state.total_momentum, total)


def test_the_motion_does_not_depend_on_the_inertial_frame():
    gyrostat, turn = small(PYRAMID, 0.05), lie.exp(np.array([1.0, -2.0, 0.5]))
    command = np.array([5.0, -3.0, 2.0, 1.0])
    here = gyrostat.step(start(gyrostat), command, 50)
    there = gyrostat.step(gyrostat.state_from_rate(turn @ ATTITUDE, RATE, SPEEDS), command, 50)
    assert np.abs(turn @ here.attitude - there.attitude).max() < 1e-14
    assert np.abs(here.angular_velocity - there.angular_velocity).max() < 1e-14
