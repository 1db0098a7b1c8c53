"""The campaigns that come with the package."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from spacecraft_gnc.campaign.driver import require_metrics
from spacecraft_gnc.campaign.flyer import Flyer
from spacecraft_gnc.campaign.spec import Spec
from spacecraft_gnc.campaign.variations import load_variations
from spacecraft_gnc.scenario import load

CONFIG = Path(__file__).parents[2] / "config"
SHIPPED = sorted(CONFIG.joinpath("campaigns").glob("*.yaml"))
SCENARIOS = {path.stem for path in CONFIG.glob("*.yaml")}
SHORT = 10.0
"""Duration of a run [s]; two control steps where these are longer."""


def test_there_are_some() -> None:
    names = {path.stem for path in SHIPPED}
    assert names >= {"gupta2015_case1", "gupta2015_case2", "governed_nmpc", "kalabic2014_governor"}
    assert names >= {"afrl_two_wheel", "afrl_two_wheel_1rad", "phogat_figure4_disturbed"}


def scenario_of(campaign: str) -> str:
    """Return the scenario that a campaign varies: of its name, or of the beginning of it."""
    return max((name for name in SCENARIOS if campaign.startswith(name)), key=len)


def shortened(path: Path, duration: float) -> str:
    """Return the text of a campaign without a duration that is longer than the test."""
    text = path.read_text(encoding="utf-8")
    return re.sub(r"(plant\.duration:[^}]*value: )[\d.]+", rf"\g<1>{4.0 * duration}", text)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_shipped_campaign_flies(path: Path) -> None:
    """Its first runs, cut short; each varies the scenario of its name."""
    name = scenario_of(path.stem)
    duration = max(SHORT, 2.5 * load(name).period)
    scenario = load(name, {"plant.duration": duration, "launcher.cut_short": True})
    assert Path(load_variations(path.stem, scenario).path) == path
    variations = load_variations(path.stem, scenario, shortened(path, duration))
    assert variations.runs is not None
    spec = Spec.of(scenario, variations, 0, variations.runs)
    require_metrics(spec)
    flyer = Flyer(spec)
    rows = [flyer.fly(run).row for run in range(3)]
    assert [row["status"] for row in rows if row["status"] not in ("passed", "failed")] == []
    for name in variations.names:
        values = {str(row[name]) for row in rows}
        is_constant = name.endswith(("controller.inertia", "disturbances", "duration"))
        assert len(values) == (1 if is_constant else 3), name
