"""Docking of the AFRL report: its verdicts and figures, from one short flight."""

from __future__ import annotations

import math

import numpy as np
import pytest

from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.drawing.figures import save_figures
from spacecraft_gnc.studies import afrl2016_docking as study
from spacecraft_gnc.studies import afrl2016_docking_figures as pictures
from spacecraft_gnc.studies.afrl2016_docking_study import (
    SCENARIO,
    STARTS,
    Case,
    Docked,
    Study,
)
from spacecraft_gnc.studies.flights import fly


@pytest.fixture(scope="module")
def case():
    """The first start without its governor, for ten steps."""
    short = ("plant.duration=50.0", "reference_governor.governor=none")
    margin = ("reference_governor.distance_margin=0.0",)
    flown = fly(SCENARIO, (*short, *margin), repeats=1)
    return Case(flown, summarize(flown.trajectory, flown.scenario))


@pytest.fixture
def flown(case):
    """A study in which that flight stands for every other one."""
    cases = dict.fromkeys(STARTS, case)
    times = np.array([235.0, 280.0, 280.0, math.nan])
    passed = np.isfinite(times)
    campaign = Docked(np.full((4, 3), 9.0), times, passed, ["passed"] * 3 + ["failed"], 5.0)
    tilted = {"periodic": case, "time-invariant": case}
    return Study(cases, cases, case, tilted, case, 0.1, campaign)


def test_what_a_flight_breaks_is_told(case):
    assert case.broken["force"] == pytest.approx(0.7030, abs=1e-3)
    assert case.broken["moment"] == 0.0
    assert math.isnan(case.docked_at)


def test_a_study_that_does_not_dock_fails(flown):
    checks = [*study._governed_checks(flown), *study._ungoverned_checks(flown)]
    checks += [*study._other_checks(flown), *study._campaign_checks(flown.campaign)]
    failed = {check.quantity for check in checks if not check.ok}
    assert "first start: docked at" in failed
    assert f"{STARTS[0].words}: force broken by" in failed
    assert f"{STARTS[0].words}: moment broken by" not in failed
    assert "tilted: time-invariant laws do worse" in failed
    assert "thruster lost: held at the hold point" in failed
    assert "random starts: not docked within the constraints" in failed
    assert "ungoverned, first start: largest force" not in failed


def test_the_share_of_the_campaign_is_told(flown):
    values = flown.campaign.values()
    assert (values["starts"], values["passed"], values["docked"]) == (4, 3, 3)
    assert (values["docked_at_median"], values["docked_at_max"]) == (280.0, 280.0)
    row = study._campaign_table(flown.campaign).rows[0]
    assert row[:2] == ("4", "3")


def test_the_figures_are_drawn(case, flown, tmp_path):
    drawn = pictures.figures(
        case, flown.governed, flown.ungoverned, flown.tilted, case, flown.campaign
    )
    files = save_figures(drawn, tmp_path)
    assert len(files) == 7
    assert all(file.stat().st_size > 10_000 for file in files)


def test_the_chief_of_the_figures_is_that_of_the_plant(case):
    plant, loop = case.flown.scenario.plant, case.flown.scenario.build()
    times = np.array([0.0, 35.0, 620.0])
    attitudes = pictures.chief_attitudes(plant, times)
    for time, attitude in zip(times, attitudes, strict=True):
        np.testing.assert_allclose(attitude, loop.plant.motion.chief.attitude(time), atol=1e-14)
