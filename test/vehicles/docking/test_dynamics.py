"""Relative motion against an independent formulation, closed forms and conservation laws."""

from __future__ import annotations

import math

import numpy as np
import pytest
from both_ways import compiled_and_interpreted
from docking_pair import (
    CHIEF,
    DEPUTY,
    FULL_INERTIA,
    MASS,
    SPIN,
    N,
    T,
    difference,
    from_hill,
    pair,
    rotation,
    to_hill,
    truth,
    turned,
)
from hypothesis import given
from hypothesis import strategies as st
from strategies import rotations, vectors

from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.plant.earth import GRAVITATIONAL_PARAMETER as EARTH
from spacecraft_gnc.vehicles.docking import _motion_kernels as kernels
from spacecraft_gnc.vehicles.docking.chief import ChiefMotion
from spacecraft_gnc.vehicles.docking.dynamics import _row
from spacecraft_gnc.vehicles.docking.geometry import clearance, line_of_sight_margin

ATTITUDE = rotation([0.3, -0.2, 0.25])
START = (
    np.array([20.0, 4.0, -3.0]),
    np.array([-0.1, 0.05, 0.02]),
    ATTITUDE,
    np.array([0.02, -0.01, 0.015]),
)
FORCE, MOMENT = np.array([0.6, -0.4, 0.9]), np.array([0.02, 0.01, -0.03])
ZERO = np.zeros(3)
TILTED = {"tilt": 0.7, "inertia": FULL_INERTIA, "attitude": rotation([0.4, 0.1, -0.6])}


def coast(motion, state, steps, t=0.0):
    """States of free motion, the first included."""
    states = [state]
    for k in range(steps):
        states.append(motion.advance(t + T * k, *states[-1], ZERO, ZERO)[:4])
    return states


# --- against other methods ------------------------------------------------------------------


@pytest.mark.parametrize("t", [0.0, 735.0])
@pytest.mark.parametrize("options", [{}, {"two_body": False}, {"gravity_gradient": True}])
def test_one_step_is_that_of_another_formulation(options, t):
    motion = pair(**TILTED, **options)
    done = motion.advance(t, *START, FORCE, MOMENT)
    # Fourth order at 0.25 s and 0.03 rad/s: 5e-12 m, 2e-11 rad; a quarter of the step, 3e-13.
    expected = truth(motion, t, START, FORCE, MOMENT, T)
    assert difference(done, expected) < 5e-11
    fine = pair(**TILTED, **options, substeps=80).advance(t, *START, FORCE, MOMENT)
    assert difference(fine, expected) < 1e-12


def test_two_hundred_steps_are_those_of_another_formulation():
    motion, state = pair(**TILTED, gravity_gradient=True), START
    expected = START
    for k in range(200):
        force = FORCE * math.cos(0.1 * k)
        state = motion.advance(T * k, *state, force, 0.02 * MOMENT)[:4]
        expected = truth(motion, T * k, expected, force, 0.02 * MOMENT, T)
    assert difference(state, expected) < 1e-8 * np.linalg.norm(state[0])


def clohessy_wiltshire(r, v, t):
    """Closed-form free motion in Hill's frame (Clohessy and Wiltshire 1960)."""
    s, c = math.sin(N * t), math.cos(N * t)
    (x, y, z), (vx, vy, vz) = r, v
    return np.array([
        (4 - 3 * c) * x + s / N * vx + 2 / N * (1 - c) * vy,
        6 * (s - N * t) * x + y - 2 / N * (1 - c) * vx + (4 * s - 3 * N * t) / N * vy,
        z * c + vz / N * s,
    ])  # fmt: skip


@pytest.mark.parametrize("tilt", [0.0, 0.7])
def test_free_translation_is_the_closed_form_solution(tilt):
    motion = pair(tilt=tilt, two_body=False)
    states = coast(motion, START, 1200)  # more than an orbit
    first = to_hill(motion, 0.0, *START)
    for k in (1, 400, 1200):
        r = to_hill(motion, T * k, *states[k])[0]
        expected = clohessy_wiltshire(*first[:2], T * k)
        # Rounding of 1200 conversions, which drift along the track spreads.
        assert np.abs(r - expected).max() < 1e-10 * max(1.0, np.linalg.norm(expected))


def test_two_body_gravity_departs_from_linear_with_the_square_of_the_distance():
    gaps = []
    for distance in (1e2, 1e3, 1e4):
        start = (np.array([distance, 0.6 * distance, -0.4 * distance]), *START[1:])
        ends = [pair(two_body=b).advance(0.0, *start, ZERO, ZERO) for b in (True, False)]
        gaps.append(np.abs(ends[0].port_velocity - ends[1].port_velocity).max())
    assert np.allclose(np.divide(gaps[1:], gaps[:-1]), 100.0, rtol=2e-2)
    radius = pair().chief.orbit_radius
    assert gaps[1] < 10.0 * N**2 * 1e6 / radius * T


def test_gravity_gradient_is_the_moment_of_the_attraction_on_the_masses():
    """Eight points with the inertia of the cuboid, each attracted on its own."""
    points = DEPUTY.vertices / math.sqrt(3.0)
    radius = (EARTH / N**2) ** (1.0 / 3.0)
    start = (np.array([5.0, 1.0, 2.0]), ZERO, ATTITUDE, ZERO)
    momenta = []
    for gradient in (True, False):
        motion = pair(gravity_gradient=gradient, spin=0.0, substeps=1, period=0.01)
        done = motion.advance(0.0, *start, ZERO, ZERO)
        rate = to_hill(motion, 0.01, *done[:4])[3]
        momenta.append(done.attitude @ (motion.inertia @ rate))
    found = (momenta[0] - momenta[1]) / 0.01
    center = to_hill(motion, 0.0, *start)[0] + [radius, 0.0, 0.0]
    arms = points @ ATTITUDE.T
    places = center + arms
    pull = -EARTH * places / np.linalg.norm(places, axis=1)[:, None] ** 3
    expected = np.cross(arms, MASS / 8.0 * pull).sum(axis=0)
    # The direction at the chief instead of the deputy; a difference of large attractions.
    assert np.abs(found - expected).max() < 1e-5 * np.abs(expected).max()


# --- conservation ---------------------------------------------------------------------------


def test_free_rotation_conserves_inertial_momentum_and_energy():
    motion = pair(**TILTED)
    momenta, energies = [], []
    for k, state in enumerate(coast(motion, (*START[:3], 2.0 * START[3]), 1000)):
        _, _, R_HD, rate = to_hill(motion, T * k, *state)
        momenta.append(rotation([0.0, 0.0, N * T * k]) @ R_HD @ (FULL_INERTIA @ rate))
        energies.append(0.5 * rate @ FULL_INERTIA @ rate)
    size = np.linalg.norm(momenta[0])
    assert np.abs(np.array(momenta) - momenta[0]).max() < 1e-12 * size  # 1000 conversions
    assert np.ptp(energies) < 1e-9 * energies[0]


def test_free_translation_conserves_its_jacobi_integral():
    motion = pair(tilt=0.7, two_body=False)
    values = []
    for k, state in enumerate(coast(motion, START, 1000)):
        r, v = to_hill(motion, T * k, *state)[:2]
        values.append(0.5 * v @ v - 0.5 * N**2 * (3.0 * r[0] ** 2 - r[2] ** 2))
    assert np.ptp(values) < 1e-11 * abs(values[0])


def test_attitude_stays_a_rotation():
    states = coast(pair(**TILTED), (*START[:3], 20.0 * START[3]), 1000)
    R = np.array([state[2] for state in states])
    assert np.abs(np.einsum("nji,njk->nik", R, R) - np.eye(3)).max() < 1e-14


def test_order_of_convergence_is_four():
    fast = (*START[:3], np.array([0.4, -0.3, 0.5]))
    errors = []
    exact = truth(pair(**TILTED), 0.0, fast, FORCE, MOMENT, T)
    for substeps in (5, 10, 20, 40):
        motion = pair(**TILTED, substeps=substeps)
        errors.append(difference(motion.advance(0.0, *fast, FORCE, MOMENT), exact))
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert np.all(np.abs(orders - 4.0) < 0.3), (errors, orders)


# --- kinematics -----------------------------------------------------------------------------


@given(vectors(30.0), vectors(), rotations(), vectors(), st.floats(0.0, 2000.0))
def test_conversions_invert_each_other(offset, velocity, attitude, rate, t):
    motion = pair(**TILTED)
    row = _row(offset, velocity, attitude, rate)
    before = row.copy()
    deputy, chief, _ = motion.packed
    standing = kernels.to_standing(deputy, chief, t, row, 0)
    kernels.to_chief(deputy, chief, t, 0.0, *standing, row, 0)
    assert np.abs(row - before).max() < 1e-14 * max(10.0, np.abs(before).max())
    hill = to_hill(motion, t, offset, velocity, attitude, rate)
    assert np.abs(standing[0] - hill[0]).max() < 1e-13 * 30.0
    assert difference(from_hill(motion, t, *hill), (offset, velocity, attitude, rate)) < 1e-12


def test_velocities_are_the_derivatives_of_the_published_state():
    h = 1e-3
    forward = pair(**TILTED, period=h, substeps=1)
    t = 100.0
    one = forward.advance(t, *START, FORCE, MOMENT)
    two = forward.advance(t + h, *one[:4], FORCE, MOMENT)
    velocity = (two.port_offset - START[0]) / (2.0 * h)
    assert np.abs(velocity - one.port_velocity).max() < 1e-8
    rate = turned(START[2], two.attitude) / (2.0 * h)
    assert np.abs(rate - one.angular_velocity).max() < 1e-8


@given(vectors(), rotations(), st.floats(0.0, 3000.0))
def test_chief_rates_are_the_derivatives_of_its_attitude(axis, attitude, t):
    chief = ChiefMotion(N, 0.03, axis + np.array([0.0, 0.0, 2.0]), attitude)
    h = 1e-2
    inertial = [rotation([0.0, 0.0, N * s]) @ chief.attitude(s) for s in (t - h, t + h)]
    rate = turned(*[inertial[0].T, inertial[1].T]) / (-2.0 * h)
    assert np.abs(rate - chief.angular_velocity(t)).max() < 1e-7
    change = (chief.angular_velocity(t + h) - chief.angular_velocity(t - h)) / (2.0 * h)
    assert np.abs(change - chief.angular_acceleration(t)).max() < 1e-9
    found = np.array(kernels.chief_attitude(chief.packed, t)).reshape(3, 3)
    assert np.abs(found - chief.attitude(t)).max() < 1e-13
    rates = kernels.chief_rate(chief.packed, tuple(found.ravel()))
    assert np.abs(np.array(rates) - chief.angular_velocity(t)).max() < 1e-14


# --- thrusters and margins ------------------------------------------------------------------


@pytest.mark.parametrize("direction", range(6))
def test_a_lost_direction_gives_no_force_in_the_deputy_frame(direction):
    motion, lost = pair(**TILTED), np.ones(6, dtype=bool)
    lost[direction] = False
    blocked = [(direction % 3, 1.0 if direction < 3 else -1.0)]
    done = motion.advance(35.0, *START, FORCE, MOMENT, lost)
    expected = truth(motion, 35.0, START, FORCE, MOMENT, T, blocked)
    assert difference(done, expected) < 3e-10  # the force turns with the deputy
    healthy = motion.advance(35.0, *START, FORCE, MOMENT)
    pushes = (ATTITUDE.T @ FORCE)[direction % 3] * blocked[0][1] > 0.0
    same = all(np.array_equal(a, b) for a, b in zip(done, healthy, strict=True))
    assert same != pushes


def test_margins_are_the_least_over_the_substeps():
    motion, state = pair(**TILTED), (np.array([1.0, 0.5, 0.2]), *START[1:])
    single = pair(**TILTED, period=0.25, substeps=1)
    done = motion.advance(0.0, *state, FORCE, MOMENT)
    margins = []
    for i in range(20):
        state = single.advance(0.25 * i, *state, FORCE, MOMENT)[:4]
        sight = line_of_sight_margin(state[0], *motion.line_of_sight)
        margins.append((sight, clearance(state[0], state[2], DEPUTY, CHIEF)))
    assert difference(done, state) < 1e-13
    assert np.allclose(done[4:], np.min(margins, axis=0), rtol=0.0, atol=1e-13)


# --- arguments and kernels ------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"period": 0.0}, "control_period: received 0.0"),
        ({"substeps": 0}, "substeps: received 0"),
        ({"inertia": np.diag([1.0, 1.0, 3.0])}, "inertia: received"),
        ({"spin": -1.0}, "spin_rate: received -1.0"),
        ({"line_of_sight": (-1.0, 0.0)}, "line_of_sight: received"),
    ],
)
def test_impossible_arguments_are_refused(options, message):
    with pytest.raises(ParameterError, match=message):
        pair(**options)


def test_a_state_of_another_shape_is_refused():
    with pytest.raises(ShapeError, match="port_velocity: received"):
        pair().advance(0.0, START[0], np.zeros(2), START[2], START[3], FORCE, MOMENT)


def test_period_of_a_chief_at_rest_is_infinite():
    assert ChiefMotion(N, 0.0).period == math.inf
    assert math.isclose(ChiefMotion(N, SPIN).period, 1000.0)


PROGRAM = """
import sys
import numpy as np
from docking_pair import pair, rotation
found = {}
for gradient in (False, True):
    motion = pair(tilt=0.7, gravity_gradient=gradient, two_body=gradient)
    state = (np.array([20.0, 4.0, -3.0]), np.zeros(3), rotation([0.3, -0.2, 0.25]), np.zeros(3))
    some = np.array([True, False, True, True, True, True])
    done = motion.advance(5.0, *state, np.array([0.1, 0.2, 0.3]), np.full(3, 0.02), some)
    found |= {f"{name}_{gradient}": value for name, value in done._asdict().items()}
np.savez(sys.argv[1], **found)
"""


def test_compiled_and_interpreted_kernels_agree(tmp_path):
    compiled, interpreted = compiled_and_interpreted(PROGRAM, tmp_path)
    for name, value in compiled.items():
        assert np.abs(value - interpreted[name]).max() < 1e-12, name
