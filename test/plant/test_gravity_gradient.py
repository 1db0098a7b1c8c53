"""The gravity-gradient torque against Newton's law, its symmetries and the theory of librations."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import inertias, rotations, unit_vectors

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.plant.disturbances.gravity_gradient import GravityGradient
from spacecraft_gnc.plant.disturbances.torques import Disturbances, Motion
from spacecraft_gnc.vehicles.rigid_body.plant import RigidBodyPlant

MU = 3.986004418e14  # [m^3/s^2], Earth
RADIUS = 7e6  # [m]
RATE = math.sqrt(MU / RADIUS**3)  # [rad/s]
ZERO = np.zeros(3)
TIMES = st.floats(0.0, 1e5)


def at(attitude, time=0.0):
    return Motion(0, time, attitude, ZERO)


def in_orbit(inertia, normal, angle):
    """A part whose position starts ``angle`` [rad] round the normal from some direction."""
    aside = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    return GravityGradient(inertia, RATE, normal, lie.exp(angle * normal) @ aside)


@given(st.integers(0, 2**32 - 1), rotations(), unit_vectors(), TIMES)
def test_it_is_the_torque_of_newtons_law_on_a_mass_distribution(seed, attitude, normal, time):
    """The sum of rho x f over 40 masses, each pulled by -mu m r / |r|^3 at its own place."""
    random = np.random.default_rng(seed)
    masses = random.uniform(0.5, 1.5, 40)
    places = random.normal(size=(40, 3)) * [3.0, 2.0, 1.0]
    places -= masses @ places / masses.sum()  # about the center of mass
    squares = np.einsum("ni,ni->n", places, places)
    inertia = (masses * squares).sum() * np.eye(3) - np.einsum(
        "n,ni,nj->ij", masses, places, places
    )
    part = in_orbit(inertia, normal, 0.3)
    angle = RATE * time
    center = RADIUS * lie.exp(angle * part.orbit_normal) @ part.orbit_position
    where = center + places @ attitude.T
    force = -MU * masses[:, None] * where / np.linalg.norm(where, axis=1)[:, None] ** 3
    expected = np.cross(places, force @ attitude).sum(axis=0)
    size = 3.0 * RATE**2 * np.ptp(np.linalg.eigvalsh(inertia))
    # Left out: terms smaller by the size of the body over the radius, about 1e-6.
    assert np.abs(part.torque(at(attitude, time)) - expected).max() < 1e-5 * size


@given(inertias(), rotations(), rotations(), unit_vectors(), TIMES)
def test_it_turns_with_the_world_and_with_the_axes_of_the_body(J, R, turn, normal, time):
    part = in_orbit(J, normal, 0.3)
    torque = part.torque(at(R, time))
    world = GravityGradient(J, RATE, turn @ part.orbit_normal, turn @ part.orbit_position)
    assert world.torque(at(turn @ R, time)) == pytest.approx(torque, abs=1e-14 * RATE)
    renamed = turn @ J @ turn.T
    body = GravityGradient(0.5 * (renamed + renamed.T), RATE, normal, part.orbit_position)
    assert body.torque(at(R @ turn.T, time)) == pytest.approx(turn @ torque, abs=1e-14 * RATE)


@given(st.floats(0.2, 2.0), rotations(), unit_vectors(), TIMES)
def test_a_sphere_feels_nothing(moment, attitude, normal, time):
    part = in_orbit(moment * np.eye(3), normal, 0.3)
    assert np.abs(part.torque(at(attitude, time))).max() < 1e-15 * RATE**2


@given(inertias(), rotations(), unit_vectors(), TIMES, st.integers(0, 2))
def test_a_principal_axis_to_the_center_feels_nothing(J, roll, normal, time, axis):
    part = in_orbit(J, normal, 0.3)
    principal = np.linalg.eigh(J)[1][:, axis]
    body = np.column_stack([principal, *np.linalg.svd(principal[None])[2][1:]])
    position = part.position(time)
    world = np.column_stack([position, *np.linalg.svd(position[None])[2][1:]])
    attitude = world @ body.T
    attitude *= np.sign(np.linalg.det(attitude))  # to the center or away from it
    assert np.abs(part.torque(at(attitude, time))).max() < 1e-14 * RATE**2
    assert part.torque(at(attitude, time)) @ position == pytest.approx(0.0, abs=1e-14 * RATE**2)


@given(inertias(), rotations(), unit_vectors(), TIMES)
def test_it_never_acts_about_the_line_to_the_center(J, attitude, normal, time):
    part = in_orbit(J, normal, 0.3)
    along = part.torque(at(attitude, time)) @ (attitude.T @ part.position(time))
    assert abs(along) < 1e-15 * RATE**2


# Roll along the velocity, pitch along the orbit normal, yaw along the zenith.
MOMENTS = np.diag([1.0, 1.2, 0.5])
LOCAL = np.column_stack([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
N = 1e-3  # orbit rate [rad/s]


def librate(offset, steps, time_step=20.0, substeps=1):
    """Fly from an offset (3,) [rad] at rest in the orbit; returns offsets and Jacobi integrals."""
    part = GravityGradient(MOMENTS, N)
    start = LOCAL @ lie.exp(offset)
    momentum = MOMENTS @ (start.T @ [0.0, 0.0, N])
    body = RigidBody(MOMENTS, time_step / substeps)
    plant = RigidBodyPlant(body, start, momentum, steps, substeps, Disturbances({"g": part}))
    offsets, integrals = np.empty((steps, 3)), np.empty(steps)
    for k in range(steps):
        state, time = plant.state, k * time_step
        orbit = lie.exp([0.0, 0.0, N * time]) @ LOCAL
        offsets[k] = lie.log(orbit.T @ state.attitude)
        r = state.attitude.T @ part.position(time)
        energy = plant.invariants().kinetic_energy + 1.5 * N**2 * r @ MOMENTS @ r
        integrals[k] = energy - N * (state.attitude @ state.momentum)[2]
        plant.step(ZERO)
    return offsets, integrals


def frequency(signal, lag, time_step=20.0):
    """Frequency [rad/s] of a sine: x(t + d) + x(t - d) = 2 cos(omega d) x(t)."""
    middle, sums = signal[lag:-lag], signal[2 * lag :] + signal[: -2 * lag]
    return math.acos(middle @ sums / (2.0 * middle @ middle)) / (lag * time_step)


@pytest.mark.parametrize("substeps", [1, 2, 3])
def test_pitch_librates_at_the_frequency_of_the_theory(substeps):
    offsets, _ = librate([0.0, 1e-3, 0.0], 3000, substeps=substeps)
    roll, pitch, yaw = np.diag(MOMENTS)
    expected = N * math.sqrt(3.0 * (roll - yaw) / pitch)
    assert frequency(offsets[:, 1], 30) == pytest.approx(expected, rel=2e-4)  # (n h)^2 = 4e-4
    assert np.abs(offsets[:, [0, 2]]).max() < 1e-9


def test_roll_and_yaw_librate_at_the_frequencies_of_the_theory():
    """Roots of s^4 + (1 + 3 a + a c) s^2 + 4 a c = 0, s in units of n (Hughes, section 9.2)."""
    offsets, _ = librate([1e-3, 0.0, 5e-4], 6000)
    d = 60
    roll, pitch, yaw = np.diag(MOMENTS)
    a, c = (pitch - yaw) / roll, (pitch - roll) / yaw
    expected = np.sort(np.sqrt(np.roots([1.0, -(1.0 + 3.0 * a + a * c), 4.0 * a * c])))
    for x in (offsets[:, 0], offsets[:, 2]):
        # x(t +- 2 d) - (S) x(t +- d) + (2 + P) x(t) = 0 with S = 2 (c1 + c2), P = 4 c1 c2
        sums = np.column_stack([x[3 * d : -d] + x[d : -3 * d], x[2 * d : -2 * d]])
        s, p = np.linalg.lstsq(sums, -(x[4 * d :] + x[: -4 * d]))[0]
        cosines = np.roots([1.0, 0.5 * s, 0.25 * (p - 2.0)])
        found = np.sort(np.arccos(cosines)) / (d * 20.0 * N)
        assert found == pytest.approx(expected, rel=2e-4)


@pytest.mark.parametrize("substeps", [1, 2])
def test_a_large_libration_keeps_its_size_over_many_orbits(substeps):
    """The Jacobi integral E - n L.normal oscillates and does not drift: 32 orbits."""
    offsets, integrals = librate([0.1, 0.2, 0.05], 10_000, substeps=substeps)
    depth = 1.5 * N**2 * np.ptp(np.diag(MOMENTS))
    tenth = len(integrals) // 10
    assert np.ptp(integrals) < 1e-2 * depth
    assert abs(integrals[:tenth].mean() - integrals[-tenth:].mean()) < 1e-4 * depth
    assert np.abs(offsets).max() < 1.0


def test_a_body_at_rest_in_the_orbit_stays_at_rest():
    """With the momentum J sin(n h) / h with which the integrator turns by n h in a step."""
    h, pitch = 20.0, MOMENTS[1, 1]
    momentum = [0.0, pitch * math.sin(N * h) / h, 0.0]
    part = Disturbances({"g": GravityGradient(MOMENTS, N)})
    plant = RigidBodyPlant(RigidBody(MOMENTS, h), LOCAL, momentum, 1000, 1, part)
    for k in range(1, 1001):
        state = plant.step(ZERO)
        orbit = lie.exp([0.0, 0.0, N * h * k]) @ LOCAL
        assert lie.angle_between(orbit, state.attitude) < 1e-11
        assert np.abs(plant.external_torque).max() < 1e-12 * N**2


@pytest.mark.parametrize(
    ("rate", "normal", "position", "words"),
    [
        (0.0, [0, 0, 1], [1, 0, 0], "orbit_rate: received 0.0; required a positive"),
        (math.nan, [0, 0, 1], [1, 0, 0], "orbit_rate: received nan"),
        (N, [0, 0, 0], [1, 0, 0], "orbit_normal: .*non-zero"),
        (N, [0, 0, 1], [0, 0, 0], "orbit_position: .*non-zero"),
        (N, [0, 0, 1], [1, 0, 1], r"orbit_position: .*45 deg.*give \[1, 0, 0\]"),
        (N, [0, 0, 1], [0, 0, -1], "orbit_position: .*180 deg.*turn it"),
        (N, [0, 0, math.inf], [1, 0, 0], "orbit_normal: .*finite"),
    ],
)
def test_an_orbit_that_is_none_is_refused(rate, normal, position, words):
    with pytest.raises(ParameterError, match=words):
        GravityGradient(MOMENTS, rate, normal, position)


def test_a_position_of_printed_digits_is_turned_into_the_plane():
    part = GravityGradient(MOMENTS, N, [0.0, 0.1, 1.0], [0.3, 0.950011, -0.0950011])
    assert abs(part.orbit_position @ part.orbit_normal) < 1e-16
    assert np.linalg.norm(part.orbit_position) == pytest.approx(1.0, abs=1e-15)
