"""Campaigns from end to end: the same rows on any workers, after a kill, and in two parts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import campaign_tasks
import numpy as np
import pytest
from short_campaign import VARIATIONS

from spacecraft_gnc.campaign import driver
from spacecraft_gnc.campaign.cluster import connected
from spacecraft_gnc.campaign.driver import fly_missing, keep_flights, require_metrics
from spacecraft_gnc.campaign.engine import Engine
from spacecraft_gnc.campaign.flyer import Flyer, row_differences
from spacecraft_gnc.campaign.keeping import kept_runs, worst_runs
from spacecraft_gnc.campaign.results import Campaign
from spacecraft_gnc.campaign.spec import Spec
from spacecraft_gnc.campaign.summary import summarize
from spacecraft_gnc.errors import GncError, ParameterError
from spacecraft_gnc.loop.flight import Flight

RUNS = 60


@pytest.fixture(scope="module")
def engine() -> Iterator[Engine]:
    with connected(workers=2) as client:
        yield Engine(client)


@pytest.fixture
def spec(make_spec) -> Spec:
    return make_spec(runs=RUNS)


@pytest.fixture
def alone(spec: Spec) -> list[dict[str, Any]]:
    """Rows of all runs, flown in this process in another order."""
    flyer = Flyer(spec)
    return [flyer.fly(run).row for run in range(RUNS - 1, -1, -1)][::-1]


def silent(done: int, total: int, counts: Counter[str] | None = None) -> None:
    """Show nothing."""


def require_rows(campaign: Campaign, expected: list[dict[str, Any]]) -> None:
    rows = campaign.table().to_pylist()
    assert [row["run"] for row in rows] == [row["run"] for row in expected]
    for stored, row in zip(rows, expected, strict=True):
        assert row_differences(stored, row) == []


def test_rows_are_those_of_flights_alone(spec, alone, engine, tmp_path: Path) -> None:
    campaign = Campaign.create(tmp_path / "out", spec)
    told = []
    fly_missing(campaign, engine, lambda *state: told.append((*state[:2], state[2].total())))
    require_rows(campaign, alone)
    assert {row["status"] for row in alone} == {"passed", "failed"}
    assert told[-1] == (RUNS, RUNS, RUNS)
    assert [done for done, _, _ in told] == sorted({done for done, _, _ in told})


def test_a_killed_worker_loses_nothing(spec, alone, engine, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(driver, "fly_rows", campaign_tasks.rows_of_a_worker_that_is_killed_once)
    campaign = Campaign.create(tmp_path / "out", spec)
    fly_missing(campaign, engine, silent)
    assert (tmp_path / "killed").exists()
    require_rows(campaign, alone)


def test_an_interrupted_campaign_goes_on(spec, alone, engine, tmp_path: Path) -> None:
    def interrupt(done: int, total: int, counts: Counter[str]) -> None:
        if done >= 5:
            raise KeyboardInterrupt

    campaign = Campaign.create(tmp_path / "out", spec)
    with pytest.raises(KeyboardInterrupt):
        fly_missing(campaign, engine, interrupt)
    there = {path: path.read_bytes() for path in campaign.results.iterdir()}
    before = sum(map(len, campaign.done))
    assert 5 <= before < RUNS
    told = []
    fly_missing(campaign, engine, lambda done, *_: told.append(done))
    assert told[0] > before
    require_rows(campaign, alone)
    assert not there.keys() & set(campaign.results.iterdir()), "parts are joined in the end"


def test_a_run_that_ends_its_workers_is_a_row(spec, tmp_path, monkeypatch) -> None:
    campaign = Campaign.create(tmp_path / "out", spec)
    flyer = Flyer(spec)

    class Deadly:
        def map(self, *_: object) -> Iterator[Any]:
            from spacecraft_gnc.campaign.engine import Block
            from spacecraft_gnc.campaign.tasks import fly_rows

            yield Block(range(1), None)
            yield Block(range(1, RUNS), fly_rows(spec, 1, RUNS - 1))

    fly_missing(campaign, Deadly(), silent)  # type: ignore[arg-type]
    row = campaign.row(0)
    assert row["status"] == "error"
    assert row["reason"] == "ended every worker process that it was given to"
    assert row["plant.inertia"] == flyer.overrides(0)["plant.inertia"]
    assert campaign.counts()["error"] == 1


def test_flights_are_kept_and_are_those_of_the_rows(spec, alone, engine, tmp_path: Path) -> None:
    campaign = Campaign.create(tmp_path / "out", spec)
    fly_missing(campaign, engine, silent)
    keeping = keep_flights(campaign, engine, first=2, most_failed=3, progress=silent)
    failed = [row["run"] for row in alone if row["status"] == "failed"]
    worst = sorted(alone, key=lambda row: (-row["final_error_deg"], row["run"]))[:2]
    torque = sorted(alone, key=lambda row: (-row["max_torque"], row["run"]))[:2]
    expected = {0, 1, *failed[:3], *(row["run"] for row in (*worst, *torque))}
    assert set(keeping.runs) == expected
    assert keeping.left_out == len(set(failed) - expected)
    assert keeping.mismatches == ()
    for run in keeping.runs:
        file = campaign.flight_of(run)
        flown = Flyer(spec).fly(run)
        flight = type(flown.flight).load(file)
        np.testing.assert_array_equal(flight.attitude, flown.flight.attitude)
        assert Flight.load_scenario(file) == flown.scenario.to_yaml()
    summary = summarize(campaign, keeping)
    assert summary["passed"] + summary["failed"] == RUNS
    assert summary["kept"] == sorted(expected)
    assert summary["success_rate"] == 1.0 - len(failed) / RUNS


def test_a_flight_that_does_not_give_its_row_again_is_told(
    spec, engine, tmp_path, monkeypatch
) -> None:
    campaign = Campaign.create(tmp_path / "out", spec)
    fly_missing(campaign, engine, silent)
    true = Campaign.row
    monkeypatch.setattr(Campaign, "row", lambda self, run: {**true(self, run), "steps": 19})
    keeping = keep_flights(campaign, engine, first=1, most_failed=0, progress=silent)
    assert f"run {keeping.runs[0]}: steps 19 / 20" in keeping.mismatches
    assert not list(campaign.flights.iterdir())


def test_worst_runs_have_a_value(make_spec, engine, tmp_path: Path) -> None:
    text = VARIATIONS.replace("max_torque < 0.011", "min_zone_margin_deg > 0 and steps > 1")
    text = text.replace("steps > 1", "steps > 1 and error_to < 1")
    campaign = Campaign.create(tmp_path / "out", make_spec(text, runs=8))
    fly_missing(campaign, engine, silent)
    assert campaign.counts()["failed"] == 8, "there is no zone: nothing is known to have passed"
    assert worst_runs(campaign, "min_zone_margin_deg") == []
    assert worst_runs(campaign, "steps") == [0, 1], "of equal ones the first"
    assert worst_runs(campaign, "error_to") == [], "a text is no number"
    assert len(kept_runs(campaign, 0, 0)[0]) <= 4


def test_a_criterion_of_unknown_metrics_is_refused(make_spec) -> None:
    require_metrics(make_spec())
    with pytest.raises(GncError, match="did you mean 'final_error_deg'"):
        require_metrics(make_spec(VARIATIONS.replace("final_error", "final_eror")))


def test_a_campaign_that_cannot_fly_is_refused(spec, monkeypatch) -> None:
    def refuse(*_: object) -> None:
        raise ParameterError("plant.x: received 1; required 2; write 2")

    monkeypatch.setattr("spacecraft_gnc.scenario.scenario.Scenario.build", refuse)
    with pytest.raises(ParameterError, match=r"first 10 runs cannot be flown \(plant\.x: recei"):
        require_metrics(spec)
