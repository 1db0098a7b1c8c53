"""The live page shows the attitude and the wheel speeds of a flight."""

from __future__ import annotations

import numpy as np
import pytest
from live.watching import Wall
from wheel_bags import fly, sections

from spacecraft_gnc.analysis.live.history import columns
from spacecraft_gnc.analysis.live.recorded import RecordedFlight
from spacecraft_gnc.analysis.reader import load_run


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


def test_a_wheel_that_does_not_answer_stands_out(tmp_path):
    flight = RecordedFlight(load_run(fly(tmp_path)[0]), "lost", clock=Wall())
    flight.transport.control("seek", 2.0)
    wheels = flight.picture().readouts(flight.setup)["wheels"]
    assert [line.mood for line in wheels] == ["", "bad", "", ""]
    assert wheels[1].text.endswith("rad/s, lost")
