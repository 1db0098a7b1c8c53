"""The live page shows the attitude and the wheel speeds of a flight."""

from __future__ import annotations

import numpy as np
import pytest
from live.watching import Wall
from wheel_bags import fly, sections

from spacecraft_gnc.analysis.live.history import columns
from spacecraft_gnc.analysis.live.recorded import RecordedFlight
from spacecraft_gnc.analysis.reader import load_run
from spacecraft_gnc.vehicles.two_wheel.live import _diagnosis


@pytest.fixture(scope="module")
def watched(tmp_path_factory):
    bag, states = fly(tmp_path_factory.mktemp("flown"), sections(plant={"wheel_lost_at": []}))
    return RecordedFlight(load_run(bag), "slew"), states


def test_every_sample_has_the_speed_of_each_wheel(watched):
    flight, states = watched
    names = columns(flight.setup)
    rows = flight.history.since(0)
    assert {len(row) for row in rows} == {len(names)}
    speeds = np.array([row[names.index("wheel_speed")] for row in rows])
    assert speeds == pytest.approx(np.array([state.wheel_speed for state in states[:-1]]), rel=1e-6)
    accelerations = [row[names.index("wheel_acceleration")] for row in rows]
    assert np.shape(accelerations) == (len(rows), 4)
    assert names[-1] == "orientation"


def test_the_page_is_told_what_the_curves_are(watched):
    flight, states = watched
    panels = {panel["name"]: panel for panel in flight.setup.page_json()["panels"]}
    assert (panels["speed"]["unit"], panels["speed"]["limit"]) == ("rad/s", 40.0)
    drawn = {series["key"] for panel in panels.values() for series in panel["series"]}
    assert drawn <= set(flight.setup.history)
    picture = flight.picture().as_json()
    assert picture["wheel_speed"] == pytest.approx(states[0].wheel_speed)
    assert picture["target_error_deg"] > 10.0


def test_the_page_tells_what_is_believed_of_the_wheels(tmp_path):
    slow = {"initial_wheel_speed": [10.0, -20.0, 15.0, 5.0]}
    flown = sections(plant={**slow, "wheel_loss": "partial"})
    bag = fly(tmp_path, flown, watching=True)[0]
    flight = RecordedFlight(load_run(bag), "watched", clock=Wall())
    before = flight.picture().readouts(flight.setup)["diagnosis"]
    assert [tuple(line) for line in before] == [("flown", "nominal", "")]
    flight.transport.control("seek", 3.0)
    picture = flight.picture()
    told = {line.label: line.text for line in picture.readouts(flight.setup)["diagnosis"]}
    assert told == {"flown": "reallocated", "excluded": "wheel 2", "rest": "at the target"}
    shown = picture.as_json()
    assert shown["diagnosed"] == shown["healthy"] == [True, False, True, True]
    assert np.abs(shown["turning"]).max() <= 1.0
    wheels = flight.setup.page_json()["wheels"]
    assert np.shape(wheels) == (4, 37, 3)
    assert "rims" not in flight.setup.as_json()
    assert flight.setup.vehicle.line(picture.values)[-1] == "flown reallocated"


def test_what_is_held_is_told():
    values = {
        "mode": "holding", "diagnosed": np.array([True, False]), "rest": 2,
        "wheel_residual": np.array([0.0, 0.5]), "wheel_threshold": np.array([0.1, 0.1]),
        "wheel_response": np.array([1.0, 0.25]), "pointing_loss": np.radians(12.0),
        "remaining_rate": np.array([0.0, 3e-4, 4e-4]),
    }  # fmt: skip
    told = {line.label: line.text for line in _diagnosis(values)}
    assert told == {
        "flown": "holding", "excluded": "wheel 2", "residual 2": "0.5 rad/s, bound 0.1",
        "answer 2": "25 % of its command", "rest": "impossible",
        "keeps turning at": "0.5 mrad/s", "about body axis": "0, 0.6, 0.8",
        "axis off the target by": "12°",
    }  # fmt: skip
    at_rest = {line.label for line in _diagnosis({**values, "remaining_rate": np.zeros(3)})}
    assert "held off the target by" in at_rest
    assert not {"keeps turning at", "axis off the target by"} & at_rest


def test_a_wheel_that_does_not_answer_stands_out(tmp_path):
    flight = RecordedFlight(load_run(fly(tmp_path)[0]), "lost", clock=Wall())
    flight.transport.control("seek", 2.0)
    wheels = flight.picture().readouts(flight.setup)["wheels"]
    assert [line.mood for line in wheels] == ["", "bad", "", ""]
    assert wheels[1].text.endswith("rad/s, lost")
