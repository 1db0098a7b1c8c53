"""Flights with two wheels on the exact plant: from near, from half turns, by every model."""

from __future__ import annotations

import math

import numpy as np
import pytest
from two_wheels import scenario_of, two_wheels

from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.scenario import from_sections
from spacecraft_gnc.vehicles.two_wheel.controllers.report import Terminal

REPORT = (0.5, 0.3, -0.4)


def _flown(scenario):
    flight = scenario.build().run()
    return flight, summarize(flight, scenario)


@pytest.mark.parametrize(
    ("start", "time"), [(REPORT, 560.0), ((0.2, 0.1, -0.1), 430.0), ((0.0, 0.0, 0.25), 510.0)]
)
def test_it_settles_in_the_time_that_is_asked_for(start, time):
    flight, found = _flown(scenario_of(start))
    assert found["settle_time"] is not None
    assert found["settle_time"] <= time
    assert found["max_wheel_speed"] <= 100.0 * (1.0 + 1e-12)
    assert found["max_wheel_acceleration"] <= 5.0 * (1.0 + 1e-12)
    assert found["momentum_drift"] == 0.0
    assert set(flight.source) == {Source.OPTIMAL}


@pytest.mark.parametrize("model", ["simplified", "euler_321"])
def test_the_other_models_bring_it_to_rest_too(model):
    _, found = _flown(scenario_of(REPORT, prediction_model=model))
    assert found["settle_time"] is not None
    assert found["settle_time"] <= 700.0


@pytest.mark.parametrize(
    "start",
    [
        (math.pi, 0.0, 0.0),
        pytest.param((0.0, 0.0, math.pi), marks=pytest.mark.long),  # "far" has waypoints too
        (0.3, math.pi / 2, -0.2),
        (-1.25, -0.237, -2.827),
    ],
    ids=["half turn about a wheel", "half turn about the third axis", "pitch 90 deg", "far"],
)
def test_every_turn_is_flown(start):
    flight, found = _flown(scenario_of(start, steps=180))
    assert found["settle_time"] is not None
    assert found["max_wheel_speed"] <= 100.0 * (1.0 + 1e-12)
    reached = flight.terminal == Terminal.REFERENCE
    first = int(np.argmax(reached))
    assert reached[first:].all()  # a plan that ends at the target stays possible
    assert set(flight.terminal[:first]) <= {Terminal.WAYPOINT, Terminal.SOFT}


def test_no_waypoint_is_farther_from_the_target_than_the_one_before():
    scenario = scenario_of((0.0, 0.0, 2.0), steps=60)
    plant, controller = scenario.build_plant(), scenario.build_controller()
    reference = scenario.build_governor().decide(None).reference
    planner, left = controller.pilot.planner, []
    for _ in range(60):
        command = controller.command(plant.state, reference)
        left.append(planner.path_left)
        plant.step(command.control)
    assert left[0] > 500.0
    assert (np.diff(left) <= 1e-9).all()
    assert left[-1] == 0.0


def test_the_same_flight_twice_is_the_same_bit_for_bit():
    one, other = (scenario_of((0.0, 0.0, 1.0), steps=12).build().run() for _ in range(2))
    assert np.array_equal(one.wheel_acceleration, other.wheel_acceleration)


FAR = (0.0, 0.0, 3.1)


@pytest.mark.parametrize(
    ("start", "limits", "time"),
    [
        (REPORT, (0.0, 0.0), 500.0),
        (FAR, (0.0, 0.0), 1050.0),
        (REPORT, (100.0, 0.0), 500.0),
        (REPORT, (0.0, 5.0), 500.0),
        pytest.param(REPORT, (1e6, 1e6), 500.0, marks=pytest.mark.long),  # as without any
    ],
    ids=["none", "none, far", "no acceleration", "no speed", "beyond use"],
)
def test_wheels_without_a_limit_settle_no_later(start, limits, time):
    """No limit gives a plan no length of time to measure by: the turn of a step does."""
    plant = dict(zip(("max_wheel_speed", "max_wheel_acceleration"), limits, strict=True))
    scenario = from_sections(two_wheels(plant={**plant, "initial_euler_321": list(start)}))
    flight, found = _flown(scenario)
    assert found["settle_time"] is not None
    assert found["settle_time"] <= time
    assert found["final_error_deg"] < 0.01
    reached = flight.terminal == Terminal.REFERENCE
    assert reached[int(found["settle_time"] / 10.0) :].all()


def test_wheels_faster_than_any_plan_are_braked_first():
    speeds = [3000.0, -1000.0]  # some 3 rad a step
    plant = {
        "max_wheel_speed": 0.0, "max_wheel_acceleration": 50.0, "initial_wheel_speed": speeds,
        "initial_total_momentum": [0.0, 0.0, 0.0],
    }  # fmt: skip
    flight, found = _flown(from_sections(two_wheels(plant=plant)))
    assert flight.source[0] == Source.FEEDBACK
    assert flight.wheel_acceleration[0] == pytest.approx([-50.0, 50.0])
    assert found["settle_time"] is not None


@pytest.mark.parametrize("start", [REPORT, (0.0, 0.0, 2.0)])
def test_the_shortest_horizon_of_the_proof_settles(start):
    """Below it a spacecraft may stop on the way, which is refused."""
    _, found = _flown(scenario_of(start, steps=300, horizon=4))
    assert found["settle_time"] is not None
