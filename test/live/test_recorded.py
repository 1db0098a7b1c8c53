"""A recording shows the step whose time has come, with the recording's own numbers."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from analysis.flights import case1
from live.watching import ZONE, Wall, recorded, without_scenario

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.live import history
from spacecraft_gnc.analysis.live.picture import Phase
from spacecraft_gnc.analysis.live.recorded import RecordedFlight
from spacecraft_gnc.analysis.reader import RecordedRun
from spacecraft_gnc.analysis.run_info import RunInfo
from spacecraft_gnc.drawing.sources import source_name
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.status import Status
from spacecraft_gnc.vehicles.rigid_body.live import status_name


def test_the_step_is_the_last_one_that_began() -> None:
    wall = Wall()
    flight, flown = recorded(wall), case1()
    for elapsed, step in [(0.0, 0), (0.39, 0), (0.41, 1), (10.1, 25)]:
        wall.now = 100.0 + elapsed
        picture = flight.picture()
        assert picture.step == step
        assert picture.phase is Phase.PLAYING
        assert np.array_equal(picture.values["attitude"], flown.attitude[step])
        assert np.array_equal(picture.values["torque"], flown.torque[step])
        assert picture.values["error_deg"] == pytest.approx(
            math.degrees(lie.angle_between(np.eye(3), flown.attitude[step]))
        )
    wall.now += 1000.0
    last = flight.picture()
    assert (last.phase, last.step) == (Phase.OVER, len(flown.time) - 1)


def test_pause_and_seek() -> None:
    wall = Wall()
    flight = recorded(wall)
    flight.transport.control("pause", None)
    flight.transport.control("seek", 20.0)
    wall.now += 5.0
    picture = flight.picture()
    assert (picture.phase, picture.step, picture.time) == (Phase.PAUSED, 50, pytest.approx(20.0))


def test_to_be_late_is_no_error() -> None:
    recorded(Wall()).wait(-1e-9)


def test_the_history_is_the_whole_flight() -> None:
    flight, flown = recorded(Wall()), case1()
    rows = flight.history.since(0)
    assert len(rows) == len(flown.time)
    column = {name: i for i, name in enumerate(history.columns(flight.setup))}
    assert [row[column["time"]] for row in rows] == pytest.approx(flown.time.tolist(), abs=1e-5)
    torques = np.array([row[column["torque"]] for row in rows])
    assert torques == pytest.approx(flown.torque, rel=1e-6)
    quaternion = np.array(rows[40][column["orientation"]])
    assert lie.from_quaternion_xyzw(quaternion / np.linalg.norm(quaternion)) == pytest.approx(
        flown.attitude[40], abs=1e-6
    )


def test_margins_and_limit_come_from_the_scenario() -> None:
    wall = Wall()
    flight, flown = recorded(wall), case1()
    about = flight.setup.as_json()
    assert about["torque_limit"] == 0.01
    assert about["zones"][0]["half_angle_deg"] == ZONE["star"]["half_angle_deg"]
    angle = math.degrees(math.acos(flown.attitude[0][1, 0]))  # between body x and inertial y
    assert flight.picture().values["margins_deg"]["star"] == pytest.approx(angle - 20.0)


def test_what_was_not_recorded_is_not_made_up() -> None:
    flown = case1()
    attitude = flown.attitude.copy()
    attitude[0] = np.nan
    gap = replace(flown, attitude=attitude, alpha=np.full(len(flown.time), np.nan))
    bare = without_scenario(RecordedRun(gap, RunInfo(path=Path("gap"))))
    flight = RecordedFlight(bare, "gap", clock=Wall())
    shown = flight.picture().as_json()
    assert shown["attitude"] is None
    assert shown["error_deg"] is None
    assert shown["decision"] is None
    about = flight.setup.as_json()
    assert (about["torque_limit"], about["zones"]) == (0.0, [])


def test_words_follow_the_constants_of_the_messages() -> None:
    assert [status_name(s) for s in Status] == [s.name.lower().replace("_", " ") for s in Status]
    assert status_name(255) == status_name(-1) == "no solve"
    assert source_name(Source.SHIFTED_PLAN) == "shifted plan"
    assert source_name(-1, "unknown") == "unknown"


def test_a_long_flight_is_thinned_from_end_to_end() -> None:
    n = 10 * history.MOST
    steps = history.chosen_steps(n)
    assert len(steps) == history.MOST
    assert (steps[0], steps[-1]) == (0, n - 1)
    assert max(np.diff(steps)) <= 11


def test_a_live_history_keeps_its_ends_and_says_that_it_was_thinned() -> None:
    kept = history.History()
    first = kept.generation
    for step in range(4 * history.MOST):
        if kept.wants(step):
            kept.append([step])
    rows = [row[0] for row in kept.since(0)]
    assert len(rows) <= history.MOST
    assert rows[0] == 0
    assert rows[-1] > 4 * history.MOST - 2 * kept.stride
    assert set(np.diff(rows)) == {kept.stride}
    assert kept.generation != first
    assert history.History().generation not in (first, kept.generation)
