"""Runs flown again alone, from the folder of their campaign."""

from __future__ import annotations

import dataclasses
import json
import math
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from short_campaign import SHORT

from spacecraft_gnc.campaign.rerun import fly_again, spot_runs
from spacecraft_gnc.campaign.results import Campaign
from spacecraft_gnc.campaign.spec import Spec
from spacecraft_gnc.campaign.tables import write_table
from spacecraft_gnc.campaign.tasks import fly_rows
from spacecraft_gnc.campaign.variations import load_variations
from spacecraft_gnc.campaign.writer import Writer
from spacecraft_gnc.cli._campaign_graph import require_lockstep
from spacecraft_gnc.cli._campaign_rerun import rerun
from spacecraft_gnc.cli._common import RunFailed
from spacecraft_gnc.errors import ParameterError, RecordingError
from spacecraft_gnc.loop.flight import Flight
from spacecraft_gnc.scenario import load

RUNS = 6
ZONE = {
    "nmpc_controller.zone_names": ["star"],
    "nmpc_controller.zones.star.body_axis": [1.0, 0.0, 0.0],
    "nmpc_controller.zones.star.inertial_axis": [0.0, 0.0, 1.0],
    "nmpc_controller.zones.star.half_angle_deg": 5.0,
}
VARIATIONS = """
vary:
  plant.initial_rotation_vector: {distribution: rotation, max_angle_deg: 40.0}
  nmpc_controller.zones.star.inertial_axis: {distribution: direction, length: 1.0}
  nmpc_controller.zones.star.half_angle_deg: {distribution: choice, values: [5.0, 120.0]}
pass: final_error_deg < 15
"""
"""A zone of 120 deg is around the targets of most runs, which are refused."""


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Campaign:
    """Return a small complete campaign."""
    folder = tmp_path_factory.mktemp("campaigns")
    scenario = load("gupta2015_case1", {**SHORT, **ZONE})
    variations = load_variations(folder / "v.yaml", scenario, VARIATIONS)
    found = Campaign.create(folder / "flown", Spec.of(scenario, variations, 5, RUNS))
    writer = Writer(found)
    writer.add(range(RUNS), fly_rows(found.spec, 0, RUNS).table)
    writer.finish()
    assert found.is_complete
    return found


@pytest.fixture
def campaign(flown: Campaign, tmp_path: Path) -> Campaign:
    """Return a copy of it that a test may change."""
    return Campaign.open(shutil.copytree(flown.folder, tmp_path / "copy"))


def first_of(found: Campaign, *statuses: str) -> int:
    rows = found.table(["run", "status"]).to_pylist()
    return next(row["run"] for row in rows if row["status"] in statuses)


def change(found: Campaign, run: int, column: str, of: Any) -> None:
    """Replace a value of a row in the results."""
    (part,) = found.parts
    rows = found.table()
    values = rows[column].to_pylist()
    values[run] = of(values[run])
    place = rows.column_names.index(column)
    field = rows.schema.field(column)
    import pyarrow as pa

    write_table(rows.set_column(place, field, pa.array(values, field.type)), part.path)


def test_every_run_is_flown_again_to_the_bit(flown: Campaign) -> None:
    statuses = flown.table(["status"])["status"].to_pylist()
    assert {"passed", "failed"} & set(statuses)
    assert "refused" in statuses
    for run, status in enumerate(statuses):
        again = fly_again(flown, run)
        assert again.differences == ()
        assert (again.run, again.flown.row["status"]) == (run, status)


@pytest.mark.parametrize(
    ("column", "of"),
    [
        ("final_error_deg", lambda value: math.nextafter(value, 0.0)),
        ("plant.initial_rotation_vector", lambda value: [*value[:2], -value[2]]),
        ("settle_time_0.1deg", lambda _: 1.0),
        ("steps", lambda value: value + 1),
        ("passed", lambda value: not value),
    ],
)
def test_the_first_difference_is_named(campaign: Campaign, column: str, of: Any) -> None:
    run = first_of(campaign, "passed", "failed")
    before = campaign.row(run)[column]
    change(campaign, run, column, of)
    (told,) = fly_again(campaign, run).differences
    assert told.startswith(f"{column} {of(before)!r} / {before!r}")


def test_wall_times_are_no_difference(campaign: Campaign) -> None:
    run = first_of(campaign, "passed", "failed")
    for column in ("wall_time", "solve_time_median"):
        change(campaign, run, column, lambda value: 2.0 * value)
    assert fly_again(campaign, run).differences == ()


def bent(flight: Flight, name: str, step: int) -> Flight:
    """Return a flight with one number of an array off by a bit."""
    array = getattr(flight, name).copy()
    array[step, 0] = np.nextafter(array[step, 0], math.inf)
    return dataclasses.replace(flight, **{name: array})


def test_another_flight_is_compared_array_by_array(flown: Campaign) -> None:
    again = fly_again(flown, first_of(flown, "passed", "failed"))
    flight, _ = again.require_flight()
    assert np.isnan(flight.governor_margin).all() or np.isinf(flight.governor_margin).all()
    assert again.compare(flight) == ()
    slower = dataclasses.replace(flight, solve_time=2.0 * flight.solve_time)
    assert again.compare(slower) == ()
    told = again.compare(bent(flight, "torque", 13))
    assert told[0] == "array torque, step 13"
    turned = dataclasses.replace(flight, final_momentum=2.0 * flight.final_momentum)
    array, column = again.compare(turned)
    assert array == "array final_momentum"
    assert column.startswith("final_momentum ")
    by_step = ["time", *(name for name, column in type(flight).columns() if not column.at_end)]
    cut = dataclasses.replace(flight, **{name: getattr(flight, name)[:-1] for name in by_step})
    assert again.compare(cut)[0] == "array time: float64 (20,) / float64 (19,)"


def test_spot_checks_are_drawn_by_the_seed_from_what_flew(flown: Campaign) -> None:
    status = flown.table(["status"])["status"].to_pylist()
    flew = [run for run, each in enumerate(status) if each != "refused"]
    chosen = spot_runs(flown, 2)
    assert chosen == spot_runs(flown, 2)
    assert len(set(chosen)) == 2
    assert set(chosen) <= set(flew)
    assert spot_runs(flown, 100) == tuple(flew)


def test_a_flight_at_the_pace_of_the_machine_is_not_compared(flown: Campaign) -> None:
    require_lockstep(flown.spec.scenario)
    with pytest.raises(ParameterError, match=r"plant\.mode: received 'free_run'; required lockste"):
        require_lockstep(load("gupta2015_case1", {"plant.mode": "free_run"}))


def test_the_command_leaves_scenario_and_flight(flown: Campaign, tmp_path: Path, capsys: Any):
    run = first_of(flown, "passed", "failed")
    rerun(flown.folder, run, out=tmp_path / "again")
    out, err = capsys.readouterr()
    assert err == ""
    assert f"run {run}: " in out
    assert "every bit is that of the campaign" in out
    scenario = load(tmp_path / "again" / "scenario.yaml")
    again = scenario.build().run()
    kept = type(again).load(tmp_path / "again" / "flight.npz")
    np.testing.assert_array_equal(kept.attitude, again.attitude)
    assert fly_again(flown, run).compare(again) == ()


def test_the_command_writes_beside_the_campaign_and_overwrites_nothing(campaign: Campaign) -> None:
    run = first_of(campaign, "passed", "failed")
    for number in (1, 2):
        rerun(campaign.folder, run, quiet=True)
        folder = campaign.folder / "reruns" / f"run-{run}-{number}"
        assert {path.name for path in folder.iterdir()} == {"scenario.yaml", "flight.npz"}
    with pytest.raises(RecordingError, match="which holds files; required a new or empty folder"):
        rerun(campaign.folder, run, out=folder, quiet=True)


def test_the_command_as_json(flown: Campaign, tmp_path: Path, capsys: Any) -> None:
    run = first_of(flown, "passed", "failed")
    rerun(flown.folder, run, out=tmp_path / "again", as_json=True)
    told = json.loads(capsys.readouterr().out)
    assert (told["run"], told["differences"], told["graph"]) == (run, [], None)
    assert told["row"]["final_error_deg"] == flown.row(run)["final_error_deg"]


def test_a_difference_fails(campaign: Campaign) -> None:
    run = first_of(campaign, "passed", "failed")
    change(campaign, run, "final_error_deg", lambda value: 2.0 * value)
    change(campaign, run, "cost", lambda value: 2.0 * value)
    with pytest.raises(RunFailed, match=rf"run {run} differs: final_error_deg .* / .*; 1 more$"):
        rerun(campaign.folder, run, quiet=True)


def test_a_refused_run_says_why(flown: Campaign, capsys: Any) -> None:
    run = first_of(flown, "refused")
    rerun(flown.folder, run)
    out = capsys.readouterr().out
    assert f"run {run}: refused: " in out
    assert "'star'" in out
    assert "every bit is that of the campaign" in out
    assert not list(flown.folder.glob(f"reruns/run-{run}-*"))
    with pytest.raises(RecordingError, match="received a run without a flight"):
        rerun(flown.folder, run, launch=True)


@pytest.mark.parametrize("run", [-1, RUNS])
def test_a_run_that_is_not_there(flown: Campaign, run: int) -> None:
    with pytest.raises(RecordingError, match=f"received run {run}; required a run whose row is"):
        rerun(flown.folder, run)
