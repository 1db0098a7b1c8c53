"""Formation of the AFRL report: its verdicts and figures, from the flight of Fig. 9."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.drawing.figures import save_figures
from spacecraft_gnc.studies import afrl2016_formation as study
from spacecraft_gnc.studies import afrl2016_formation_figures as pictures
from spacecraft_gnc.studies.afrl2016_formation_starts import DEADLOCKED_RUNS, DEADLOCKS, Start
from spacecraft_gnc.studies.afrl2016_formation_study import (
    SCENARIO,
    UNGOVERNED,
    Case,
    Deadlock,
    Formed,
    Study,
    refusals,
)
from spacecraft_gnc.studies.flights import fly

NAN = math.nan
DATA = Path(__file__).parents[1] / "data"


def _case(name, *overrides):
    flown = fly(name, overrides, repeats=1)
    return Case(flown, summarize(flown.trajectory, flown.scenario))


@pytest.fixture(scope="module")
def governed():
    return _case(SCENARIO, "plant.duration=9300.0")


@pytest.fixture(scope="module")
def ungoverned():
    return _case(UNGOVERNED, "plant.duration=9300.0")


@pytest.fixture
def campaign():
    """Five starts: formed, formed after a deadlock, parked for good, and two that are refused."""
    return Formed(
        ["passed", "passed", "failed", "refused", "refused"],
        {"delta-v": 1, "communication angle": 1},
        np.array([70.0, 190.0, NAN, NAN, NAN]),
        np.array([0.5, 0.9, 0.7, NAN, NAN]),
        np.array([9.0, 15.0, 11.0, NAN, NAN]),
        np.array([1200.0, 1001.0, 1500.0, NAN, NAN]),
        np.array([30.0, 59.0, 40.0, NAN, NAN]),
        np.array([0.0, 1.0, 1.0, NAN, NAN]),
        np.array([0.0, 0.0, 1.0, NAN, NAN]),
    )


@pytest.fixture
def flown(governed, ungoverned, campaign):
    """A study in which the flight of Fig. 9 stands for the others."""
    motions = dict.fromkeys(("hill", "two_body", "two_body_j2"), governed)
    deadlocks = [Deadlock(ungoverned, governed)]
    return Study(governed, ungoverned, deadlocks, governed, motions, campaign)


def test_the_figures_of_fig_9_come_out(flown):
    checks = list(study._figure_checks(flown))
    assert len(checks) == 9
    assert not [check for check in checks if not check.ok]


def test_a_study_whose_governor_is_none_fails(flown, ungoverned):
    swapped = Study(ungoverned, flown.governed, flown.deadlocks, ungoverned, flown.motions, None)
    failed = {check.quantity for check in study._figure_checks(swapped) if not check.ok}
    assert failed == {
        "formed at step", "largest delta-v", "least separation", "governed: delta-v broken by",
        "governed: separation broken by", "governed: communication angle broken by",
        "ungoverned: largest delta-v", "ungoverned: least separation",
        "ungoverned: of 3 constraints kept",
    }  # fmt: skip
    failed = {check.quantity for check in study._other_checks(swapped) if not check.ok}
    assert "craft lost: noticed" in failed
    assert "craft lost: separation broken by" in failed
    assert "two_body_j2: formed" not in failed


def test_deadlocks_are_to_be_there_and_to_be_resolved(flown, governed):
    never = Case(governed.flown, governed.metrics | {"formed_at_step": None})
    parked = Case(governed.flown, governed.metrics | {"deadlocked": True})
    checks = list(study._deadlock_checks([Deadlock(parked, governed)]))
    assert all(check.ok for check in checks)
    checks = list(study._deadlock_checks([Deadlock(governed, never)]))
    assert [check.ok for check in checks] == [False, False, True]
    checks = list(study._deadlock_checks(flown.deadlocks * 2))
    assert [(check.expected, check.ours) for check in checks] == [(2, 0), (2, 2), (0, 0)]


def test_the_shares_of_the_campaign_are_told(campaign):
    values = campaign.values()
    told = {name: values[name] for name in ("starts", "feasible", "passed", "formed")}
    assert told == {"starts": 5, "feasible": 3, "passed": 2, "formed": 2}
    assert (values["with_deadlock"], values["deadlocked"]) == (2, 1)
    assert values["formed_at_max"] == 190.0
    assert values["min_separation"] == 1001.0
    assert values["max_communication_angle_deg"] == 59.0
    (check,) = study._campaign_checks(campaign)
    assert (check.ours, check.ok) == (1, False)
    first, second = study._campaign_tables(campaign)
    assert first.rows[0][:3] == ("5", "3", "2")
    assert first.notes == ["Refused before flight: communication angle 1; delta-v 1."]
    assert second.rows[0] == ("largest delta-v", "0.700 m/s", "0.896 m/s", "0.900 m/s")


def test_a_campaign_without_feasible_starts_has_no_figures():
    gone = np.full(2, NAN)
    values = Formed(["refused"] * 2, {"delta-v": 2}, *[gone] * 7).values()
    assert (values["feasible"], values["formed_at_median"]) == (0, None)


def test_refused_starts_are_counted_by_their_constraint():
    none = "plant.initial_phase: received a start from which none ...; required a start with an "
    near = "plant.initial_phase: received [1.0], where sc1 and sc2 are 700 m apart; required at "
    angle = "angle between actual and commanded direction of sc1 and sc2: 70 deg, limit 60 deg"
    reasons = [
        f"{none} admissible one; at the least delta-v of sc1: 3.2 m/s, limit 1 m/s, now",
        f"{none} admissible one; at the least delta-v of sc3: 1.2 m/s, limit 1 m/s, now",
        f"{none} admissible one; at the least separation of sc1 and sc2: 900 m, limit 1000 m",
        f"{none} admissible one; at the least {angle}, in 2 steps",
        f"{near} least min_separation (1000 m) between all craft at the start; move one away",
        "something else",
    ]
    assert refusals(reasons) == {
        "delta-v": 2, "separation on the way": 1, "communication angle": 1,
        "two craft too near at the start": 1, "something else": 1,
    }  # fmt: skip


def test_the_stored_starts_are_drawn_in_the_box_of_the_campaign():
    assert len(set(DEADLOCKED_RUNS)) == len(DEADLOCKS) == 16
    stored = json.loads((DATA / "formation_deadlocks.json").read_text(encoding="utf-8"))["starts"]
    for start, run, other in zip(DEADLOCKS, DEADLOCKED_RUNS, stored, strict=True):
        assert run == other["run"]
        assert list(start.phase) == other["phases"]
        assert list(start.along_track_offset) == other["offsets"]
        assert list(start.amplitude) == other["amplitudes"]
        assert all(phase == int(phase) and 0 <= phase < 50 for phase in start.phase)
        assert all(3000.0 <= offset <= 9000.0 for offset in start.along_track_offset)
        assert all(0.8 <= amplitude <= 1.8 for amplitude in start.amplitude)
    assert Start.drawn(7) == Start.drawn(7) != Start.drawn(8)


def test_the_tables_are_as_wide_as_a_wide_terminal(flown):
    from spacecraft_gnc.studies.report import table_lines

    tables = [study._figure_table(flown), study._deadlock_table(flown.deadlocks),
              study._loss_table(flown.loss), study._motion_table(flown), study._times_table(flown),
              *study._campaign_tables(flown.campaign)]  # fmt: skip
    assert max(len(line) for table in tables for line in table_lines(table)) <= 132


def test_the_figures_are_drawn(flown, tmp_path):
    drawn = pictures.figures(
        flown.governed, flown.ungoverned, flown.deadlocks, flown.loss, flown.motions, flown.campaign
    )
    files = save_figures(drawn, tmp_path)
    assert len(files) == 5
    assert all(file.stat().st_size > 10_000 for file in files)
