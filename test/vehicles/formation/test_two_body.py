"""Motion about an oblate Earth against other methods, conservation laws and Hill's equations."""

from __future__ import annotations

import math

import numpy as np
import pytest
from both_ways import compiled_and_interpreted
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from strategies import vectors

from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.plant.earth import EQUATORIAL_RADIUS, GRAVITATIONAL_PARAMETER, J2
from spacecraft_gnc.vehicles.formation import _motion_kernels as kernels
from spacecraft_gnc.vehicles.formation import hill
from spacecraft_gnc.vehicles.formation.orbit import mean_motion, orbital_period
from spacecraft_gnc.vehicles.formation.two_body import TwoBodyMotion

ALTITUDE = 350e3
N, PERIOD = mean_motion(ALTITUDE), orbital_period(ALTITUDE)
RADIUS = EQUATORIAL_RADIUS + ALTITUDE
T = PERIOD / 50
SCALE = np.array([1.0, 1.0, 1.0, N, N, N])
START = np.array(
    [[1000.0, -1500.0, 700.0, 0.3, -2.0, 0.5], [-400.0, 9000.0, -2000.0, -0.1, 0.9, 1.5]]
)


def motion(period=T, inclination=0.9, argument_of_latitude=0.4, **options):
    return TwoBodyMotion(ALTITUDE, period, inclination, argument_of_latitude, **options)


def potential(r, j2=J2):
    """Potential energy per mass of an oblate Earth at r (3,)."""
    size = np.linalg.norm(r)
    legendre = 0.5 * (3.0 * (r[2] / size) ** 2 - 1.0)
    return -GRAVITATIONAL_PARAMETER / size * (1.0 - j2 * (EQUATORIAL_RADIUS / size) ** 2 * legendre)


def gravity(r, j2=J2):
    """Acceleration at r (3,), from the gradients of 1/r and of (3 z^2 - r^2) / (2 r^5)."""
    size = np.linalg.norm(r)
    z = np.array([0.0, 0.0, r[2]])
    zonal = 3.0 * z / size**5 - r / size**5 - 2.5 * (3.0 * r[2] ** 2 - size**2) * r / size**7
    return -GRAVITATIONAL_PARAMETER * (r / size**3 + j2 * EQUATORIAL_RADIUS**2 * zonal)


def flown(start, time, j2=J2):
    """State (6,) after a time, inertial, by a Runge-Kutta method of order 8 with error control."""

    def slope(_, s):
        return np.concatenate([s[3:], gravity(s[:3], j2)])

    end = solve_ivp(slope, (0.0, time), start, method="DOP853", rtol=1e-13, atol=1e-9)
    return end.y[:, -1]


def frame(chief):
    """Hill's axes of a chief as rows."""
    x = chief[:3] / np.linalg.norm(chief[:3])
    z = np.cross(chief[:3], chief[3:])
    z /= np.linalg.norm(z)
    return np.array([x, np.cross(z, x), z])


def angular_velocity(chief, j2=J2, h=1e-3):
    """Of the axes of `frame`, in them, from their positions shortly before and after."""
    ahead, behind = (frame(flown(chief, t, j2)) for t in (h, -h))
    turning = -(ahead - behind) / (2.0 * h) @ frame(chief).T
    return np.array([turning[2, 1], turning[0, 2], turning[1, 0]])


# --- conversions ----------------------------------------------------------------------------


@given(vectors(1e5), vectors(100.0), st.integers(0, 60))
def test_conversions_invert_each_other(position, velocity, step):
    one = motion()
    states = np.concatenate([position, velocity])[None]
    back = one.to_hill(step, one.to_inertial(step, states))
    assert np.abs((back - states) / SCALE).max() < 1e-9
    back = one.to_inertial(step, one.to_hill(step, states))
    assert np.abs((back - states) / SCALE).max() < 1e-9


@pytest.mark.parametrize("j2", [0.0, J2, 1e2 * J2])
def test_inertial_states_are_those_of_the_turning_axes(j2):
    one = motion(j2=j2)
    chief = one.chief(7)
    C, omega = frame(chief), angular_velocity(chief, j2)
    inertial = one.to_inertial(7, START)
    assert inertial[:, :3] == pytest.approx(START[:, :3] @ C, abs=1e-9)
    velocity = (START[:, 3:] + np.cross(omega, START[:, :3])) @ C
    assert inertial[:, 3:] == pytest.approx(velocity, abs=1e-6)
    if j2 > J2:  # the turning about the radius is seen at that precision
        assert abs(omega[0]) * 2000.0 > 1e-4


def test_velocities_are_the_derivatives_of_positions():
    h = 0.5
    fine = motion(h)
    x0 = START
    x1 = fine.advance(0, x0)
    x2 = fine.advance(1, x1)
    # Central differences: the error is h^2/6 of the third derivative, n^3 times the distance.
    assert (x2[:, :3] - x0[:, :3]) / (2.0 * h) == pytest.approx(x1[:, 3:], abs=1e-6)


def test_the_chief_starts_on_the_circular_orbit():
    one = motion()
    start, u, i = one.chief(0), 0.4, 0.9
    assert np.linalg.norm(start[:3]) == pytest.approx(RADIUS, rel=1e-15)
    assert np.linalg.norm(start[3:]) == pytest.approx(math.sqrt(GRAVITATIONAL_PARAMETER / RADIUS))
    assert start[:3] @ start[3:] == pytest.approx(0.0, abs=1e-3)
    normal = frame(start)[2]
    assert normal == pytest.approx([0.0, -math.sin(i), math.cos(i)])
    assert start[0] / RADIUS == pytest.approx(math.cos(u))
    assert start[5] > 0.0


# --- against other methods ------------------------------------------------------------------


@pytest.mark.parametrize("j2", [0.0, J2])
@pytest.mark.parametrize("samples", [50, 7])
def test_one_step_is_that_of_a_method_with_error_control(j2, samples):
    one = motion(PERIOD / samples, j2=j2)
    for step in (0, 3):
        chief = one.chief(step)
        end_chief = flown(chief, PERIOD / samples, j2)
        after = one.to_inertial(step + 1, one.advance(step, START))
        assert one.chief(step + 1)[:3] == pytest.approx(end_chief[:3], abs=2e-6)
        for craft, state in zip(after, one.to_inertial(step, START), strict=True):
            expected = flown(chief + state, PERIOD / samples, j2) - end_chief
            assert craft[:3] == pytest.approx(expected[:3], abs=1e-6)  # rounding of 7e6 m
            assert craft[3:] == pytest.approx(expected[3:], abs=1e-9)


def test_two_orbits_are_those_of_a_method_with_error_control():
    one, states = motion(), START
    for k in range(100):
        states = one.advance(k, states)
    chief = flown(one.chief(0), 2.0 * PERIOD)
    assert one.chief(100)[:3] == pytest.approx(chief[:3], abs=1e-3)
    ends = [flown(one.chief(0) + s, 2.0 * PERIOD) for s in one.to_inertial(0, START)]
    assert one.to_inertial(100, states)[:, :3] == pytest.approx(
        np.array(ends)[:, :3] - chief[:3], abs=1e-4
    )


def test_attraction_is_the_gradient_of_the_potential():
    earth = np.array([GRAVITATIONAL_PARAMETER, 1.5 * J2 * EQUATORIAL_RADIUS**2])
    for seed in range(10):
        r = np.random.default_rng(seed).normal(size=3)
        r *= RADIUS / np.linalg.norm(r)
        h = 1e3
        slope = [(potential(r + h * e) - potential(r - h * e)) / (2.0 * h) for e in np.eye(3)]
        slope_of_j2 = [
            (potential(r + h * e) - potential(r - h * e)
             - potential(r + h * e, 0.0) + potential(r - h * e, 0.0)) / (2.0 * h)
            for e in np.eye(3)
        ]  # fmt: skip
        assert kernels.attraction(earth, tuple(r)) == pytest.approx(-np.array(slope), abs=1e-6)
        oblate = kernels.oblateness(earth, tuple(r))
        assert oblate == pytest.approx(-np.array(slope_of_j2), abs=1e-7)
        assert gravity(r) == pytest.approx(-np.array(slope), abs=1e-6)


def test_the_order_of_the_integrator_is_eight():
    earth = np.array([GRAVITATIONAL_PARAMETER, 1.5 * J2 * EQUATORIAL_RADIUS**2])
    one = motion()
    start = np.vstack([one.chief(0), one.to_inertial(0, START)])
    exact = np.array([flown(start[0], PERIOD), *(flown(start[0] + s, PERIOD) for s in start[1:])])
    exact[1:] -= exact[0]
    errors = []
    for steps in (16, 20, 24, 28):
        row = start.copy()
        kernels.propagate(earth, row, PERIOD / steps, steps)
        errors.append(np.abs((row - exact) / SCALE).max(axis=1))
    ratio = np.array([[20 / 16], [24 / 20], [28 / 24]])
    orders = np.log(np.divide(errors[:-1], errors[1:])) / np.log(ratio)
    assert np.all((orders > 7.3) & (orders < 8.3)), (errors, orders)  # from below


def test_going_back_in_time_leads_to_the_start():
    earth = np.array([GRAVITATIONAL_PARAMETER, 1.5 * J2 * EQUATORIAL_RADIUS**2])
    one = motion()
    row = np.vstack([one.chief(0), one.to_inertial(0, START)])
    start = row.copy()
    kernels.propagate(earth, row, 60.0, 30)
    kernels.propagate(earth, row, -60.0, 30)
    assert np.abs((row - start) / SCALE)[1:].max() < 1e-8
    assert np.abs((row - start) / SCALE)[0].max() < 1e-6


# --- conservation ---------------------------------------------------------------------------


def test_energy_and_angular_momentum_about_the_axis_are_conserved():
    one, states = motion(), START
    energies, momenta = [], []
    for k in range(251):
        chief = one.chief(k)
        inertial = np.vstack([chief, chief + one.to_inertial(k, states)])
        energies.append([0.5 * s[3:] @ s[3:] + potential(s[:3]) for s in inertial])
        momenta.append([np.cross(s[:3], s[3:]) for s in inertial])
        states = one.advance(k, states)
    energies, momenta = np.array(energies), np.array(momenta)
    assert np.ptp(energies, axis=0).max() < 1e-12 * abs(energies[0, 0])
    size = np.linalg.norm(momenta[0, 0])
    assert np.ptp(momenta[..., 2], axis=0).max() < 1e-13 * size
    assert np.ptp(momenta[..., 0], axis=0).min() > 1e-3 * size  # only about this axis


def test_without_j2_the_chief_stays_on_its_circle():
    one = motion(j2=0.0)
    for k in (1, 25, 50):
        angle = 0.4 + 2.0 * math.pi * k / 50
        assert np.linalg.norm(one.chief(k)[:3]) == pytest.approx(RADIUS, rel=1e-12)
        assert one.chief(k)[0] == pytest.approx(RADIUS * math.cos(angle), abs=1e-3)


@pytest.mark.parametrize("inclination", [0.5, 0.9, 1.7])
def test_the_node_regresses_at_the_secular_rate_of_j2(inclination):
    one, orbits = motion(inclination=inclination), 20
    normal = frame(one.chief(50 * orbits))[2]
    moved = math.atan2(normal[0], -normal[1])
    rate = -1.5 * N * J2 * (EQUATORIAL_RADIUS / RADIUS) ** 2 * math.cos(inclination)
    # First order in J2, and the part of an orbit by which 20 periods are no 20 revolutions.
    assert moved == pytest.approx(rate * orbits * PERIOD, rel=0.03)


# --- Hill's equations -----------------------------------------------------------------------


def test_hill_s_equations_are_the_limit_of_small_separations():
    one, errors = motion(j2=0.0), []
    direction = START[0] / 1000.0
    for distance in (1e1, 1e2, 1e3, 1e4):
        states = distance * direction[None]
        error = one.advance(0, states) - states @ hill.transition(N, T).T
        errors.append(np.abs(error / SCALE).max())
    assert np.log10(np.divide(errors[1:], errors[:-1])) == pytest.approx(np.full(3, 2.0), abs=0.02)
    assert errors[2] < 10.0 * 2e3**2 / RADIUS


def orbit_errors(one):
    """How far craft are from the 2x1 km ellipse after an orbit that Hill's equations close [m]."""
    natural = hill.natural_states(N, 1000.0, 50)
    states = natural[[16, 0, 33]]
    for k in range(50):
        states = one.advance(k, states)
    return np.linalg.norm(states[:, :3] - natural[[16, 0, 33], :3], axis=1)


def test_the_ellipse_is_missed_by_as_much_as_is_documented():
    assert orbit_errors(motion(j2=0.0)).min() > 1.0
    assert orbit_errors(motion(j2=0.0)).max() < 6.0
    for inclination in (0.0, 0.9, 1.7):
        for u in (0.0, 0.8, 1.6):
            assert 10.0 < orbit_errors(motion(T, inclination, u)).max() < 100.0


def test_a_chief_on_the_kepler_orbit_would_lose_all_craft_together():
    one = motion()
    craft = one.to_inertial(0, hill.natural_states(N, 1000.0, 50)[[16, 0, 33]])
    kepler = flown(one.chief(0), PERIOD, 0.0)
    ends = [flown(one.chief(0) + s, PERIOD)[:3] - kepler[:3] for s in craft]
    distances = np.linalg.norm(ends, axis=1)
    assert distances.min() > 20e3
    assert np.ptp(distances) < 5e3


# --- arguments and kernels ------------------------------------------------------------------


def test_a_step_depends_on_its_number_alone_and_craft_on_themselves():
    first, second = motion(), motion()
    late = first.advance(30, START)
    second.advance(3, START)
    assert np.array_equal(second.advance(30, START), late)
    assert np.array_equal(first.advance(30, START), late)
    assert np.array_equal(first.advance(30, START[1:])[0], late[1])
    assert not np.array_equal(first.advance(29, START), late)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"period": 0.0}, "control_period: received 0.0"),
        ({"inclination": 51.6}, "inclination: received 51.6; required an angle"),
        ({"argument_of_latitude": math.nan}, "argument_of_latitude: received nan"),
        ({"j2": -1e-3}, "j2: received -0.001"),
    ],
)
def test_impossible_arguments_are_refused(options, message):
    with pytest.raises(ParameterError, match=message):
        motion(**options)


def test_states_of_another_shape_are_refused():
    with pytest.raises(ShapeError, match="states: received"):
        motion().advance(0, np.zeros((3, 5)))


PROGRAM = """
import sys
import numpy as np
from spacecraft_gnc.vehicles.formation.two_body import TwoBodyMotion
one = TwoBodyMotion(350e3, 110.0, 0.9, 0.4)
states = np.array([[1e3, -1.5e3, 700.0, 0.3, -2.0, 0.5], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]])
inertial = one.to_inertial(2, states)
for k in range(5):
    states = one.advance(k, states)
np.savez(sys.argv[1], states=states, inertial=inertial, chief=one.chief(5) / 1e6)
"""


def test_compiled_and_interpreted_kernels_agree(tmp_path):
    compiled, interpreted = compiled_and_interpreted(PROGRAM, tmp_path)
    assert not compiled["states"][1].any()  # a craft at the chief stays there
    for name, value in compiled.items():
        assert np.abs(value - interpreted[name]).max() < 1e-9, name
