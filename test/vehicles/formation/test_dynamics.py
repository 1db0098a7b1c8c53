"""One control step of a formation: impulses, then free motion by either set of equations."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.vehicles.formation.dynamics import FormationMotion
from spacecraft_gnc.vehicles.formation.orbit import mean_motion, orbital_period
from spacecraft_gnc.vehicles.formation.two_body import TwoBodyMotion

ALTITUDE = 350e3
N, T = mean_motion(ALTITUDE), orbital_period(ALTITUDE) / 50
LINEAR = FormationMotion(ALTITUDE, T)
EXACT = FormationMotion(ALTITUDE, T, TwoBodyMotion(ALTITUDE, T, 0.9))
POSITION = np.array([[1000.0, -1500.0, 700.0], [-400.0, 9000.0, -2000.0], [0.0, 100.0, 0.0]])
VELOCITY = np.array([[0.3, -2.0, 0.5], [-0.1, 0.9, 1.5], [0.0, 0.1, 0.0]])
DELTA_V = np.array([[0.6, -0.4, 0.1], [-0.2, 0.3, 0.9], [0.1, 0.1, 0.1]])


def test_a_step_by_hill_s_equations_is_the_solution_of_them_after_the_impulse():
    def slope(_, s):
        x, _, z, vx, vy, vz = s
        return [vx, vy, vz, 3.0 * N**2 * x + 2.0 * N * vy, -2.0 * N * vx, -(N**2) * z]

    position, velocity = LINEAR.advance(5, POSITION, VELOCITY, DELTA_V)
    for i in range(3):
        start = [*POSITION[i], *(VELOCITY[i] + DELTA_V[i])]
        end = solve_ivp(slope, (0.0, T), start, method="DOP853", rtol=1e-13, atol=1e-10).y[:, -1]
        assert position[i] == pytest.approx(end[:3], abs=1e-8)
        assert velocity[i] == pytest.approx(end[3:], abs=1e-10)


@pytest.mark.parametrize("motion", [LINEAR, EXACT], ids=["hill", "exact"])
def test_an_impulse_is_a_change_of_velocity_at_the_start(motion):
    given = motion.advance(2, POSITION, VELOCITY, DELTA_V)
    had = motion.advance(2, POSITION, VELOCITY + DELTA_V, np.zeros((3, 3)))
    for one, other in zip(given, had, strict=True):
        assert np.array_equal(one, other)
        assert not one.flags.writeable


@pytest.mark.parametrize("motion", [LINEAR, EXACT], ids=["hill", "exact"])
def test_a_craft_that_is_not_healthy_moves_freely_and_the_others_as_before(motion):
    healthy = np.array([True, False, True])
    some = motion.advance(2, POSITION, VELOCITY, DELTA_V, healthy)
    done = motion.advance(2, POSITION, VELOCITY, DELTA_V, np.ones(3, dtype=bool))
    free = motion.advance(2, POSITION, VELOCITY, np.zeros((3, 3)))
    for one, all_, none in zip(some, done, free, strict=True):
        assert np.array_equal(one[[0, 2]], all_[[0, 2]])
        assert np.array_equal(one[1], none[1])
        assert not np.array_equal(all_[1], none[1])


def test_the_exact_motion_is_the_two_body_one_at_that_step():
    states = np.hstack([POSITION, VELOCITY])
    expected = EXACT.exact.advance(7, states)
    position, velocity = EXACT.advance(7, POSITION, VELOCITY, np.zeros((3, 3)))
    assert np.array_equal(np.hstack([position, velocity]), expected)
    linear = LINEAR.advance(7, POSITION, VELOCITY, np.zeros((3, 3)))
    assert 1e-3 < np.abs(position - linear[0]).max() < 1.0


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda: FormationMotion(-1.0, T), ParameterError, "altitude: received -1.0"),
        (lambda: FormationMotion(ALTITUDE, 0.0), ParameterError, "control_period: received 0.0"),
        (
            lambda: FormationMotion(ALTITUDE, T, TwoBodyMotion(ALTITUDE, 2.0 * T)),
            ParameterError,
            "exact: received a motion at 350000.0 m, sampled every",
        ),
        (lambda: FormationMotion(ALTITUDE, T, "j2"), ParameterError, "exact: received 'j2'"),
        (
            lambda: LINEAR.advance(0, POSITION, VELOCITY, np.zeros((2, 3))),
            ShapeError,
            "delta_v: received",
        ),
        (
            lambda: LINEAR.advance(0, POSITION, VELOCITY[:, :2], DELTA_V),
            ShapeError,
            "velocity: received",
        ),
    ],
)
def test_impossible_arguments_are_refused(make, error, message):
    with pytest.raises(error, match=message):
        make()
