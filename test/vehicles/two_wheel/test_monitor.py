"""Residual test of the wheels: no false alarm, detection, what is concluded of missed steps."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from spacecraft_gnc.errors import GncError
from spacecraft_gnc.vehicles.two_wheel.monitor import ResidualTest, WheelMonitor
from spacecraft_gnc.vehicles.two_wheel.state import WheelState

AXIAL = np.array([0.043, 0.05, 0.03])
VISCOUS = np.array([2e-4, 1e-4, 0.0])  # [N m s]
COULOMB = np.array([3e-3, 0.0, 5e-3])  # [N m]
PERIOD, STEPS = 10.0, 100_000


def test_(**changes):
    """The test with these frictions as its bounds."""
    given_ = {"period": PERIOD, "wheel_inertias": AXIAL, "viscous_friction": VISCOUS,
              "coulomb_friction": COULOMB, "max_speed": 100.0, "max_acceleration": 5.0,
              "substeps": 10}  # fmt: skip
    return ResidualTest(**(given_ | changes))


test_.__test__ = False


def frictional(nu, u, h, viscous=VISCOUS, coulomb=COULOMB, axial=AXIAL):
    """Speeds after nu' = u - (c nu + tau sign nu)/Js held for h, in closed form.

    Linear until a wheel passes zero, where it sticks if |u| Js <= tau, and linear again after it.
    """
    c, tau = viscous / axial, coulomb / axial
    way = np.where(nu != 0.0, np.sign(nu), np.sign(u))
    pull = u - tau * way
    braked = pull * nu < 0.0
    time = np.where(braked, np.abs(nu) / np.where(braked, np.abs(pull), 1.0), 1e300)
    passed = np.where(c > 0.0, np.log1p(c * time) / np.where(c > 0.0, c, 1.0), time)
    free = np.abs(u) > tau
    again = _linear(0.0, (u - tau * np.sign(u)) * free, c, h - np.minimum(passed, h))
    sticks = (nu == 0.0) & ~free
    return np.where(passed < h, again, np.where(sticks, 0.0, _linear(nu, pull, c, h)))


def _linear(nu, pull, c, t):
    gain = np.where(c > 0.0, -np.expm1(-c * t) / np.where(c > 0.0, c, 1.0), t)
    return nu * np.exp(-c * t) + pull * gain


@given(st.floats(-50.0, 50.0), st.floats(-5.0, 5.0), st.integers(0, 2))
def test_the_friction_of_these_tests_is_that_of_its_equation(nu, u, i):
    c, tau = VISCOUS[i] / AXIAL[i], COULOMB[i] / AXIAL[i]

    def motion(_, x):  # smooth at zero, so that it can stick there
        return u - c * x - tau * np.tanh(x / 1e-5)

    one = slice(i, i + 1)
    found = frictional(np.array([nu]), np.array([u]), 10.0, VISCOUS[one], COULOMB[one], AXIAL[one])
    true = solve_ivp(motion, (0.0, 10.0), [nu], method="LSODA", rtol=1e-8, atol=1e-9).y[0, -1]
    assert found[0] == pytest.approx(true, abs=3e-4)


@pytest.mark.parametrize("share", [1.0, 0.3, 0.0], ids=["bound", "less", "none"])
def test_no_false_alarm_in_1e5_steps_of_each_wheel(share):
    """Random commands, small and saturating, with friction at the bound, below it, and without."""
    rng, check = np.random.default_rng(7), test_()
    size = 10.0 ** rng.uniform(-6.0, 1.0, (STEPS, 1))
    u = size * rng.uniform(-1.0, 1.0, (STEPS, 3))
    nu = rng.uniform(-100.0, 100.0, (STEPS, 3)) * (rng.random((STEPS, 3)) < 0.9)
    after, told = nu, np.clip(u, -5.0, 5.0)
    for _ in range(10):  # integrator steps, each of which ends at the speed limit
        after = np.clip(
            frictional(after, told, PERIOD / 10, share * VISCOUS, share * COULOMB), -100.0, 100.0
        )
    residual, threshold = check.residual(nu, u, after), check.threshold(nu, u, after)
    assert (np.abs(residual) <= threshold).all()
    assert (np.abs(after) == 100.0).mean() > 0.01
    if share == 1.0:  # the bound is no wide one: friction alone comes close to it
        assert np.abs(residual / threshold).max() > 0.999


KINDS = {"friction": (0.0, 0.5), "spinning": (0.0, 0.0), "partial": (0.4, 0.0)}


@pytest.mark.parametrize(("share", "braking"), KINDS.values(), ids=KINDS)
def test_every_command_that_can_show_a_loss_does(share, braking):
    """A lost wheel answers with a share, or is braked at 0.5 rad/s^2 whatever is commanded."""
    rng, check = np.random.default_rng(3), test_()
    u = rng.uniform(-5.0, 5.0, (20_000, 3))
    nu = rng.uniform(-45.0, 45.0, u.shape)
    after = nu + PERIOD * share * u
    after = np.sign(after) * np.maximum(np.abs(after) - PERIOD * braking, 0.0)
    missing = np.abs(nu + PERIOD * u - after)  # no speed limit acts
    bound = PERIOD * (VISCOUS * 100.0 + COULOMB) / AXIAL + 1e-9
    seen = np.abs(check.residual(nu, u, after)) > check.threshold(nu, u, after)
    assert seen[missing > bound].all()
    assert seen.mean() > 0.9


def state(step, speed, told):
    """A state, of which the monitor reads speeds and command."""
    unit, zero = np.eye(3), np.zeros(3)
    speed, told = np.array(speed), None if told is None else np.array(told)
    return WheelState(step, unit, zero, speed, zero, np.ones(3, dtype=bool), told)


def observed(*states, monitor=None):
    """Readings of a row of states."""
    monitor = WheelMonitor(test_()) if monitor is None else monitor
    return [monitor.observe(one) for one in states]


def test_a_wheel_that_does_not_answer_is_excluded_for_good_and_told():
    first, second, third = observed(
        state(4, [10.0, 0.0, 20.0], [1.0, 1.0, 1.0]),
        state(5, [19.5, 2.5, 20.0], [1.0, 1.0, 1.0]),
        state(6, [28.9, 12.4, 29.0], [1.0, 1.0, 1.0]),
    )
    assert first.healthy.all()
    assert np.isnan(first.residual).all()
    assert second.healthy.tolist() == [True, False, False]
    assert second.residual == pytest.approx([-0.5, -7.5, -10.0], abs=1e-12)
    assert second.response == pytest.approx([0.95, 0.25, 0.0], abs=1e-12)
    assert second.deceleration == pytest.approx([-0.95, -0.25, 0.0], abs=1e-12)
    assert (np.abs(third.residual) < third.threshold).all()
    assert third.healthy.tolist() == [True, False, False]


def test_a_command_too_small_to_tell_gives_no_response():
    _, reading = observed(state(0, [50.0] * 3, [0.0] * 3), state(1, [50.0] * 3, [1e-3, 0.0, 4.0]))
    assert np.isnan(reading.response[:2]).all()
    assert reading.response[2] == 0.0
    assert reading.healthy.tolist() == [True, True, False]


@pytest.mark.parametrize(
    ("step", "told", "speed"),
    [(7, [5.0] * 3, 0.0), (5, None, 0.0), (5, [math.nan] * 3, 0.0), (5, [5.0] * 3, math.nan)],
    ids=["missed", "command not known", "command not finite", "speed not known"],
)
def test_nothing_is_concluded_from_a_step_that_is_not_known(step, told, speed):
    monitor = WheelMonitor(test_())
    readings = observed(
        state(4, [0.0] * 3, [0.0] * 3), state(step, [speed] * 3, told), monitor=monitor
    )
    assert all(reading.healthy.all() for reading in readings)
    assert np.isnan(readings[1].threshold).all()
    (after,) = observed(state(step + 1, [speed] * 3, [5.0] * 3), monitor=monitor)
    assert after.healthy.all() == math.isnan(speed)  # but from the next one on


def test_a_reset_trusts_every_wheel_again():
    monitor = WheelMonitor(test_())
    observed(state(0, [0.0] * 3, None), state(1, [0.0] * 3, [5.0] * 3), monitor=monitor)
    monitor.reset()
    (reading,) = observed(state(2, [0.0] * 3, [5.0] * 3), monitor=monitor)
    assert reading.healthy.all()


def test_a_wheel_at_its_limit_is_no_failed_one():
    _, reading = observed(
        state(0, [95.0, -95.0, 100.0], [0.0] * 3),
        state(1, [100.0, -100.0, 100.0], [5.0, -5.0, 9.0]),
    )
    assert reading.healthy.all()
    assert reading.residual == pytest.approx(np.zeros(3), abs=1e-12)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"period": 0.0}, "period: received 0.0"),
        ({"viscous_friction": [-1.0, 0.0, 0.0]}, "viscous_friction: .* required numbers >= 0"),
        ({"coulomb_friction": [0.0, 0.0]}, r"coulomb_friction: received an array of shape \(2,\)"),
        ({"max_speed": -1.0}, "max_speed: received -1.0"),
        ({"substeps": 0}, "substeps: received 0"),
    ],
)
def test_what_is_no_test_is_refused(changes, words):
    with pytest.raises(GncError, match=words) as caught:
        test_(**changes)
    assert "\n" not in str(caught.value)
