"""What the live page and the dashboard show of a planned flight."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from live.watching import Wall

from spacecraft_gnc.analysis.live.recorded import RecordedFlight
from spacecraft_gnc.analysis.reader import RecordedRun
from spacecraft_gnc.analysis.run_info import RunInfo
from spacecraft_gnc.governors.planned.report import Phase
from spacecraft_gnc.scenario import load
from spacecraft_gnc.vehicles.rigid_body.live import LIVE
from spacecraft_gnc.vehicles.rigid_body.planner.live import common


@pytest.fixture(scope="module")
def scenario():
    return load("phogat_figure4")


@pytest.fixture(scope="module")
def flown(scenario):
    return scenario.build().run()


def played(flown, scenario, wall):
    flight = RecordedFlight(
        RecordedRun(flown, RunInfo(path=Path("figure4"), scenario=scenario)), "figure4", 1.0, wall
    )
    flight.transport.begin()
    return flight


def test_a_step_along_the_plan(flown, scenario):
    wall = Wall()
    flight = played(flown, scenario, wall)
    wall.now += 10.05
    values = flight.picture().values
    assert (values["plan"], values["plan_phase"]) == (0, "flying")
    assert np.array_equal(values["plan_torque"], flown.plan_torque[100])
    assert values["torque_use"] == pytest.approx(np.abs(flown.torque[100]).max() / 20.0)
    assert values["momentum_use"] == pytest.approx(1.0)  # y is on its bound
    lines = {line.label: line for line in LIVE.readouts(values, governed=False)["plan"]}
    assert lines["phase"].text == "flying"
    assert lines["momentum used"] == ("momentum used", "100 %", "")
    assert "plan 0 flying" in LIVE.line(values)[-1]
    wall.now += 14.0
    assert flight.picture().values["plan_phase"] == "arrived"
    json.dumps(flight.picture().as_json() | flight.setup.as_json(), allow_nan=False)


def test_what_a_reader_should_notice(flown, scenario):
    torque, phase = flown.torque.copy(), flown.plan_phase.copy()
    torque[0, 2], phase[0] = -20.1, Phase.NOT_FOUND
    lost = replace(flown, torque=torque, plan_phase=phase)
    values = played(lost, scenario, Wall()).picture().values
    lines = {line.label: line for line in LIVE.readouts(values, governed=False)["plan"]}
    assert lines["torque used"] == ("torque used", "100.5 %", "bad")
    assert lines["phase"] == ("phase", "not found", "bad")


def test_panels_of_a_plan_have_its_bounds(scenario):
    panels = {panel.name: panel for panel in LIVE.panels(scenario)}
    assert (panels["torque"].limit, panels["torque"].norm) == (20.0, "")
    assert (panels["momentum"].limit, panels["plan_torque"].limit) == (70.0, 20.0)
    assert set(panels["plan"].colors) == {"flying", "arrived", "replanning", "not found"}
    others = {panel.name for panel in LIVE.panels(load("gupta2015_case1"))}
    assert not others & {"plan", "plan_error", "plan_torque"}


def test_a_flight_without_a_plan_says_nothing_of_one():
    values = LIVE.values({"plan": -1, "plan_phase": -1, "plan_error": math.nan}, {"zones": ()})
    assert LIVE.readouts(values, governed=False)["plan"] == []
    assert not any("plan" in text for text in LIVE.line(values))
    assert math.isnan(values["plan_error_deg"])


@pytest.mark.parametrize(
    ("sides", "expected"),
    [
        ([[-2.0] * 3, [2.0] * 3], 2.0),
        ([[-2.0] * 3, [2.0, 2.0, 3.0]], 0.0),
        ([[-np.inf] * 3, [np.inf] * 3], 0.0),
    ],
)
def test_a_limit_is_drawn_where_all_bounds_are_the_same(sides, expected):
    assert common(np.array(sides)) == expected
