"""Friction of the wheels: closed form, conservation, energy, sticking, and the audit's own form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import simpson, solve_ivp
from wheeled import ATTITUDE, ORTHOGONAL, PYRAMID, RATE, SPEEDS, momentum, small, start

from spacecraft_gnc.errors import GncError
from spacecraft_gnc.vehicles.two_wheel._gyrostat_kernels import coasted
from spacecraft_gnc.vehicles.two_wheel.audit.wheels import Motion

VISCOUS, COULOMB = np.array([3e-3, 1e-3, 0.0, 2e-3]), np.array([0.02, 0.0, 0.01, 0.05])
FRICTION = {"viscous_friction": VISCOUS, "coulomb_friction": COULOMB}
speeds = st.one_of(st.just(0.0), st.floats(-50.0, 50.0))
accelerations = st.one_of(st.just(0.0), st.floats(-5.0, 5.0))
viscous = st.one_of(st.just(0.0), st.floats(1e-6, 2.0))
coulomb = st.one_of(st.just(0.0), st.floats(1e-3, 5.0))
times = st.floats(0.0, 20.0)


def coasted_by_branches(t, nu, a, k, d):
    """DOP853 on each side of rest, and the choice between sticking and turning at rest."""
    side = math.copysign(1.0, nu) if nu else math.copysign(1.0, a)
    if nu == 0.0 and abs(a) <= d:
        return 0.0

    def stops(_, x):
        return x[0]

    stops.terminal, stops.direction = True, -side
    rate = lambda _, x: a - k * x - side * d  # noqa: E731
    found = solve_ivp(rate, (0.0, t), [nu], "DOP853", rtol=1e-12, atol=1e-12, events=stops)
    if found.status != 1 or nu == 0.0:
        return found.y[0, -1]
    return coasted_by_branches(t - found.t[-1], 0.0, a, k, d)


@pytest.mark.parametrize("nu", [-20.0, 0.0, 20.0])
@pytest.mark.parametrize("a", [-3.0, 0.0, 0.4, 3.0])
@pytest.mark.parametrize(("k", "d"), [(0.0, 0.0), (0.3, 0.0), (0.0, 0.5), (0.3, 0.5), (1e-9, 2.0)])
def test_the_closed_form_solves_the_equation(nu, a, k, d):
    for t in (0.1, 7.0, 40.0):
        assert coasted(t, nu, a, k, d) == pytest.approx(
            coasted_by_branches(t, nu, a, k, d), abs=1e-9
        )


@given(times, times, speeds, accelerations, viscous, coulomb)
def test_two_times_in_a_row_are_their_sum(t_1, t_2, nu, a, k, d):
    halfway = coasted(t_1, nu, a, k, d)
    assert coasted(t_2, halfway, a, k, d) == pytest.approx(
        coasted(t_1 + t_2, nu, a, k, d), abs=1e-11
    )


@given(times, speeds, accelerations, viscous, coulomb)
def test_mirrored_wheels_turn_the_other_way(t, nu, a, k, d):
    assert coasted(t, -nu, -a, k, d) == -coasted(t, nu, a, k, d)


@given(times, speeds, accelerations, viscous, coulomb)
def test_the_audit_finds_the_same_speeds_by_its_own_form(t, nu, a, k, d):
    row = [np.array([[value]]) for value in (a, k, d)]
    found = Motion(*row, math.inf).after(np.array([[nu]]), t)[0, 0]
    assert found == pytest.approx(coasted(t, nu, a, k, d), rel=1e-13, abs=1e-12)


def test_total_momentum_is_conserved_over_a_million_steps():
    gyrostat = small(PYRAMID, 0.01, max_speed=200.0, **FRICTION)
    commands = np.random.default_rng(0).normal(scale=20.0, size=(1_000_000, 4))
    motion = gyrostat.simulate(start(gyrostat), commands)
    total = momentum(gyrostat, *motion)
    assert np.abs(total - total[0]).max() < 1e-14 * np.linalg.norm(total[0])
    signs = np.sign(motion[2])
    assert np.count_nonzero(signs[1:] * signs[:-1] <= 0.0) > 100  # through rest, and at rest


def test_energy_falls_by_the_work_of_friction_and_of_the_motors():
    gyrostat, n, h = small(PYRAMID, 2e-3, **FRICTION), 2000, 2e-3
    command, first = np.array([2.0, -1.0, 0.5, 3.0]), start(gyrostat)
    attitudes, rates, nu = gyrostat.simulate(first, command, n)
    slope = command - gyrostat.friction[0] * nu - gyrostat.friction[1] * np.sign(nu)
    assert np.abs(nu).min() > 1.0  # no wheel comes to rest: the powers are smooth
    axes, axial = gyrostat.wheel_axes, gyrostat.wheel_inertias
    stored = rates @ gyrostat.inertia + nu @ gyrostat.wheels.T
    turning = np.linalg.solve(
        gyrostat.inertia, (-np.cross(rates, stored) - slope @ gyrostat.wheels.T).T
    ).T
    motors = (nu * axial * (command + turning @ axes)).sum(axis=1)
    lost = (VISCOUS * nu**2 + COULOMB * np.abs(nu)).sum(axis=1)
    end = first._replace(attitude=attitudes[-1], angular_velocity=rates[-1], wheel_speed=nu[-1])
    gain = gyrostat.kinetic_energy(end) - gyrostat.kinetic_energy(first)
    work = simpson(motors, dx=h), simpson(lost, dx=h)
    assert gain == pytest.approx(work[0] - work[1], abs=1e-9)
    assert work[1] > 10.0


def test_a_wheel_without_command_stops_sticks_and_breaks_loose():
    gyrostat = small(ORTHOGONAL, 0.1, coulomb_friction=[0.02, 0.02, 0.0])
    decelerations = 0.02 / gyrostat.wheel_inertias[:2]
    state = gyrostat.state_from_rate(ATTITUDE, RATE, [5.0, -5.0, 5.0])
    state = gyrostat.step(state, np.zeros(3), 10)
    expected = np.array([5.0, -5.0]) - np.array([1.0, -1.0]) * decelerations
    assert state.wheel_speed == pytest.approx([*expected, 5.0], abs=1e-13)
    state = gyrostat.step(state, np.zeros(3), 60)
    assert np.array_equal(state.wheel_speed, [0.0, 0.0, 5.0])
    state = gyrostat.step(state, np.array([0.99, 1.01, 0.0]) * [*decelerations, 1.0], 10)
    assert state.wheel_speed == pytest.approx([0.0, 0.01 * decelerations[1], 5.0], abs=1e-12)


def test_limits_hold_with_friction():
    gyrostat = small(PYRAMID, 0.05, max_speed=105.0, max_acceleration=30.0, **FRICTION)
    after = gyrostat.step(start(gyrostat), np.full(4, 1e6), 80)
    assert after.wheel_speed[2] == 105.0
    assert np.abs(after.wheel_speed).max() <= 105.0
    state = gyrostat.step(start(gyrostat), np.zeros(4), 1)
    expected = [
        coasted(0.05, nu, 0.0, c / J, tau / J)
        for nu, c, tau, J in zip(SPEEDS, VISCOUS, COULOMB, gyrostat.wheel_inertias, strict=True)
    ]
    assert np.array_equal(state.wheel_speed, expected)


def test_zero_friction_is_none_to_the_last_bit():
    with_zeros = small(PYRAMID, 0.05, viscous_friction=np.zeros(4), coulomb_friction=np.zeros(4))
    command = np.array([3.0, -2.0, 1.0, 5.0])
    for one, other in zip(
        with_zeros.simulate(start(with_zeros), command, 50),
        small(PYRAMID, 0.05).simulate(start(with_zeros), command, 50),
        strict=True,
    ):
        assert np.array_equal(one, other)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"viscous_friction": [1e-3]}, "viscous_friction: .* required 3 numbers, or none"),
        ({"coulomb_friction": [0.1, -0.1, 0.0]}, "coulomb_friction: .* required numbers >= 0"),
        ({"coulomb_friction": [0.1, math.nan, 0.0]}, "coulomb_friction: .*finite"),
    ],
)
def test_what_is_no_friction_is_refused(changes, words):
    with pytest.raises(GncError, match=words) as caught:
        small(ORTHOGONAL, 0.1, **changes)
    assert "\n" not in str(caught.value)
