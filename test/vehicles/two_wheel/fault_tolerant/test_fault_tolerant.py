"""Flights that lose wheels: each kind, each wheel, several times, with and without momentum."""

from __future__ import annotations

import math

import numpy as np
import pytest
from wheel_losses import FOUR, THREE, scenario_sections

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.loop.protocols import Reference, Source
from spacecraft_gnc.scenario import InvalidScenario, from_sections
from spacecraft_gnc.vehicles.two_wheel.controllers.report import Mode, Rest, diagnosis_of, solve_of
from spacecraft_gnc.vehicles.two_wheel.summary import lines

MOMENTUM = [0.5, 0.2, -0.3]  # [N m s]


def scenario(name=THREE, lost=None, controller=None, **plant):
    """A shipped scenario with other losses and further values."""
    return from_sections(scenario_sections(name, lost, controller, **plant))


def flown(one):
    """The flight of a scenario, its metrics, and the diagnosis of each step."""
    loop = one.build()
    told = []
    command = loop.controller.command

    def heard(state, reference):
        answer = command(state, reference)
        told.append(diagnosis_of(answer))
        return answer

    loop.controller.command = heard
    flight = loop.run()
    return flight, summarize(flight, one), told


def require_good(flight, found, within=0.6):
    """The pointing, bounds and momentum that the issue asks for."""
    assert found["final_error_deg"] < within
    assert found["max_wheel_speed"] <= 100.0
    assert found["max_wheel_acceleration"] <= 5.0
    assert found["momentum_drift"] == 0.0
    assert not set(np.unique(flight.source)) & {Source.ZERO, Source.FEEDBACK}


LONG = pytest.mark.long


@pytest.mark.parametrize("kind", [pytest.param("friction", marks=LONG), "partial"])
@pytest.mark.parametrize(
    ("wheel", "time"),
    [
        pytest.param(0, 250.0, marks=LONG),
        pytest.param(1, 20.0, marks=LONG),
        (1, 100.0),
        pytest.param(2, 0.0, marks=LONG),
        pytest.param(2, 100.0, marks=LONG),
        pytest.param(2, 250.0, marks=LONG),
    ],
)
def test_with_two_wheels_left_the_slew_is_finished(kind, wheel, time):
    flight, found, told = flown(scenario(lost={wheel: time}, wheel_loss=kind))
    require_good(flight, found, 0.02)
    assert found["settle_time"] <= 700.0
    assert time < found["wheel_loss_detected_at"] <= time + 30.0
    after = int(found["wheel_loss_detected_at"] / 10.0)
    healthy = np.arange(3) != wheel
    assert [one.mode for one in told] == after * [Mode.NOMINAL] + (100 - after) * [
        Mode.UNDERACTUATED
    ]
    assert all(np.array_equal(one.healthy, healthy) for one in told[after:])
    assert {one.rest for one in told} == {Rest.AT_TARGET}
    assert abs(flight.final_wheel_speed[wheel]) < 1e-3


@pytest.mark.parametrize("kind", ["friction", "partial", "spinning"])
@pytest.mark.parametrize("wheel", range(4))
def test_with_three_wheels_left_the_slew_goes_on(kind, wheel):
    flight, found, told = flown(scenario(FOUR, lost={wheel: 100.0}, wheel_loss=kind))
    require_good(flight, found, 0.01)
    assert found["settle_time"] <= 450.0
    assert 100.0 < found["wheel_loss_detected_at"] <= 130.0
    assert told[-1].mode is Mode.REALLOCATED
    assert told[-1].rest is Rest.AT_TARGET
    assert told[-1].healthy.tolist() == [i != wheel for i in range(4)]


@pytest.mark.parametrize("wheel", range(3))
def test_a_wheel_that_spins_on_leaves_a_rotation_that_is_told_and_held(wheel):
    flight, found, told = flown(scenario(lost={wheel: 100.0}, wheel_loss="spinning"))
    assert found["wheel_loss_detected_at"] == 110.0
    assert found["max_wheel_speed"] <= 100.0
    last, kept = told[-1], flight.final_wheel_speed[wheel]
    assert kept == pytest.approx(flight.wheel_speed[10, wheel], abs=1e-12)
    moments = np.array([430.0, 1210.0, 1300.0])
    expected = -0.043 * kept / moments[wheel] * np.eye(3)[wheel]
    assert (last.mode, last.rest) == (Mode.HOLDING, Rest.NOWHERE)
    assert last.remaining_rate == pytest.approx(expected, rel=1e-12, abs=1e-18)
    assert flight.final_angular_velocity == pytest.approx(last.remaining_rate, abs=1e-9)
    pointing = (flight.final_attitude - last.held_attitude)[:, wheel]
    assert np.linalg.norm(pointing) < 1e-5
    assert last.pointing_loss == 0.0
    axis = np.sign(expected[wheel]) * np.eye(3)[wheel]
    assert found["remaining_axis"] == pytest.approx(axis, abs=1e-12)
    assert found["remaining_rate"] == pytest.approx(abs(expected[wheel]), rel=1e-12)
    said = dict(lines(found))["rest"]
    assert said.startswith("impossible; turns at ")
    assert said.endswith("which points 0 deg off where the target attitude has it")


@pytest.mark.parametrize(("size", "loss_deg"), [(0.2, 29.12), (1.0, 29.12)])
def test_with_momentum_two_wheels_come_to_rest_elsewhere_and_say_so(size, loss_deg):
    momentum = size * np.array(MOMENTUM)
    one = scenario(initial_total_momentum=momentum.tolist(), duration=600.0)
    flight, found, told = flown(one)
    last = told[-1]
    assert found["momentum_drift"] == 0.0
    assert found["max_wheel_speed"] <= 100.0
    assert (last.mode, last.rest) == (Mode.HOLDING, Rest.ELSEWHERE)
    assert not last.remaining_rate.any()
    assert lie.angle_between(flight.final_attitude, last.held_attitude) < math.radians(0.6)
    assert np.linalg.norm(flight.final_angular_velocity) < 1e-4
    assert math.degrees(last.pointing_loss) == pytest.approx(loss_deg, abs=0.01)
    assert (last.held_attitude @ [0.0, 0.0, 1.0]) @ momentum == pytest.approx(0.0, abs=1e-6)


def test_with_momentum_a_fourth_wheel_is_not_missed():
    flight, found, told = flown(scenario(FOUR, initial_total_momentum=MOMENTUM))
    require_good(flight, found, 0.01)
    assert told[-1].mode is Mode.REALLOCATED


def test_wheels_are_lost_one_after_the_other():
    flight, found, told = flown(scenario(FOUR, lost={0: 100.0, 1: 200.0, 2: 400.0}))
    modes = [one.mode for one in told]
    assert modes == 11 * [Mode.NOMINAL] + 10 * [Mode.REALLOCATED] + modes.count(
        Mode.UNDERACTUATED
    ) * [Mode.UNDERACTUATED] + modes.count(Mode.HOLDING) * [Mode.HOLDING]
    assert found["final_error_deg"] < 0.6
    assert np.linalg.norm(flight.final_angular_velocity) < 1e-6
    assert told[-1].rest is Rest.ELSEWHERE
    assert told[-1].healthy.tolist() == [False, False, False, True]


@pytest.mark.parametrize("first", [-1.0, 200.0], ids=["used two", "spare takes over"])
def test_of_three_wheels_in_a_plane_two_are_used_and_the_third_is_to_spare(first):
    axes = [1.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]
    wheels = {"wheel_axes": axes, "wheel_inertias": [0.043] * 4, "initial_wheel_speed": [0.0] * 4}
    one = scenario(FOUR, lost={0: first, 3: 100.0}, **wheels)
    flight, found, told = flown(one)
    require_good(flight, found, 0.02)
    assert told[-1].mode is Mode.UNDERACTUATED
    assert told[-1].healthy.tolist() == [first < 0.0, True, True, False]
    assert np.abs(flight.wheel_speed[13:20, 2]).max() < 1e-9
    assert (np.abs(flight.wheel_speed[21:, 2]).max() > 10.0) == (first > 0.0)


@pytest.mark.parametrize(
    ("viscous", "coulomb"),
    [(1e-5, 1e-4), pytest.param(1e-4, 1e-3, marks=LONG)],
    ids=["little", "much"],
)
def test_friction_of_the_bearings_is_no_loss_and_hides_none(viscous, coulomb):
    rub = {"wheel_viscous_friction": [viscous] * 3, "wheel_coulomb_friction": [coulomb] * 3}
    _, found, _ = flown(scenario(lost={}, duration=5000.0, **rub))
    assert found["wheel_loss_detected_at"] is None
    assert found["final_error_deg"] < 0.01
    flight, found, _ = flown(scenario(**rub))
    require_good(flight, found)
    assert found["wheel_loss_detected_at"] <= 130.0


def test_a_larger_bound_of_friction_is_taken_from_the_controller():
    believed = {"wheel_coulomb_friction": [0.05] * 3}
    _, _, told = flown(scenario(lost={}, controller=believed, duration=50.0))
    assert told[-1].threshold == pytest.approx(np.full(3, 10.0 * 0.05 / 0.043), rel=1e-9)


def test_before_anything_is_known_nothing_is_told():
    controller = scenario().build_controller()
    state, reference = scenario().build_plant().state, Reference(np.eye(3), *np.zeros((2, 3)))
    told = diagnosis_of(controller.command(state, reference))
    assert np.isnan([told.residual, told.threshold, told.response]).all()
    assert told.healthy.all()
    assert told.mode is Mode.NOMINAL


def test_a_state_that_is_none_gives_no_acceleration_and_no_alarm():
    controller, plant = scenario().build_controller(), scenario().build_plant()
    reference = Reference(np.eye(3), *np.zeros((2, 3)))
    state = plant.step(controller.command(plant.state, reference).control)
    broken = controller.command(
        state._replace(wheel_speed=np.array([0.0, math.nan, 0.0])), reference
    )
    assert broken.source is Source.ZERO
    assert not broken.control.any()
    assert diagnosis_of(broken).healthy.all()
    answer = controller.command(plant.step(broken.control), reference)
    assert answer.source is Source.OPTIMAL
    assert diagnosis_of(answer).healthy.all()


def test_it_flies_the_same_again_after_a_reset():
    one = scenario(duration=200.0)
    loop = one.build()
    first = loop.run()
    again = loop.run()
    assert np.array_equal(first.wheel_acceleration, again.wheel_acceleration)
    assert not first.diagnosed.all()


def test_a_lost_wheel_is_commanded_to_stop():
    flight, _, told = flown(scenario(lost={2: 100.0}, wheel_loss="partial"))
    after = np.flatnonzero(~flight.diagnosed[:, 2])
    speeds, commands = flight.wheel_speed[after, 2], flight.wheel_acceleration[after, 2]
    assert (commands * speeds <= 0.0).all()
    assert np.count_nonzero(np.abs(speeds) > 1e-6) <= 4
    assert told[after[0]].response[2] == pytest.approx(0.5, abs=1e-9)


def test_two_wheels_from_the_start_are_refused():
    plant = {"wheel_axes": [1.0, 0.0, 0.0, 1.0, 0.0, 0.0], "wheel_inertias": [0.043] * 2}
    with pytest.raises(InvalidScenario, match="span 2 dimension"):
        scenario(lost={}, initial_wheel_speed=[], wheel_lost_at=[], **plant)


@pytest.mark.parametrize("name", ["wheel_viscous_friction", "wheel_coulomb_friction"])
def test_friction_of_other_wheels_than_there_are_is_refused(name):
    with pytest.raises(InvalidScenario, match=f"nmpc_controller.{name}: .* required 3 numbers"):
        scenario(controller={name: [1e-4]})


def test_commands_that_come_too_late_are_no_failure_of_a_wheel():
    """The plant holds the command before, or none; the wheels are judged by what they were told."""
    one = scenario(lost={})
    plant, controller = one.build_plant(), one.build_controller()
    reference, rng = Reference(np.eye(3), *np.zeros((2, 3))), np.random.default_rng(5)
    held = plant.idle_control
    for _ in range(60):
        command = controller.command(plant.state, reference)
        assert diagnosis_of(command).healthy.all()
        kept = rng.random() < 0.4
        held = held if kept else command.control
        plant.step(plant.idle_control if kept and rng.random() < 0.5 else held)


def test_the_plan_uses_the_wheels_left():
    one = scenario(duration=200.0)
    loop = one.build()
    solves = []
    command = loop.controller.command
    loop.controller.command = lambda *given: solves.append(command(*given)) or solves[-1]
    loop.run()
    first, last = solve_of(solves[0]), solve_of(solves[-1])
    assert (first.method, last.method) == ("shooting", "underactuated")
    assert last.planned.tolist() == [True, True, False]
    assert last.drift.shape == (31, 3)
