"""A campaign, runs of which fly again in the graph to the last bit."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from short_campaign import SHORT

from spacecraft_gnc.campaign.results import Campaign
from spacecraft_gnc.campaign.spec import Spec
from spacecraft_gnc.campaign.tables import write_table
from spacecraft_gnc.campaign.tasks import fly_rows
from spacecraft_gnc.campaign.variations import load_variations
from spacecraft_gnc.campaign.writer import Writer
from spacecraft_gnc.cli._campaign_graph import report_spot_checks, spot_check
from spacecraft_gnc.cli._campaign_rerun import rerun
from spacecraft_gnc.cli._common import RunFailed
from spacecraft_gnc.launcher.launcher import Launcher
from spacecraft_gnc.launcher.outcome import NodeDied
from spacecraft_gnc.scenario import load

pytestmark = pytest.mark.graph
RUNS = 6
VARIATIONS = """
vary:
  plant.initial_rotation_vector: {distribution: rotation, max_angle_deg: 40.0}
  plant.inertia: {distribution: inertia, factor: 0.1}
  nmpc_controller.horizon: {distribution: choice, values: [5, 8]}
pass: final_error_deg < 12
"""
NOISE = {"plant.disturbances": ["noise"], "plant.noise_torque": [1e-4, 1e-4, 1e-4]}


@pytest.fixture
def campaign(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Campaign:
    """Return a campaign with noise of its own in each run."""
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    scenario = load("gupta2015_case1", {**SHORT, **NOISE})
    variations = load_variations(tmp_path / "v.yaml", scenario, VARIATIONS)
    found = Campaign.create(tmp_path / "campaign", Spec.of(scenario, variations, 3, RUNS))
    writer = Writer(found)
    writer.add(range(RUNS), fly_rows(found.spec, 0, RUNS).table)
    writer.finish()
    return found


def test_a_failure_flies_again_in_the_graph(campaign: Campaign, tmp_path: Path, capfd: Any):
    failed = next(row["run"] for row in campaign.table().to_pylist() if row["status"] == "failed")
    rerun(campaign.folder, failed, launch=True, out=tmp_path / "again", as_json=True)
    told = json.loads(capfd.readouterr().out)
    assert (told["differences"], told["graph"]["problems"]) == ([], [])
    assert told["graph"]["bag"] == str(tmp_path / "again" / "graph" / "bag")


@pytest.mark.long
def test_a_row_that_another_flight_gave_is_found_out(campaign: Campaign, tmp_path: Path) -> None:
    """The row of each run, put in the place of the next."""
    table = campaign.table()
    (part,) = campaign.parts
    shifted = table.take([RUNS - 1, *range(RUNS - 1)]).set_column(0, "run", table["run"])
    write_table(shifted, part.path)
    with pytest.raises(RunFailed, match="run 0 differs: "):
        rerun(campaign.folder, 0, launch=True, out=tmp_path / "again", quiet=True)
    (checked,) = spot_check(campaign, 1, silent=True)
    assert any("final_error_deg" in text for text in checked.problems)
    assert not report_spot_checks([checked])


@pytest.mark.long
def test_spot_checks(campaign: Campaign, capfd: Any) -> None:
    checked = spot_check(campaign, 2, silent=True)
    assert len({each.run for each in checked}) == 2
    assert [each.problems for each in checked] == [(), ()]
    for each in checked:
        assert each.bag is not None
        assert each.bag.is_relative_to(campaign.folder / "spot_checks")
    assert report_spot_checks(checked)
    assert capfd.readouterr().err == ""


@pytest.mark.long
def test_a_graph_that_ends_early_is_a_problem(
    campaign: Campaign, monkeypatch: pytest.MonkeyPatch, capfd: Any
) -> None:
    def die(launcher: Launcher) -> None:
        raise NodeDied("plant ended with exit code 9", [])

    monkeypatch.setattr(Launcher, "run", die)
    (checked,) = spot_check(campaign, 1, silent=True)
    assert checked.problems == ("plant ended with exit code 9",)
    assert not report_spot_checks([checked])
    err = capfd.readouterr().err
    assert err == f"error: run {checked.run} differs in the graph: plant ended with exit code 9\n"
