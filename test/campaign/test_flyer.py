"""Single runs of a campaign and their rows."""

from __future__ import annotations

import math

import numpy as np
import pytest
from short_campaign import SHORT

from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.campaign.flyer import Flyer, flat_metrics, is_wall, row_differences
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.loop.closed_loop import ClosedLoop
from spacecraft_gnc.scenario import load
from spacecraft_gnc.scenario.fingerprint import fingerprint
from spacecraft_gnc.scenario.scenario import Scenario


def test_a_run_is_the_flight_of_its_overrides(spec) -> None:
    flyer = Flyer(spec)
    row, flight, scenario = flyer.fly(3)
    alone = load("gupta2015_case1", {**SHORT, **flyer.overrides(3)})
    again = alone.build().run()
    assert fingerprint(scenario) == fingerprint(alone) == row["scenario_hash"]
    np.testing.assert_array_equal(flight.attitude, again.attitude)
    metrics = dict(flat_metrics(summarize(again, alone)))
    assert row_differences({**row, **metrics}, row) == []
    assert list(row)[:5] == ["run", "status", "passed", "reason", "plant.initial_rotation_vector"]
    assert list(row)[-1] == "wall_time"
    assert row["plant.inertia"] == alone.plant.inertia.ravel().tolist()
    assert row["status"] == ("passed" if row["final_error_deg"] < 15 else "failed")


def test_a_run_has_its_seed_and_depends_on_no_other_run(spec, make_spec) -> None:
    flyer = Flyer(spec)
    assert flyer.overrides(5)["plant.seed"] == 7
    assert flyer.overrides(5)["plant.run"] == 5
    alone = flyer.fly(5).row
    for run in (9, 0, 5):
        last = flyer.fly(run).row
    assert row_differences(alone, last) == []
    assert row_differences(alone, Flyer(make_spec(runs=500)).fly(5).row) == []
    assert row_differences(alone, Flyer(make_spec(seed=8)).fly(5).row) != []


def test_a_point_at_hand_need_not_be_drawn(spec) -> None:
    flyer, points = Flyer(spec), spec.design.points(0, 12)
    assert flyer.overrides(4, points[4]) == flyer.overrides(4)
    assert row_differences(flyer.fly(4, points[4]).row, flyer.fly(4).row) == []


def test_a_refused_run_is_a_row_with_its_reason(spec, monkeypatch) -> None:
    def refuse(_: Scenario) -> ClosedLoop:
        raise ParameterError("plant.x: received 1;\nrequired 2; write 2")

    monkeypatch.setattr(Scenario, "build", refuse)
    row, flight, _ = Flyer(spec).fly(1)
    assert flight is None
    assert (row["status"], row["passed"]) == ("refused", False)
    assert row["reason"] == "plant.x: received 1;; required 2; write 2"
    assert len(row["plant.inertia"]) == 9
    assert row["wall_time"] > 0.0


def test_a_flight_that_raises_is_a_row_with_its_reason(spec, monkeypatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise ZeroDivisionError("in a plug-in")

    monkeypatch.setattr(ClosedLoop, "run", fail)
    row, flight, _ = Flyer(spec).fly(1)
    assert flight is None
    assert (row["status"], row["passed"]) == ("error", False)
    assert row["reason"] == "ZeroDivisionError: in a plug-in"


def test_metrics_become_flat_columns() -> None:
    flat = dict(
        flat_metrics(
            {
                "sources": {"OPTIMAL": 3},
                "zone_margin_deg": {"sun": np.float64(1.5)},
                "limits_exceeded": [{"text": "torque by 2"}, {"text": "zone by 1"}],
                "nothing": [],
                "lost_at": [1.0, 2],
            }
        )
    )
    assert flat["sources.OPTIMAL"] == 3
    assert flat["sources.ZERO"] == 0, "what did not occur is counted as well"
    assert flat["zone_margin_deg.sun"] == 1.5
    assert type(flat["zone_margin_deg.sun"]) is float
    assert flat["limits_exceeded"] == "torque by 2; zone by 1"
    assert flat["nothing"] is None
    assert flat["lost_at"] == [1.0, 2]


def test_rows_are_compared_bit_for_bit() -> None:
    row = {"a": 0.1, "b": [1.0, 2.0], "c": None, "n": math.nan, "wall_time": 1.0}
    assert row_differences(row, {**row, "wall_time": 2.0, "solve_time_max": 3.0}) == []
    assert row_differences(row, {**row, "d": None, "b": [1, 2]}) == []
    changed = {"a": math.nextafter(0.1, 1.0), "b": [1.0, -2.0], "c": 0, "n": None}
    for name, value in changed.items():
        (told,) = row_differences(row, {**row, name: value})
        assert told.startswith(f"{name} ")
    assert row_differences({"z": 0.0}, {"z": -0.0}) == ["z 0.0 / -0.0"]


@pytest.mark.parametrize(
    ("name", "wall"), [("wall_time", True), ("solve_time_p99", True), ("settle_time_1deg", False)]
)
def test_wall_columns(name: str, wall: bool) -> None:
    assert is_wall(name) is wall
