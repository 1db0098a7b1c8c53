"""Formation plant: steps, the limit of the impulses, lost craft, messages."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spacecraft_gnc.errors import GncError
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.vehicles.formation.dynamics import FormationMotion
from spacecraft_gnc.vehicles.formation.orbit import orbital_period
from spacecraft_gnc.vehicles.formation.plant import FormationPlant
from spacecraft_gnc.vehicles.formation.signals import STATE
from spacecraft_gnc.vehicles.formation.two_body import TwoBodyMotion

ALTITUDE = 350e3
T = orbital_period(ALTITUDE) / 50
HILL = FormationMotion(ALTITUDE, T)
J2 = FormationMotion(ALTITUDE, T, TwoBodyMotion(ALTITUDE, T, 0.9))
POSITION = np.array([[1000.0, -1500.0, 700.0], [-400.0, 9000.0, -2000.0], [0.0, 100.0, 0.0]])
VELOCITY = np.array([[0.3, -2.0, 0.5], [-0.1, 0.9, 1.5], [0.0, 0.1, 0.0]])
COMMAND = np.array([[0.6, -0.4, 0.1], [-0.2, 0.3, 0.4], [0.1, 0.1, 0.1]])


def plant(motion=HILL, **changes):
    given = {"position": POSITION, "velocity": VELOCITY, "n_steps": 5, "max_delta_v": 1.0}
    return FormationPlant(motion, **(given | changes))


def same(first, second):
    """Whether two states are of the same motion."""
    return all(np.array_equal(a, b) for a, b in zip(first[1:3], second[1:3], strict=True))


@pytest.mark.parametrize("motion", [HILL, J2], ids=["hill", "j2"])
def test_a_step_is_an_impulse_and_free_motion_for_a_period(motion):
    flown = plant(motion)
    state = flown.step(COMMAND)
    assert state is flown.state
    assert state.step == 1
    expected = motion.advance(0, POSITION, VELOCITY, COMMAND)
    assert np.array_equal(state.position, expected[0])
    assert np.array_equal(state.velocity, expected[1])
    assert np.array_equal(state.applied, COMMAND)
    second = flown.step(flown.idle_control)
    later = motion.advance(1, *expected, np.zeros((3, 3)))
    assert np.array_equal(second.position, later[0])
    flown.reset()
    assert flown.state.step == 0
    assert not flown.state.applied.any()
    assert same(flown.step(COMMAND), state)


@given(
    st.lists(st.floats(-3.0, 3.0), min_size=9, max_size=9),
    st.floats(0.1, 3.0),
)
def test_the_norm_of_an_impulse_is_limited_and_its_direction_kept(numbers, limit):
    asked = np.reshape(numbers, (3, 3))
    free = plant().step(np.zeros((3, 3)))
    state = plant(max_delta_v=limit).step(asked)
    assert np.array_equal(state.applied, asked)
    # What was given, from the change of position, x_k+1 = A (x_k + dv).
    given_ = np.linalg.solve(HILL.transition[:3, 3:], (state.position - free.position).T).T
    size = np.linalg.norm(asked, axis=1)
    expected = asked * np.minimum(1.0, limit / np.maximum(size, 1e-300))[:, None]
    assert given_ == pytest.approx(expected, abs=1e-9)


def test_within_the_limit_an_impulse_keeps_its_bits_and_beyond_it_is_given_whole_on_request():
    assert same(plant().step(COMMAND), plant(saturates=False).step(COMMAND))
    beyond = 3.0 * COMMAND
    assert not same(plant().step(beyond), plant(saturates=False).step(beyond))
    expected = HILL.advance(0, POSITION, VELOCITY, beyond)
    assert np.array_equal(plant(saturates=False).step(beyond).position, expected[0])
    one = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 4.0], [0.6, 0.0, 0.8]])
    limited = np.array([[0.0, 0.0, 0.0], [0.6, 0.0, 0.8], [0.6, 0.0, 0.8]])
    assert plant().step(one).position == pytest.approx(plant().step(limited).position, abs=1e-9)
    huge = np.full((3, 3), 1e200)
    assert np.isfinite(plant().step(huge).position).all()


@pytest.mark.parametrize("motion", [HILL, J2], ids=["hill", "j2"])
@pytest.mark.parametrize("row", [0, 2])
def test_a_lost_craft_makes_no_impulse_from_its_step_on(motion, row):
    flown = plant(motion, lost=(row,), lost_at=T + 0.1)  # in the second step: from the third on
    for k in range(4):
        before = flown.state
        assert before.healthy.tolist() == [i != row or k < 2 for i in range(3)]
        after = flown.step(COMMAND)
        told = motion.advance(k, *before[1:3], COMMAND)
        free = motion.advance(k, *before[1:3], np.zeros((3, 3)))
        for i in range(3):
            expected = told if i != row or k < 2 else free
            assert np.array_equal(after.position[i], expected[0][i])
        assert np.array_equal(after.applied, COMMAND)


def test_a_loss_at_the_start_of_a_step_takes_effect_in_it():
    flown = plant(lost=(0,), lost_at=3.0 * T)
    healthy = [flown.state.healthy[0]]
    healthy.extend(flown.step(COMMAND).healthy[0] for _ in range(4))
    assert healthy == [True, True, True, False, False]
    assert not plant(lost=(1, 2)).state.healthy[1:].any()


def test_outputs_are_the_state_with_the_sources_of_its_impulses():
    flown = plant()
    [(signal, motion)] = flown.outputs((flown.idle_control, Source.ZERO))
    assert signal is STATE
    assert motion.state is flown.state
    assert motion.sources == (Source.ZERO,) * 3
    flown.step(COMMAND)
    sources = (Source.METHOD, Source.ZERO, Source.METHOD)
    [(_, motion)] = flown.outputs((COMMAND, sources))
    assert motion.sources == sources
    assert motion.state.step == 1


def test_two_craft_are_enough():
    flown = plant(position=POSITION[:2], velocity=VELOCITY[:2])
    assert flown.idle_control.shape == (2, 3)
    assert np.array_equal(flown.step(COMMAND[:2]).position, plant().step(COMMAND).position[:2])


def test_states_are_read_only():
    flown = plant()
    for state in (flown.state, flown.step(COMMAND)):
        for array in state[1:]:
            assert not array.flags.writeable


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"n_steps": 0}, "n_steps: received 0"),
        ({"max_delta_v": 0.0}, "max_delta_v: received 0.0"),
        ({"lost": (3,)}, "lost: received 3"),
        ({"lost": (0,), "lost_at": -1.0}, "lost_at: received -1"),
        ({"position": [[math.nan] * 3] * 3}, "position: received"),
        ({"velocity": VELOCITY[:2]}, "velocity: received an array of shape"),
        ({"position": np.zeros((0, 3))}, "position, in craft: received 0"),
    ],
)
def test_impossible_arguments_are_refused(changes, message):
    with pytest.raises(GncError, match=message):
        plant(**changes)


@pytest.mark.parametrize("delta_v", [np.zeros(3), np.full((3, 3), math.nan)])
def test_impulses_that_are_not_three_numbers_for_each_craft_are_refused(delta_v):
    with pytest.raises(GncError, match="delta_v: received"):
        plant().step(delta_v)
