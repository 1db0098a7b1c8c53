"""Scenarios that fly plans: on the plan, disturbed, replanned; refusals and repetition."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.governors.planned.report import Cause, Phase
from spacecraft_gnc.scenario import InvalidScenario, load
from spacecraft_gnc.types import Reference

FIGURE_4, Y90 = "phogat_figure4", "phogat_y90"
DISTURBED, REPLANNED = "phogat_figure4_disturbed", "phogat_replanned"
BOUNDS = (20.0, 70.0)
BELIEVED = np.diag([800.0, 1200.0, 1000.0])
TOUCH = 1e-9
LARGEST_END_ERROR = 0.5  # [deg]
GOVERNED = {
    "nmpc_controller.method": "shooting",
    "reference_governor.governor": "planned",
    "reference_governor.plan.duration": 19.0,
    "reference_governor.plan.torque_bounds": [20.0],
    "reference_governor.plan.momentum_bounds": [70.0],
}


def flight_of(name, **changes):
    scenario = load(name, changes)
    return scenario, scenario.build().run()


def end_error_deg(scenario, flight):
    goal = lie.exp(scenario.governor.target_rotation_vector)
    return math.degrees(lie.angle_between(flight.final_attitude, goal))


def require_bounds(flight):
    assert np.abs(flight.torque).max() <= BOUNDS[0]
    assert np.abs(flight.momentum).max() <= BOUNDS[1] + TOUCH


@pytest.mark.parametrize(
    ("name", "steps", "cost"), [(FIGURE_4, 190, 20965.955), (Y90, 300, 14192.248)]
)
def test_a_body_as_believed_follows_the_plan_to_rounding(name, steps, cost):
    scenario, flight = flight_of(name)
    assert flight.plan_error.max() < 1e-10
    assert np.abs(flight.torque - flight.plan_torque).max() < 1e-9
    assert np.abs(flight.momentum - flight.plan_momentum).max() < 1e-9
    assert 0.5 * np.sum(flight.torque**2) == pytest.approx(cost, abs=1e-3)
    assert not flight.source.any()  # optimal from the first step to the last
    assert end_error_deg(scenario, flight) < 1e-8
    assert not flight.plan.any()
    phases = [Phase.FLYING] * steps + [Phase.ARRIVED] * (flight.n_steps - steps)
    assert flight.plan_phase.tolist() == phases
    require_bounds(flight)


@pytest.mark.parametrize("factor", [0.95, 1.05])
@pytest.mark.parametrize("push", [[0.2, -0.2, 0.2], [-0.2, 0.2, 0.2], [0.0, 0.0, -0.2]])
def test_a_disturbed_body_of_another_inertia_arrives_within_the_bounds(factor, push):
    changes = {"plant.inertia": (factor * BELIEVED).ravel().tolist(), "plant.constant_torque": push}
    scenario, flight = flight_of(DISTURBED, **changes)
    assert end_error_deg(scenario, flight) < LARGEST_END_ERROR
    require_bounds(flight)
    at_the_end_of_the_plan = flight.plan_phase.tolist().index(Phase.ARRIVED)
    assert math.degrees(flight.plan_error[at_the_end_of_the_plan]) < LARGEST_END_ERROR
    assert not flight.plan.any()
    assert flight.plan_error.max() > 1e-3  # it was disturbed


def test_a_command_is_clipped_where_the_tracking_asks_for_more():
    loop = load(DISTURBED, {"nmpc_controller.plan.torque_reserve": 0.0}).build()
    seen = []
    command = loop.controller.command
    loop.controller.command = lambda *given: seen.append(command(*given)) or seen[-1]
    flight = loop.run()
    nominal = np.array([each.report.plan.nominal_torque for each in seen])
    assert np.abs(nominal).max() > BOUNDS[0]
    assert np.abs(flight.torque).max() == BOUNDS[0]
    within = (np.abs(nominal) <= BOUNDS[0]).all(axis=1)
    assert (flight.torque[within] == nominal[within]).mean() > 0.9


@pytest.mark.parametrize("factor", [0.9, 1.1])
def test_a_pushed_body_is_planned_for_anew_and_arrives_within_the_bounds(factor):
    inertia = (factor * BELIEVED).ravel().tolist()
    scenario, flight = flight_of(REPLANNED, **{"plant.inertia": inertia})
    assert end_error_deg(scenario, flight) < LARGEST_END_ERROR
    require_bounds(flight)
    assert flight.plan.max() >= 1
    first = int(np.flatnonzero(flight.plan == 1)[0])
    asked = first - scenario.controller.plan.replan_lead
    assert (flight.plan_phase[asked:first] == Phase.REPLANNING).all()
    limit = math.radians(scenario.controller.plan.replan_error_deg)
    assert flight.plan_error[asked - 1] <= limit < flight.plan_error[asked]
    assert flight.plan_error[first] < flight.plan_error[first - 1]
    assert asked * scenario.period > scenario.plant.push_time


def test_a_replanned_flight_is_repeated_bit_by_bit():
    scenario = load(REPLANNED)
    loop = scenario.build()
    first, again = loop.run(), loop.run()
    other = load(REPLANNED).build().run()
    for name in ("torque", "attitude", "plan_error", "plan", "plan_phase"):
        assert getattr(first, name).tobytes() == getattr(again, name).tobytes()
        assert getattr(first, name).tobytes() == getattr(other, name).tobytes()


def test_without_replanning_the_pushed_body_comes_late():
    never = {"nmpc_controller.plan.replan_error_deg": 0.0}
    _, flight = flight_of(REPLANNED, **never)
    assert not flight.plan.any()
    _, replanned = flight_of(REPLANNED)
    assert flight.plan_error.max() > replanned.plan_error.max()


def test_a_new_target_in_flight_is_planned_for():
    scenario = load(FIGURE_4, {"plant.duration": 60.0})
    plant, controller = scenario.build_plant(), scenario.build_controller()
    controller.warm_up()
    goal = lie.exp(scenario.governor.target_rotation_vector)
    other = goal @ lie.exp([0.0, -1.0, 0.3])
    told = []
    for k in range(scenario.n_steps):
        target = goal if k < 100 else other
        command = controller.command(plant.state, Reference(target, np.zeros(3), np.zeros(3)))
        told += command.report.plan.told
        assert np.abs(command.control).max() <= BOUNDS[0]
        assert np.abs(plant.state.momentum).max() <= BOUNDS[1] + TOUCH
        plant.step(command.control)
    assert [(each.cause, each.first_step) for each in told] == [
        (Cause.START, 0),
        (Cause.TARGET, 105),
    ]
    assert lie.angle_between(plant.state.attitude, other) < 1e-8


@pytest.mark.parametrize("method", ["shooting", "feedback"])
def test_a_governor_publishes_the_plan_for_any_controller_that_tracks(method):
    _, flight = flight_of(FIGURE_4)
    scenario = load(FIGURE_4, GOVERNED | {"nmpc_controller.method": method})
    followed = scenario.build().run()
    assert followed.plan_error.max() < 1e-10
    assert np.abs(followed.torque - flight.torque).max() < 1e-9
    assert (followed.plan_phase == flight.plan_phase).all()


def test_a_governor_plans_for_a_pushed_body_anew():
    scenario = load(
        REPLANNED,
        GOVERNED
        | {"reference_governor.plan.duration": 22.0, "reference_governor.plan.torque_reserve": 0.2}
        | {"reference_governor.plan.momentum_reserve": 0.2}
        | {"reference_governor.plan.replan_error_deg": 0.5},
    )
    flight = scenario.build().run()
    assert flight.plan.max() >= 1
    assert end_error_deg(scenario, flight) < LARGEST_END_ERROR


def lines(changes):
    with pytest.raises(InvalidScenario) as caught:
        load(FIGURE_4, changes).check_cores()
    return [str(problem) for problem in caught.value.problems]


REFUSED = [
    ({"reference_governor.governor": "attitude"}, "reference_governor.governor: .*governor: none"),
    (
        {
            "reference_governor.governor": "turning_reference",
            "reference_governor.reference_rate": [0.0, 0.0, 0.1],
        },
        "reference_governor.governor: received 'turning_reference'; required governor: none",
    ),
    ({"nmpc_controller.max_torque": 20.0}, "max_torque: .*give plan.torque_bounds"),
    (
        {"nmpc_controller.actuators": [1.0, 0.0, 0.0, 1.0, 0.0, 0.0]},
        "actuators: .*about every axis",
    ),
    (
        {
            "nmpc_controller.zone_names": ["sun"],
            "nmpc_controller.zones.sun.kind": "exclusion",
            "nmpc_controller.zones.sun.body_axis": [1.0, 0.0, 0.0],
            "nmpc_controller.zones.sun.inertial_axis": [0.0, 0.0, -1.0],
            "nmpc_controller.zones.sun.half_angle_deg": 5.0,
        },
        "zone_names: .*a plan knows no pointing zones",
    ),
    (
        {"nmpc_controller.plan.duration": 3.0},
        "plan.duration: received 3 s.*required more: 17.6 s is the shortest",
    ),
    ({"nmpc_controller.plan.duration": 19.05}, "plan.duration: .*a whole number of control"),
    ({"plant.initial_momentum": [80.0, 0.0, 0.0]}, "plant.initial_momentum: .*within"),
    ({"nmpc_controller.plan.torque_bounds": [0.0]}, "torque_bounds: "),
    (
        GOVERNED | {"nmpc_controller.method": "terminal_set"},
        "nmpc_controller.method: .*a method that follows a moving reference .governor: planned",
    ),
]


@pytest.mark.parametrize(("changes", "words"), REFUSED)
def test_what_cannot_be_flown_is_refused_in_one_line(changes, words):
    found = lines(changes)
    assert any(re.search(words, line) for line in found), found
    assert all("; required" in line and "\n" not in line for line in found)
