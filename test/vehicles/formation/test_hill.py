"""Hill's equations: their solution, their integrals, and the closed trajectories."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.vehicles.formation import hill
from spacecraft_gnc.vehicles.formation.orbit import mean_motion, orbital_period

N = mean_motion(350e3)
PERIOD = orbital_period(350e3)
SCALE = np.array([1.0, 1.0, 1.0, N, N, N])
"""A position of 1 m and a velocity of n times that are alike."""
EQUATIONS = np.zeros((6, 6))
EQUATIONS[:3, 3:] = np.eye(3)
EQUATIONS[3, [0, 4]] = 3.0 * N**2, 2.0 * N
EQUATIONS[4, 3] = -2.0 * N
EQUATIONS[5, 2] = -(N**2)
TIMES = st.one_of(st.sampled_from([0.0, 1e-6, 1.0]), st.floats(-2.0 * PERIOD, 2.0 * PERIOD))
STATES = st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6).map(
    lambda numbers: 1e4 * SCALE * np.array(numbers)
)


def scaled(matrix):
    """A transition matrix for states in units of `SCALE`, all of whose entries are alike."""
    return matrix * SCALE / SCALE[:, None]


# --- transition -----------------------------------------------------------------------------


def test_the_period_at_350_km_is_that_of_the_figures():
    assert pytest.approx(5492.287, abs=5e-4) == PERIOD


@given(TIMES)
def test_the_transition_is_the_exponential_of_the_equations(time):
    exact = expm(scaled(EQUATIONS) * time)
    assert np.abs(scaled(hill.transition(N, time)) - exact).max() < 1e-11 * np.abs(exact).max()


@given(TIMES, TIMES)
def test_transitions_form_a_group(first, second):
    both = scaled(hill.transition(N, first + second))
    product = scaled(hill.transition(N, second) @ hill.transition(N, first))
    assert np.abs(both - product).max() < 1e-12 * 100.0  # up to 76 along the track in two orbits
    inverse = scaled(hill.transition(N, -first) @ hill.transition(N, first))
    assert np.abs(inverse - np.eye(6)).max() < 1e-11


@given(TIMES)
def test_the_transition_keeps_the_symplectic_form(time):
    p_of = np.eye(6)  # canonical momenta: velocity plus the frame's turning
    p_of[3, 1], p_of[4, 0] = -N, N
    form = np.block([[np.zeros((3, 3)), np.eye(3)], [-np.eye(3), np.zeros((3, 3))]])
    A = scaled(p_of @ hill.transition(N, time) @ np.linalg.inv(p_of))
    assert np.abs(A.T @ form @ A - form).max() < 1e-10


def test_the_transition_of_no_time_is_the_identity():
    assert np.array_equal(hill.transition(N, 0.0), np.eye(6))


@given(STATES, TIMES)
def test_jacobi_integral_drift_and_center_are_constant(start, time):
    def integrals(s):
        x, _, z, *v = s
        energy = 0.5 * np.dot(v, v) - 0.5 * N**2 * (3.0 * x**2 - z**2)
        return np.array([energy / N**2, 4.0 * x + 2.0 * v[1] / N])

    end = hill.transition(N, time) @ start
    size = np.abs(end / SCALE).max() + np.abs(start / SCALE).max()
    change = np.abs(integrals(end) - integrals(start))
    assert change[0] <= 1e-12 * size**2
    assert change[1] <= 1e-12 * size
    assert hill.drift_rate(N, end) == pytest.approx(hill.drift_rate(N, start), abs=1e-12 * size)


@given(STATES)
def test_the_drift_rate_is_the_mean_velocity_along_the_track(start):
    moved = hill.transition(N, PERIOD) @ start - start
    assert moved[1] / PERIOD == pytest.approx(hill.drift_rate(N, start), abs=1e-11)
    assert np.abs(np.delete(moved / SCALE, 1)).max() < 1e-9


@given(STATES, st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3))
def test_an_impulse_acts_before_the_drift(start, delta_v):
    A = hill.transition(N, PERIOD / 50)
    pushed = start + np.concatenate([np.zeros(3), delta_v])
    after = A @ start + hill.impulse_input(A) @ delta_v
    assert np.abs((after - A @ pushed) / SCALE).max() < 1e-8


# --- closed trajectories --------------------------------------------------------------------


@pytest.mark.parametrize("samples", [3, 7, 50, 360])
def test_the_natural_states_follow_each_other_without_impulses(samples):
    natural = hill.natural_states(N, 1000.0, samples)
    ahead = natural @ hill.transition(N, PERIOD / samples).T
    assert np.abs((ahead - np.roll(natural, -1, axis=0)) / SCALE).max() < 1e-11  # of 2000 m


def test_the_natural_states_are_on_a_2x1_ellipse_of_these_semi_axes_and_do_not_drift():
    natural = hill.natural_states(N, 1000.0, 50)
    x, y, z = natural[:, :3].T
    assert np.hypot(x / 1000.0, y / 2000.0) == pytest.approx(np.ones(50), rel=1e-14)
    assert not z.any()
    assert not hill.drift_rate(N, natural).any()
    assert natural[0] == pytest.approx([1000.0, 0.0, 0.0, 0.0, -2000.0 * N, 0.0])
    assert natural[1, 1] < 0.0  # backward where it is high


@given(
    st.lists(st.floats(-60.0, 120.0), min_size=3, max_size=3),
    st.lists(st.floats(-1e4, 1e4), min_size=3, max_size=3),
    st.lists(st.floats(0.0, 3.0), min_size=3, max_size=3),
    st.integers(0, 120),
)
def test_a_start_keeps_to_its_own_ellipse(phase, offset, amplitude, steps):
    start = hill.start_states(N, 1000.0, 50, phase, offset, amplitude)
    assert start.shape == (3, 6)
    later = start @ hill.transition(N, steps * PERIOD / 50).T
    expected = hill.start_states(N, 1000.0, 50, np.add(phase, steps), offset, amplitude)
    assert np.abs((later - expected) / SCALE).max() < 1e-8
    assert np.hypot(later[:, 0], (later[:, 1] - offset) / 2.0) == pytest.approx(
        1000.0 * np.array(amplitude), abs=1e-8
    )


def test_a_nominal_start_is_a_natural_state():
    natural = hill.natural_states(N, 800.0, 50)
    start = hill.start_states(N, 800.0, 50, [45, 21, 10], np.zeros(3), np.ones(3))
    assert np.array_equal(start, natural[[45, 21, 10]])


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: hill.transition(0.0, 1.0), ParameterError, "mean_motion: received 0.0"),
        (lambda: hill.transition(N, math.inf), ParameterError, "time: received inf"),
        (lambda: hill.impulse_input(np.eye(3)), ShapeError, "over_step: received"),
        (lambda: hill.natural_states(N, -1.0, 50), ParameterError, "radial_semi_axis: received"),
        (lambda: hill.natural_states(N, 1e3, 2), ParameterError, "samples: received 2"),
        (
            lambda: hill.start_states(N, 1e3, 50, [1, 2, 3], [0.0, 0.0], [1.0, 1.0, 1.0]),
            ShapeError,
            "along_track_offset: received",
        ),
        (
            lambda: hill.start_states(N, 1e3, 50, [1, 2], [0.0, 0.0], [1.0, math.nan]),
            ParameterError,
            "amplitude: received",
        ),
    ],
)
def test_impossible_arguments_are_refused(call, error, message):
    with pytest.raises(error, match=message):
        call()
