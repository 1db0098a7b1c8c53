"""The campaigns that come with the package."""

from __future__ import annotations

from pathlib import Path

import pytest

from spacecraft_gnc.campaign.driver import require_metrics
from spacecraft_gnc.campaign.flyer import Flyer
from spacecraft_gnc.campaign.spec import Spec
from spacecraft_gnc.campaign.variations import load_variations
from spacecraft_gnc.scenario import load

SHIPPED = sorted(Path(__file__).parents[2].joinpath("config", "campaigns").glob("*.yaml"))
SHORT = {"plant.duration": 4.0, "launcher.cut_short": True}


def test_there_are_some() -> None:
    names = {path.stem for path in SHIPPED}
    assert names >= {"gupta2015_case1", "gupta2015_case2", "governed_nmpc", "kalabic2014_governor"}


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_shipped_campaign_flies(path: Path) -> None:
    """Its first runs, cut short; each varies the scenario of its name."""
    scenario = load(path.stem, SHORT)
    variations = load_variations(path.stem, scenario)
    assert Path(variations.path) == path
    assert variations.runs is not None
    spec = Spec.of(scenario, variations, 0, variations.runs)
    require_metrics(spec)
    flyer = Flyer(spec)
    rows = [flyer.fly(run).row for run in range(3)]
    assert [row["status"] for row in rows if row["status"] not in ("passed", "failed")] == []
    for name in variations.names:
        values = {str(row[name]) for row in rows}
        is_constant = name.endswith(("controller.inertia", "disturbances"))
        assert len(values) == (1 if is_constant else 3), name
