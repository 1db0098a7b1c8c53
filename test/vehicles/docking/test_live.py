"""The live page shows both bodies, margins, phase and what happened of a docking flight."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from browser import console_errors, wait_until
from docked import START, TURNED, aborted, flight, scenario
from live.watching import Wall

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.live.feed import Feed
from spacecraft_gnc.analysis.live.history import columns
from spacecraft_gnc.analysis.live.recorded import RecordedFlight
from spacecraft_gnc.analysis.live.server import PageServer
from spacecraft_gnc.vehicles.docking.live import LIVE
from spacecraft_gnc.vehicles.docking.signals import SIGNALS


def watched(flown, **changes):
    info = SimpleNamespace(scenario=scenario(**changes))
    return RecordedFlight(SimpleNamespace(trajectory=flown, info=info), "docking", clock=Wall())


def told(flight, group, time):
    flight.transport.control("seek", time)
    lines = flight.picture().readouts(flight.setup)[group]
    return {line.label: (line.text, line.mood) for line in lines}


def test_the_page_is_told_of_the_bodies_and_where_they_are():
    flight_ = watched(flight())
    page = flight_.setup.page_json()
    chief, deputy = page["bodies"]
    assert (chief["name"], chief["size"]) == ("chief", [1.04, 1.15, 1.57])
    assert np.shape(page["region"]) == (8, 3)
    assert not {"bodies", "region", "trail"} & set(flight_.setup.as_json())
    picture = flight_.picture().as_json()
    at = np.array(picture["bodies"]["deputy"]["position"])
    port = at + lie.exp(TURNED) @ deputy["port"]
    np.testing.assert_allclose(port - chief["port"], START, atol=1e-5)
    np.testing.assert_allclose(picture["port"], port, atol=1e-5)
    np.testing.assert_allclose(
        np.array(picture["aim"]) - chief["port"], flight().reference[0, :3], atol=1e-5
    )
    assert picture["phase"] == "paused"


def test_every_curve_is_in_the_history():
    flight_ = watched(flight())
    panels = flight_.setup.page_json()["panels"]
    drawn = {series["key"] for panel in panels for series in panel["series"]}
    assert drawn | {"port"} == set(flight_.setup.history) | {"force"}
    names, rows = columns(flight_.setup), flight_.history.since(0)
    assert {len(row) for row in rows} == {len(names)}
    kept = np.array([row[names.index("distance")] for row in rows])
    np.testing.assert_allclose(kept, np.linalg.norm(flight().port_offset, axis=1), rtol=1e-6)
    shown = [row[names.index("clearance_shown")] for row in rows]
    np.testing.assert_allclose(shown, np.minimum(flight().clearance, 0.5), rtol=1e-6)
    bounded = {panel["name"]: panel["limit"] for panel in panels if panel["limit"]}
    assert bounded == {"force": 1.0, "forces": 1.0, "moments": 0.05}


def test_an_abort_stands_out():
    flight_ = watched(aborted())
    assert told(flight_, "thrusters", 95.0) == {}
    assert told(flight_, "thrusters", 105.0) == {"lost": ("+x", "bad")}
    assert told(flight_, "thrusters", 115.0) == {
        "lost": ("+x", "bad"), "taken for lost": ("+x", "warn")
    }  # fmt: skip
    assert told(flight_, "governor", 115.0)["phase"] == ("aborting", "warn")
    assert told(flight_, "governor", 250.0)["phase"] == ("holding", "warn")
    words = LIVE.line(flight_.picture().values)
    assert words[0].startswith("ports 10 m apart")
    assert words[-2:] == ["holding", "lost +x"]


def test_a_false_alarm_is_one():
    wrong = np.full(60, -1)
    wrong[10:] = 4
    assert told(watched(flight(lost_thruster=wrong)), "thrusters", 60.0) == {
        "taken for lost": ("-y, a false alarm", "bad")
    }


@pytest.mark.parametrize(
    ("column", "value", "group", "line", "expected"),
    [
        ("clearance", -0.019, "constraints", "clearance", ("-0.019 m", "")),
        ("clearance", -0.021, "constraints", "clearance", ("-0.021 m", "bad")),
        ("line_of_sight_margin", -0.3, "constraints", "line of sight", ("-0.3 m", "bad")),
        ("slack", -0.02, "governor", "slack", ("-2 %", "bad")),
        ("slack", -1e-12, "governor", "slack", ("0 %", "")),
        ("status", 1, "governor", "reference", ("infeasible", "bad")),
        ("status", 4, "governor", "reference", ("passed", "")),
    ],
)
def test_what_is_broken_stands_out(column, value, group, line, expected):
    values = getattr(flight(), column).copy()
    values[10] = value
    assert told(watched(flight(**{column: values})), group, 50.0)[line] == expected


def test_an_ungoverned_flight_has_no_governor():
    flight_ = watched(flight(), reference_governor={"governor": "none"})
    assert set(flight_.picture().readouts(flight_.setup)) == {"state", "constraints", "thrusters"}
    assert "answer" not in {panel["name"] for panel in flight_.setup.page_json()["panels"]}


def test_nothing_is_known_of_an_empty_row_and_no_scenario():
    constants = LIVE.constants(None)
    values = LIVE.values({}, constants)
    for lines in LIVE.readouts(values, True).values():
        assert [line for line in lines if line.text] == []
    assert LIVE.line(values) == []
    assert LIVE.panels(None)
    lost = LIVE.values({"thrusters": np.array([1.0, 0, 1, 1, 1, 1])}, constants)  # as messages tell
    assert LIVE.line(lost) == ["lost +y"]


def test_a_graph_tells_wrench_and_reference_in_messages():
    row = {
        "port_offset": START, "attitude": lie.exp(TURNED), "wrench": np.arange(6.0),
        "reference_offset": np.array([1.0, 2.0, 3.0]),
    }  # fmt: skip
    values = LIVE.values(row, LIVE.constants(scenario()))
    np.testing.assert_array_equal(values["force"], [0.0, 1.0, 2.0])
    np.testing.assert_array_equal(values["moment"], [3.0, 4.0, 5.0])
    np.testing.assert_allclose(values["aim"], [1.52, 2.0, 3.2])
    known = {f"{signal}/{field}" for signal in SIGNALS for field in signal.fields}
    assert set(LIVE.fields.values()) <= known


def test_the_page_draws_the_ports_where_they_are(browser):
    flight_ = watched(flight())
    feed = Feed(flight_)
    with PageServer(feed, port=0) as server:
        browser.get(server.url)

        def ports():
            feed.tick()
            found = browser.execute_script("return window.view?.state?.ports ?? null")
            return found if found and "deputy" in found else None

        found = wait_until(browser, ports, "both bodies are drawn")
        scale, right = browser.execute_script("return [view.scene.scale, view.scene.right]")
    across = found["deputy"][0] - found["chief"][0]
    assert across == pytest.approx(scale * float(START @ right), rel=1e-4)
    assert console_errors(browser) == []
