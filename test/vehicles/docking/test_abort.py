"""Lost thruster directions: no false alarm, the right diagnosis, a retreat without collision."""

from __future__ import annotations

import numpy as np
import pytest
from docking_flights import quick
from docking_pair import rotation

from spacecraft_gnc import lie
from spacecraft_gnc.vehicles.docking.build import believed_motion, periodic_model, plant
from spacecraft_gnc.vehicles.docking.decision import Phase
from spacecraft_gnc.vehicles.docking.governors.diagnosis import AXES, Noise, ThrusterMonitor
from spacecraft_gnc.vehicles.docking.governors.turn import Turn
from spacecraft_gnc.vehicles.docking.state import DIRECTIONS, RelativeReference

HOLD = np.array([10.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def loop():
    """Closed loop with one set, whose plant each flight replaces."""
    return quick().build()


def fly(loop, name="afrl_docking", **changes):
    loop.plant = plant(quick(name, **changes))
    return loop.run()


# --- diagnosis ------------------------------------------------------------------------------


def monitor(scenario, noise=None):
    p = scenario.plant
    noise = Noise() if noise is None else noise
    return ThrusterMonitor(periodic_model(scenario), p.deputy_port, 1.0, scenario.period, noise)


@pytest.mark.parametrize("name", ["afrl_docking", "afrl_docking_tilted", "afrl_docking_noise"])
def test_no_flight_with_all_thrusters_raises_an_alarm(name):
    nominal = quick(name)
    flown, controller = nominal.build_plant(), nominal.build_controller()
    noisy = name == "afrl_docking_noise"
    watch = monitor(nominal, Noise(1e-3, 2e-4, 2e-3, 1e-4) if noisy else None)
    errors = []
    for _ in range(120):
        lost, error = watch.look(flown.state)
        assert lost == -1
        errors.append(error)
        halfway = np.concatenate([0.5 * flown.state.port_offset, np.zeros(3)])
        command = controller.command(flown.state, RelativeReference.of(halfway))
        flown.step(command.control)
    assert np.nanmax(errors) < (watch.threshold if noisy else 0.1 * watch.threshold)


@pytest.mark.parametrize("index", range(6))
def test_each_direction_is_found_in_the_step_in_which_it_is_missed(index):
    turned = {
        "plant__initial_rotation_vector": [0.4, -0.3, 0.5],
        "plant__initial_angular_velocity": [0.01, 0.02, -0.015],
    }
    scenario = quick(plant__thruster_lost=DIRECTIONS[index], **turned)
    flown, watch = scenario.build_plant(), monitor(scenario)
    along = flown.state.attitude @ AXES[index]
    other = flown.state.attitude @ np.roll(AXES[index], 1)
    unused = np.concatenate([0.5 * other - 0.3 * along, np.zeros(3)])
    watch.look(flown.state)
    lost, error = watch.look(flown.step(unused))
    assert lost == -1
    assert error < watch.threshold
    used = np.concatenate([0.5 * other + 0.3 * along, np.zeros(3)])
    lost, error = watch.look(flown.step(used))
    assert lost == index
    assert error > 1e3 * watch.threshold
    watch.reset()
    assert watch.look(flown.state)[0] == -1


def test_a_heavier_deputy_than_believed_is_no_lost_thruster():
    heavy = quick(plant__mass=150.0, nmpc_controller__mass=130.0)
    flown, watch = heavy.build_plant(), monitor(heavy)
    for k in range(20):
        force = np.array([np.sin(k), np.cos(2.0 * k), 0.3 * np.sin(3.0 * k)])
        assert watch.look(flown.state)[0] == -1
        flown.step(np.concatenate([force, np.zeros(3)]))
    assert watch.look(flown.state)[1] > watch.threshold  # the miss is told all the same


def test_a_gap_in_the_states_is_not_compared_and_a_repeated_one_changes_nothing():
    flown, watch = quick().build_plant(), monitor(quick())
    states = [flown.state, *(flown.step(np.full(6, 0.01)) for _ in range(4))]
    watch.look(states[0])
    known = watch.look(states[1])
    assert not np.isnan(known[1])
    assert watch.look(states[1]) == known
    assert np.isnan(watch.look(states[4])[1])


# --- turn -----------------------------------------------------------------------------------


def test_a_turn_goes_as_foretold():
    still = quick(plant__initial_port_offset=[10.0, 0.0, 0.0], plant__chief_spin_rate=0.0)
    flown, motion = still.build_plant(), believed_motion(still)
    turn = Turn(motion.inertia, motion.deputy.port, 0.05, still.period, 40)
    goals = np.array([rotation([0.0, 0.0, -1.5]), np.eye(3)])
    state = flown.state
    foretold = turn.foretold(state.attitude, state.angular_velocity, goals)[0]
    for k in range(40):
        state = flown.state
        angle = lie.angle_between(foretold[k], state.attitude)
        assert angle < 0.1
        moment = turn.moment(state.attitude, state.angular_velocity, goals[0])
        assert np.abs(moment).max() <= 0.05
        flown.step(np.concatenate([np.zeros(3), moment]))
    assert lie.angle_between(flown.state.attitude, goals[0]) < 0.02


# --- flights --------------------------------------------------------------------------------

CASES = [("+x", 60.0), ("+x", 90.0), ("+x", 150.0), ("+y", 100.0), ("+z", 0.0)]
CASES += [("-x", 100.0), ("-y", 60.0), ("-z", 120.0)]


@pytest.mark.parametrize(("lost", "at"), CASES)
def test_after_a_loss_the_deputy_retreats_without_collision(loop, lost, at):
    flight = fly(loop, plant__thruster_lost=lost, plant__thruster_lost_at=at, plant__duration=600.0)
    known = flight.lost_thruster >= 0
    first = int(np.argmax(known))
    assert known[first:].all()
    assert (flight.lost_thruster[known] == DIRECTIONS.index(lost)).all()
    assert flight.time[first] > at
    used = [R.T @ F for R, F in zip(flight.attitude, flight.force, strict=True)]
    along = np.array(used) @ AXES[DIRECTIONS.index(lost)]
    least = 1e-6 * 130.0 / 5.0  # [N] that is noticed
    assert along[first - 1] > 0.9 * least  # in the step after which it is told
    assert along[(flight.time >= at) & ~known][:-1].max(initial=0.0) < 1.1 * least
    assert min(flight.clearance.min(), flight.final_clearance) > 0.0
    assert np.abs(flight.force).max() <= 1.0 + 1e-9
    assert np.abs(flight.moment).max() <= 0.05 + 1e-9
    assert set(flight.phase[:first]) == {Phase.DOCKING}
    assert flight.phase[-1] == Phase.HOLDING
    assert np.linalg.norm(flight.final_port_offset - HOLD) < 0.5
    assert np.linalg.norm(flight.final_port_velocity) < 0.01


def test_the_reference_is_for_the_law_of_the_controller_whatever_the_governor():
    mixed = quick(nmpc_controller__method="periodic_lqr", plant__thruster_lost="-y")
    plant, controller = mixed.build_plant(), mixed.build_controller()
    governor = mixed.build_governor()
    for _ in range(40):
        decision = governor.decide(plant.state)
        command = controller.command(plant.state, decision.reference)
        if decision.phase != Phase.DOCKING:
            assert np.abs(command.control).max() <= 1.0 + 1e-9  # by the plan's limits
            assert np.abs(command.control[3:]).max() <= 0.05 + 1e-9
        plant.step(command.control)
    assert decision.phase == Phase.HOLDING


def test_a_loss_that_is_never_missed_changes_nothing(loop):
    plain = fly(loop, plant__duration=300.0)
    lost = fly(
        loop, plant__thruster_lost="+x", plant__thruster_lost_at=285.0, plant__duration=300.0
    )
    assert np.array_equal(plain.port_offset, lost.port_offset)
    assert (lost.lost_thruster == -1).all()


def test_an_abort_begins_anew_after_a_reset(loop):
    changes = {"plant__thruster_lost": "+x", "plant__thruster_lost_at": 90.0}
    first, second = (fly(loop, plant__duration=200.0, **changes) for _ in range(2))
    assert np.array_equal(first.reference, second.reference)
    assert np.array_equal(first.final_port_offset, second.final_port_offset)


def test_without_abort_a_loss_is_told_and_docking_goes_on():
    stubborn = quick(
        plant__thruster_lost="+z",
        plant__duration=100.0,
        reference_governor__aborts=False,
    )
    flight = stubborn.build().run()
    assert flight.lost_thruster[-1] == DIRECTIONS.index("+z")
    assert set(flight.phase) == {Phase.DOCKING}
