"""The live page shows the attitude and the wheel speeds of a flight."""

from __future__ import annotations

import numpy as np
import pytest
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
    speeds = np.array([[row[names.index(f"strip_{i}")] for i in range(4)] for row in rows])
    assert speeds == pytest.approx(np.array([state.wheel_speed for state in states[:-1]]), rel=1e-6)
    assert names[-4:] == ("q_x", "q_y", "q_z", "q_w")


def test_the_page_is_told_what_the_curves_are(watched):
    flight, states = watched
    told = flight.setup.as_json()
    assert told["strip"] == {
        "title": "Wheel speeds",
        "unit": "rad/s",
        "names": ("wheel 1", "wheel 2", "wheel 3", "wheel 4"),
    }
    picture = flight.picture().as_json(flight.setup)
    assert picture["strip"] == pytest.approx(states[0].wheel_speed)
    assert picture["torque"] is None
    assert picture["target_error_deg"] > 10.0
