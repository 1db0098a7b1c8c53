"""Report of docking flights: numbers, diagrams and the 3-D view."""

from __future__ import annotations

import base64
import json
import math

import numpy as np
import pytest
from docked import START, TURNED, aborted, flight, run, scenario

from spacecraft_gnc import lie
from spacecraft_gnc.drawing.view import POINTS
from spacecraft_gnc.vehicles.docking.report import REPORT
from spacecraft_gnc.vehicles.docking.telemetry import Telemetry


def numbers(data):
    return np.frombuffer(base64.b64decode(data["bdata"]), dtype="<f8")


def charts(*runs):
    return {chart.name: chart for chart in REPORT.charts(runs, 500)}


def rows(shown):
    return {row.label: row.value(shown) for row in REPORT.rows if row.is_shown([shown])}


def test_the_summary_has_what_a_reader_asks_for():
    told = rows(run(flown=flight()))
    assert told["Docked (2 cm and 1 deg for good) from"] == "295"
    assert told["Constraints"] == "all kept, between the steps too"
    assert told["Time of the governor, longest"] == "3"
    assert "Thruster lost" not in told
    lost = rows(run(flown=aborted()))
    assert lost["Docked (2 cm and 1 deg for good) from"] == "never"
    assert lost["Thruster lost"] == "+x at 100 s, noticed at 110 s"
    assert lost["From the hold point at the end"] == "0"


def test_what_kept_the_reference_back_is_counted():
    shown = run(flown=flight())
    shown.telemetry = Telemetry(None, ("force x; clearance", "force x", "", "line of sight y"))
    assert rows(shown)["Kept from it by (steps)"] == "force x 2, line of sight y 1"


def test_the_page_warns_of_what_was_broken_and_not_noticed():
    assert list(REPORT.warnings(run(flown=flight()))) == []
    thrusters = np.ones((60, 6), dtype=bool)
    thrusters[20:, 3] = False
    status, wrong = np.zeros(60, dtype=int), np.full(60, -1)
    status[5], wrong[40:] = 1, 1
    flown = flight(
        final_clearance=np.array(-0.5), thrusters=thrusters, status=status, lost_thruster=wrong
    )
    assert list(REPORT.warnings(run(flown=flown))) == [
        "constraint broken: clearance by 0.48 m",
        "thruster -x was lost, which was not noticed",
        "thruster +y was wrongly taken for lost at 200 s",
        "steps without an admissible reference: 1",
    ]


def test_the_diagrams_show_the_arrays():
    flown = flight()
    drawn = charts(run(flown=flown))
    assert list(drawn) == [
        "distance", "angle", "force", "moment", "offset", "rotation", "sight", "clearance",
        "slack", "solve_time",
    ]  # fmt: skip
    (distance,) = drawn["distance"].figure["data"]
    np.testing.assert_allclose(numbers(distance["y"])[0], np.linalg.norm(START))
    (angle,) = drawn["angle"].figure["data"]
    assert numbers(angle["y"])[0] == pytest.approx(math.degrees(np.linalg.norm(TURNED)))
    upper, lower, x, *_ = drawn["force"].figure["data"]
    assert (upper["y"], lower["y"]) == ([1.0, 1.0], [-1.0, -1.0])
    np.testing.assert_allclose(numbers(x["y"])[:60], flown.force[:, 0])
    assert x["line"]["shape"] == "hv"
    asked = drawn["offset"].figure["data"][1]
    np.testing.assert_array_equal(numbers(asked["y"])[:60], flown.reference[:, 0])
    assert asked["line"]["dash"] == "dot"
    whole, near = (variant.figure for variant in drawn["clearance"].variants)
    assert near["layout"]["yaxis"]["range"] == (-0.08, 0.25)
    assert whole["data"][1]["y"] == [-0.02, -0.02]


def test_an_abort_is_marked_and_its_phases_have_a_band():
    drawn = charts(run(flown=aborted()))
    told = [note["text"] for note in drawn["force"].figure["layout"]["annotations"]]
    assert told == ["+x lost", "noticed, aborting", "holding"]
    bars = {bar["name"]: bar["customdata"] for bar in drawn["phase"].figure["data"]}
    assert bars == {
        "docking": [[0.0, 110.0, 22]],
        "aborting": [[110.0, 235.0, 25]],
        "holding": [[235.0, 300.0, 13]],
    }
    for variant in drawn["sight"].variants:
        assert len(variant.figure["layout"]["shapes"]) == 3


def test_flights_stand_beside_each_other():
    drawn = charts(run("a", flight()), run("b", aborted()))
    names = [line["name"] for line in drawn["distance"].figure["data"]]
    assert names == ["a", "b"]
    assert {"yaxis", "yaxis2", "yaxis3"} <= set(drawn["force"].figure["layout"])
    assert "annotations" not in drawn["force"].figure["layout"]


def test_the_view_has_both_bodies_where_the_constraints_have_them():
    shown = run(flown=flight())
    view = REPORT.scene([shown], 500)
    json.dumps(view.data, allow_nan=False)
    (found,) = view.data["runs"]
    assert found["count"] == 61
    chief, deputy = found["bodies"]
    assert (chief["size"], deputy["port"]) == ([1.04, 1.15, 1.57], [-0.3, 0.0, 0.1])
    at, turned = numbers(deputy["position"])[:3], numbers(deputy["attitude"])[:9].reshape(3, 3)
    np.testing.assert_allclose(turned, lie.exp(TURNED), atol=1e-15)
    port = at + turned @ np.array(deputy["port"])
    np.testing.assert_allclose(port - [0.52, 0.0, 0.2], START, atol=1e-12)
    np.testing.assert_allclose(numbers(found["trail"])[:3], port, atol=1e-12)
    assert [found["step"][k] for k in found["snapshots"]] == [0, 30, 60]
    assert found["told"][0] == "ports 20.6 m apart, 25.1 degrees"
    assert numbers(found["turn"]).size == 9 * 61
    assert "Approach" in view.words.link
    assert "diamond: the goal" in view.words.note.format_map({"diamonds": "the goal"})


def test_a_long_flight_is_thinned_but_keeps_its_snapshots():
    view = REPORT.scene([run(flown=flight(5000))], 3000)
    (found,) = view.data["runs"]
    assert found["count"] <= POINTS + 1 + len(found["snapshots"])
    steps = found["step"]
    assert (steps[0], steps[-1]) == (0, 5000)
    # 25,000 s: every 19 times 150 s
    assert [steps[k] for k in found["snapshots"]] == [*range(0, 5000, 570), 5000]
    assert "every 9th state of flight" in view.frames


def test_without_a_scenario_the_path_is_drawn():
    (found,) = REPORT.scene([run(flown=flight(), known=None)], 500).data["runs"]
    assert found["bodies"] == []
    assert found["region"] is None
    np.testing.assert_allclose(numbers(found["trail"])[:3], START)
    assert rows(run(flown=flight(), known=None))["Its limit"] == "unknown"
    assert scenario().plant.max_force == 1.0
