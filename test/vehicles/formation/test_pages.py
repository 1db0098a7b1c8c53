"""Report of flights in formation: numbers, diagrams and the 3-D view."""

from __future__ import annotations

import base64
import json

import numpy as np
import pytest
from formation_flights import NATURAL, PERIOD, deadlocked, flight, lost, missing, run

from spacecraft_gnc.drawing.view import POINTS
from spacecraft_gnc.vehicles.formation.report import REPORT
from spacecraft_gnc.vehicles.formation.telemetry import Telemetry


def numbers(data):
    return np.frombuffer(base64.b64decode(data["bdata"]), dtype="<f8")


def charts(*runs):
    return {chart.name: chart for chart in REPORT.charts(runs, 500)}


def rows(shown):
    return {row.label: row.value(shown) for row in REPORT.rows if row.is_shown([shown])}


def test_the_summary_has_what_a_reader_asks_for():
    told = rows(run())
    assert told["Formed (equal shifts, every craft at its place, for good) from step"] == "64"
    assert told["Constraints"] == "BROKEN: separation; communication angle"
    assert told["Delta-v by craft"].count(",") == 2
    assert {"Deadlocks", "Craft lost"}.isdisjoint(told)
    gone = rows(run(flown=lost()))
    assert gone["Craft lost"] == f"sc2 at {40 * PERIOD:.5g} s, noticed at {43 * PERIOD:.5g} s"
    assert rows(run(flown=deadlocked()))["Deadlocks"].startswith("once, resolved")
    unknown = rows(run(known=None))
    assert unknown["Its limit"] == "unknown"


def test_the_governors_constraints_are_counted():
    near = "separation of sc1 and sc2"
    nearest = (f"{near}: 1331 m, limit 1000 m, in 50 steps", "delta-v of sc2: 0.9 m/s", near, "")
    refused = ("", "", "", "delta-v of sc1: 1.1 m/s, limit 1 m/s, now")
    told = rows(run(telemetry=Telemetry(None, nearest, refused)))
    assert told["Least room ahead of (steps)"] == f"{near} 2, delta-v of sc2 1"
    assert told["Cheapest shifts refused for (steps)"] == "delta-v of sc1 1"


def test_the_page_warns_of_what_was_broken_and_not_noticed():
    assert list(REPORT.warnings(run(flown=flight(), known=None))) == []
    healthy, wrong = np.ones((100, 3), dtype=bool), np.zeros((100, 3), dtype=bool)
    healthy[60:, 0], wrong[50:, 2] = False, True
    status, parked = np.zeros(100, dtype=int), np.zeros(100, dtype=bool)
    status[5], parked[90:] = 1, True
    flown = flight(healthy=healthy, lost=wrong, status=status, deadlocked=parked)
    told = list(REPORT.warnings(run(flown=flown)))
    assert told[0].startswith("constraint broken: separation 471 m")
    assert told[2:] == [
        "the craft are parked in a formation that is not the desired one at the end",
        "sc1 was lost, which was not noticed",
        f"sc3 was wrongly taken for lost at {50 * PERIOD:.5g} s",
        "steps without admissible shifts: 1",
    ]


def test_the_diagrams_show_the_arrays():
    flown = flight()
    drawn = charts(run(flown=flown))
    assert list(drawn) == [
        "paths", "separation", "delta_v", "angle", "error", "spent", "shifts", "cost",
        "admissible", "margin", "solve_time", "standing",
    ]  # fmt: skip
    *pairs, limit = drawn["separation"].figure["data"]
    assert [line["name"] for line in pairs] == ["sc1-sc2", "sc1-sc3", "sc2-sc3"]
    np.testing.assert_allclose(numbers(pairs[1]["y"])[:100], 1e-3 * flown.separation[:, 1])
    assert (limit["name"], limit["y"]) == ("at least 1 km", [1.0, 1.0])
    first, *_, most = drawn["delta_v"].figure["data"]
    np.testing.assert_allclose(numbers(first["y"])[:100], flown.delta_v[:, 0, 1])
    assert (first["line"]["shape"], most["y"]) == ("hv", [1.0, 1.0])
    w, omega = drawn["cost"].figure["data"]
    np.testing.assert_array_equal(numbers(w["y"]), flown.shift_cost)
    np.testing.assert_array_equal(numbers(omega["y"]), flown.state_cost)
    ring, path, start, *_ = drawn["paths"].figure["data"]
    assert np.abs(numbers(ring["x"])).max() == pytest.approx(2.0)
    np.testing.assert_allclose(numbers(path["x"])[:100], 1e-3 * flown.position[:, 0, 1])
    assert numbers(start["y"]) == pytest.approx(1e-3 * flown.position[0, 0, 0])
    assert drawn["paths"].figure["layout"]["yaxis"]["scaleanchor"] == "x"


def test_what_happened_is_marked_and_has_a_band():
    drawn = charts(run(flown=deadlocked()))
    told = [note["text"] for note in drawn["delta_v"].figure["layout"]["annotations"]]
    assert told == ["deadlock", "passage 1", "passage 2", "formed, step 64"]
    assert "shapes" not in drawn["paths"].figure["layout"]
    bars = {bar["name"]: bar["customdata"] for bar in drawn["standing"].figure["data"]}
    assert [stretch[2] for stretch in bars["forming"]] == [35, 11]
    assert {name: [s[2] for s in bars[name]] for name in ("deadlock", "passage", "formed")} == {
        "deadlock": [15], "passage": [10], "formed": [29]
    }  # fmt: skip
    assert "answer" in drawn


def test_flights_stand_beside_each_other():
    drawn = charts(run("a", flight()), run("b", lost()))
    assert {"yaxis", "yaxis2", "yaxis3"} <= set(drawn["shifts"].figure["layout"])
    a, b, limit = drawn["separation"].figure["data"]
    assert (a["name"], b["name"], limit["name"]) == ("a", "b", "at least 1 km")
    np.testing.assert_allclose(numbers(a["y"])[:100], 1e-3 * flight().separation.min(axis=1))
    assert "annotations" not in drawn["separation"].figure["layout"]
    shown = [item for item in drawn["paths"].figure["data"] if item.get("showlegend", True)]
    assert [item["name"] for item in shown] == ["natural ellipse", "a", "b"]
    assert "shifts" not in charts(run("a", flight()), run("b", flight(60, 2)))


def test_the_view_has_the_craft_their_places_and_the_lines_between_them():
    flown = lost()
    view = REPORT.scene([run(flown=flown)], 500)
    json.dumps(view.data, allow_nan=False)
    (found,) = view.data["runs"]
    assert found["count"] == 101
    first, second, _ = found["craft"]
    assert (first["name"], second["answers"][39:41]) == ("sc1", [True, False])
    np.testing.assert_allclose(
        numbers(first["path"]).reshape(-1, 3)[:100], 1e-3 * flown.position[:, 0]
    )
    np.testing.assert_allclose(numbers(first["place"])[:3], 1e-3 * NATURAL[23, :3])
    assert np.isnan(numbers(second["place"])[3 * 43 :]).all()
    assert [link["craft"] for link in found["links"]] == [[0, 1], [0, 2], [1, 2]]
    assert not all(link["kept"][0] for link in found["links"])
    assert all(link["kept"][-1] for link in found["links"])
    assert numbers(found["ring"]).reshape(-1, 3).max() == pytest.approx(2.0)
    assert found["told"][0].startswith("forming, at least 0.471 km apart, up to 6 km")
    assert "diamonds: the reference of each" in view.words.note.format_map(
        {"diamonds": "the reference"}
    )


def test_a_long_flight_is_thinned():
    (found,) = REPORT.scene([run(flown=flight(5000))], 3000).data["runs"]
    assert found["count"] <= POINTS + 1
    assert (found["step"][0], found["step"][-1]) == (0, 5000)


@pytest.mark.parametrize("flown", [flight(n_craft=2), missing(lost(), 20)], ids=["two", "missing"])
def test_what_is_not_known_is_not_drawn(flown):
    shown = run(flown=flown, known=None)
    json.dumps([chart.data() for chart in REPORT.charts([shown], 500)], allow_nan=False)
    (found,) = REPORT.scene([shown], 500).data["runs"]
    assert numbers(found["ring"]).size == 0
    assert all(all(link["kept"]) for link in found["links"])
    assert len(found["links"]) == flown.n_craft * (flown.n_craft - 1) // 2
