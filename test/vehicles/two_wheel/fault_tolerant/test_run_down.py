"""Prediction of a wheel that does not answer: braked, obeying in part, or spinning on."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spacecraft_gnc.vehicles.two_wheel.controllers.fault_tolerant.run_down import RunDown

PERIOD = 10.0


def brake(nu, _, a=0.5):
    return math.copysign(max(abs(nu) - PERIOD * a, 0.0), nu)


def obey(nu, u, share=0.4):
    return nu + share * PERIOD * u


def spin(nu, _):
    return nu


def watched(motion, speed, steps, first=2.0):
    """A wheel seen over some steps, of which the first was commanded before its loss was known."""
    wheel, nu, told = RunDown(PERIOD, 5.0), speed, first
    for _ in range(steps):
        after = motion(nu, told)
        wheel.observe(nu, told, after)
        nu, told = after, wheel.stop(after)
    return wheel, nu


@given(st.floats(-90.0, 90.0).filter(lambda x: abs(x) > 20.0), st.integers(1, 3))
def test_a_braked_wheel_stops_when_it_will(speed, steps):
    wheel, nu = watched(brake, speed, steps, first=-2.0 * np.sign(speed) * -1.0)
    found, final = wheel.predict(nu, 30)
    expected = [nu]
    for _ in range(30):
        expected.append(brake(expected[-1], 0.0))
    assert found == pytest.approx(expected, abs=1e-4)
    assert final == 0.0


@pytest.mark.parametrize("share", [0.1, 0.4, 0.9, 1.0])
@pytest.mark.parametrize("speed", [-80.0, -3.0, 55.0])
def test_a_wheel_that_obeys_in_part_is_brought_to_rest_in_no_more_steps_than_it_takes(share, speed):
    wheel, nu = watched(lambda nu, u: obey(nu, u, share), speed, 2, first=np.sign(speed) * 0.5)
    found, final = wheel.predict(nu, 40)
    assert final == 0.0
    least = math.ceil(abs(nu) / (share * PERIOD * 5.0) - 1e-9)
    assert np.count_nonzero(found) <= least + 1
    for expected in found[1:5]:
        nu = obey(nu, wheel.stop(nu), share)
        assert nu == pytest.approx(expected, abs=2e-4)


@given(st.floats(-90.0, 90.0), st.integers(1, 4))
def test_a_wheel_that_spins_on_keeps_its_speed(speed, steps):
    wheel, nu = watched(spin, speed, steps)
    found, final = wheel.predict(nu, 30)
    assert np.array_equal(found, np.full(31, speed))
    assert final == speed


def test_a_slow_stop_is_not_counted_as_one():
    wheel, nu = watched(lambda nu, u: brake(nu, u, 0.01), 80.0, 3)
    found, final = wheel.predict(nu, 30)
    assert found[-1] == pytest.approx(nu - 3.0)
    assert final == nu


def test_before_anything_is_known_it_is_told_to_stop_and_expected_to_spin_on():
    wheel = RunDown(PERIOD, 5.0)
    assert wheel.stop(30.0) == -3.0
    assert wheel.stop(-80.0) == 5.0
    found, final = wheel.predict(30.0, 3)
    assert found.tolist() == [30.0] * 4
    assert final == 30.0


def test_a_wheel_that_has_stopped_stays_so():
    wheel, nu = watched(brake, 12.0, 5, first=0.0)
    assert nu == 0.0
    found, final = wheel.predict(nu, 5)
    assert not found.any()
    assert final == 0.0
    assert wheel.stop(nu) == 0.0
