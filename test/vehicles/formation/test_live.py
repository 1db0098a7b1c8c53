"""The live page shows the craft, their distances, shifts and what happened in a formation."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from browser import console_errors, wait_until
from formation_flights import OFFSETS, PERIOD, deadlocked, flight, lost, missing, scenario
from live.watching import Wall

from spacecraft_gnc.analysis.live.feed import Feed
from spacecraft_gnc.analysis.live.history import columns
from spacecraft_gnc.analysis.live.recorded import RecordedFlight
from spacecraft_gnc.analysis.live.server import PageServer
from spacecraft_gnc.vehicles.formation.live import LIVE
from spacecraft_gnc.vehicles.formation.signals import SIGNALS


def watched(flown, **changes):
    info = SimpleNamespace(scenario=scenario(flown.n_craft, **changes))
    return RecordedFlight(SimpleNamespace(trajectory=flown, info=info), "formation", clock=Wall())


def told(flight, group, step):
    flight.transport.control("seek", PERIOD * (step + 0.5))
    lines = flight.picture().readouts(flight.setup)[group]
    return {line.label: (line.text, line.mood) for line in lines}


def test_the_page_is_told_of_the_craft_and_where_they_are():
    flight_ = watched(flight())
    page = flight_.setup.page_json()
    assert (page["craft"], page["trail"]) == (["sc1", "sc2", "sc3"], "position")
    np.testing.assert_allclose(np.abs(page["ring"]).max(axis=0), [1000.0, 2000.0, 0.0])
    assert not {"craft", "ring", "trail"} & set(flight_.setup.as_json())
    picture = flight_.picture().as_json()
    np.testing.assert_allclose(picture["position"], flight().position[0].ravel(), rtol=1e-6)
    np.testing.assert_allclose(
        np.subtract(picture["position"], picture["places"])[1::3], OFFSETS, rtol=1e-6
    )
    links = np.reshape(picture["links"], (3, 3))
    np.testing.assert_array_equal(links[:, :2], [[0, 1], [0, 2], [1, 2]])
    np.testing.assert_array_equal(links[:, 2], [0, 0, 1])  # an angle, a distance, nothing broken


def test_every_curve_is_in_the_history():
    flight_ = watched(flight())
    panels = flight_.setup.page_json()["panels"]
    drawn = {series["key"] for panel in panels for series in panel["series"]}
    assert drawn | {"position"} == set(flight_.setup.history)
    names, rows = columns(flight_.setup), flight_.history.since(0)
    assert {len(row) for row in rows} == {len(names)}
    kept = np.array([row[names.index("separation")] for row in rows])
    np.testing.assert_allclose(kept, flight().separation, rtol=1e-6)
    away = np.array([row[names.index("error")] for row in rows])
    np.testing.assert_allclose(away[10], np.abs(OFFSETS) * np.exp(-1.0), rtol=1e-6)
    bounded = {panel["name"]: panel["limit"] for panel in panels if panel["limit"]}
    assert bounded == {"delta-v": 1.0, "delta_v": 1.0, "separation": 1000.0, "angle": 60.0}
    of_pairs = {s["key"]: s["first"] for panel in panels for s in panel["series"] if s["first"]}
    assert of_pairs == {"separation": 3, "angle_deg": 3}


def test_a_lost_craft_stands_out():
    flight_ = watched(lost())
    assert "sc2" not in told(flight_, "craft", 39)
    gone = told(flight_, "craft", 41)
    assert gone["sc2"] == ("lost", "bad")
    assert "sc2 is" not in gone
    assert told(flight_, "craft", 50)["sc2 is"] == ("taken for lost", "warn")
    assert "sc1-sc2 angle" not in told(flight_, "pairs", 50)
    assert "sc1-sc2 apart" in told(flight_, "pairs", 50)
    assert LIVE.line(flight_.picture().values)[-1] == "sc2 lost"
    places = flight_.picture().as_json()["places"]
    assert places[3:6] == [None, None, None]
    wrong = np.zeros((100, 3), dtype=bool)
    wrong[10:, 2] = True
    alarm = told(watched(flight(lost=wrong)), "craft", 20)
    assert alarm["sc3 is"] == ("taken for lost, a false alarm", "bad")


def test_a_deadlock_and_a_passage_stand_out():
    flight_ = watched(deadlocked())
    assert told(flight_, "governor", 10)["formation"] == ("forming", "")
    assert told(flight_, "governor", 40)["formation"] == ("deadlock", "bad")
    assert told(flight_, "governor", 55)["formation"] == ("passage", "warn")
    assert told(flight_, "governor", 90)["formation"] == ("formed", "")


@pytest.mark.parametrize(
    ("column", "value", "group", "line", "expected"),
    [
        ("delta_v", [[1.2, 0.0, 0.0]] * 3, "craft", "sc1 delta-v", ("1.2 m/s", "bad")),
        ("delta_v", [[1.0, 0.0, 0.0]] * 3, "craft", "sc1 delta-v", ("1 m/s", "")),
        ("status", 1, "governor", "shifts", ("held", "warn")),
        ("status", 5, "governor", "shifts", ("passed", "")),
        ("governor_margin", -0.02, "governor", "least room", ("-2 %", "bad")),
        ("n_admissible", 0, "governor", "allowed", ("0", "warn")),
    ],
)
def test_what_is_broken_stands_out(column, value, group, line, expected):
    values = getattr(flight(), column).copy()
    values[10] = value
    assert told(watched(flight(**{column: values})), group, 10)[line] == expected


def test_pairs_that_break_a_limit_stand_out():
    lines = told(watched(flight()), "pairs", 0)
    assert lines["sc1-sc3 apart"] == ("471 m", "bad")
    assert lines["sc1-sc2 angle"] == ("73.2°", "bad")
    assert lines["sc2-sc3 apart"][1] == ""


def test_constraints_are_told_by_name():
    told = {"constraint": "separation of sc1 and sc2: 1699 m, limit 1000 m, in 47 steps"}
    lines = LIVE.readouts(LIVE.values(told, LIVE.constants(None)), True)["governor"]
    assert {line.label: line.text for line in lines}["least room in"] == "separation of sc1 and sc2"


def test_an_ungoverned_flight_has_no_governor():
    flight_ = watched(flight(n_craft=2), reference_governor={"governor": "none"})
    assert set(flight_.picture().readouts(flight_.setup)) == {"craft", "pairs"}
    assert "cost" not in {panel["name"] for panel in flight_.setup.page_json()["panels"]}


def test_nothing_is_known_of_an_empty_row_and_no_scenario():
    constants = LIVE.constants(None)
    values = LIVE.values({}, constants)
    for lines in LIVE.readouts(values, True).values():
        assert [line for line in lines if line.text] == []
    assert LIVE.line(values) == []
    assert LIVE.panels(None)
    told(watched(missing(flight(), 20)), "pairs", 20)
    unnamed = LIVE.values({"position": flight().position[0]}, constants)
    assert list(unnamed["craft"]) == ["1", "2", "3"]
    assert unnamed["links"][2::3].all()


def test_a_graph_tells_what_was_applied_in_the_state():
    row = {
        "position": flight().position[0], "applied_delta_v": np.arange(9.0),
        "applied_source": np.array([5, 2, 5]),
    }  # fmt: skip
    values = LIVE.values(row, LIVE.constants(scenario()))
    np.testing.assert_allclose(
        values["delta_v"], np.linalg.norm(np.arange(9.0).reshape(3, 3), axis=1)
    )
    assert values["source"] != "method"
    assert LIVE.values({"applied_source": (5, 5)}, LIVE.constants(None))["source"] == "method"
    known = {f"{signal}/{field}" for signal in SIGNALS for field in (*signal.fields, "step")}
    assert set(LIVE.fields.values()) <= known


def test_a_reference_that_has_not_come_yet_is_moved_on_along_the_natural_motion():
    found, constants = flight(), LIVE.constants(scenario())
    row = {
        "position": found.position[61], "reference_position": found.reference_position[60],
        "reference_velocity": found.reference_velocity[60], "state_step": 61, "reference_step": 60,
    }  # fmt: skip
    moved = LIVE.values(row, constants)
    np.testing.assert_allclose(moved["places"], found.reference_position[61], atol=1e-6)
    assert LIVE.values(row, LIVE.constants(None))["error"] is None
    now = LIVE.values({**row, "state_step": 60}, constants)
    np.testing.assert_array_equal(now["places"], found.reference_position[60])


def test_the_page_draws_the_craft_where_they_are(browser):
    flight_ = watched(lost())
    feed = Feed(flight_)
    with PageServer(feed, port=0) as server:
        browser.get(server.url)

        def craft():
            feed.tick()
            found = browser.execute_script("return window.view?.state?.craft ?? null")
            return found if found and "sc3" in found else None

        found = wait_until(browser, craft, "the craft are drawn")
        scale, right, up = browser.execute_script(
            "return [view.scene.scale, view.scene.right, view.scene.up]"
        )
    first, last = (
        flight_.picture().as_json()["position"][:3],
        flight_.picture().as_json()["position"][6:],
    )
    apart = np.subtract(last, first)
    seen = np.subtract(found["sc3"][:2], found["sc1"][:2])
    np.testing.assert_allclose(seen, [scale * (apart @ right), -scale * (apart @ up)], rtol=1e-4)
    assert right[1] > 0.9  # along the track to the right
    assert up[0] > 0.7  # outward up
    assert console_errors(browser) == []
