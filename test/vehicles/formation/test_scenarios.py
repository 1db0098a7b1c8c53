"""Shipped formation scenarios: what is asked of them, and what the command refuses."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.cli.main import main
from spacecraft_gnc.scenario import load

CONFIG = Path(__file__).parents[3] / "config"


def flown(name, **changes):
    """Return flight and metrics of a shipped scenario, with changes: ``plant__duration=1.0``."""
    given = {key.replace("__", "."): value for key, value in changes.items()}
    scenario = load(CONFIG / f"{name}.yaml", given)
    flight = scenario.build().run()
    return flight, summarize(flight, scenario)


def require_limits(flight):
    """Assert the three limits of the report, of the arrays themselves."""
    healthy = flight.healthy
    norms = np.linalg.norm(flight.delta_v, axis=2)
    assert norms[healthy].max() <= 1.0
    for i, (a, b) in enumerate(((0, 1), (0, 2), (1, 2))):
        apart = flight.position[:, a] - flight.position[:, b]
        assert np.linalg.norm(apart, axis=1).min() >= 1000.0
        wanted = flight.reference_position[:, a] - flight.reference_position[:, b]
        cosine = (apart * wanted).sum(axis=1) / (
            np.linalg.norm(apart, axis=1) * np.linalg.norm(wanted, axis=1)
        )
        angle = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
        both = healthy[:, a] & healthy[:, b]
        assert angle[both].max() <= 60.0
        np.testing.assert_allclose(angle, flight.communication_angle_deg[:, i], atol=1e-5)


def test_the_governed_flight_is_that_of_the_figure():
    flight, m = flown("afrl_formation")
    assert abs(m["formed_at_step"] - 73) <= 3
    assert m["max_delta_v"] == pytest.approx(0.887, rel=0.01)
    assert m["min_separation"] == pytest.approx(1665.0, rel=0.01)
    require_limits(flight)
    assert m["constraints_kept"]
    assert (m["deadlocks"], m["inadmissible_steps"], m["fallback_steps"]) == (0, 0, 0)
    formed = int(m["formed_at_step"])
    assert len(set(flight.time_shift[formed])) == 1
    assert flight.formed[formed:].all()
    assert not flight.formed[formed - 1]


def test_the_ungoverned_flight_breaks_all_three_limits():
    _, m = flown("afrl_formation_ungoverned")
    assert m["max_delta_v"] == pytest.approx(1.219, rel=0.01)
    assert m["min_separation"] == pytest.approx(579.0, rel=0.01)
    assert [each["limit"] for each in m["limits_exceeded"]] == [
        "delta-v", "separation", "communication angle"
    ]  # fmt: skip


def test_a_deadlock_is_left_within_the_limits():
    flight, m = flown("afrl_formation_deadlock")
    require_limits(flight)
    assert m["deadlocks"] == 1
    assert not m["deadlocked"]
    assert m["passages"] > 0
    assert m["formed_at_step"] is not None


def test_a_deadlock_that_nothing_resolves_stays():
    short = {"plant__duration": 14000.0, "reference_governor__resolves_deadlocks": False}
    flight, m = flown("afrl_formation_deadlock", **short)
    assert m["deadlocked"]
    assert (m["formed_at_step"], m["passages"]) == (None, 0)
    assert m["final_position_error"] < 10.0  # parked all the same
    assert len(set(flight.time_shift[-1])) == 3


def test_two_craft_form_up_without_the_one_that_is_lost():
    flight, m = flown("afrl_formation_loss")
    require_limits(flight)
    assert m["spacecraft_lost"] == "sc3"
    assert not flight.healthy[25:, 2].any()
    assert flight.healthy[:25].all()
    noticed = m["spacecraft_loss_detected_at"] - m["spacecraft_lost_at"]
    assert 0.0 < noticed <= 3.0 * m["period"]
    assert m["false_alarms"] == []
    assert m["formed_at_step"] is not None
    error = flight.position[-1, :2] - flight.reference_position[-1, :2]
    assert np.linalg.norm(error, axis=1).max() < 10.0
    assert m["craft_final_error"][2] > 1000.0  # it drifts away


@pytest.mark.parametrize("motion", ["two_body", "two_body_j2"])
def test_motion_that_the_laws_do_not_know_keeps_the_limits(motion):
    flight, m = flown("afrl_formation_nonlinear", plant__motion=motion)
    require_limits(flight)
    assert abs(m["formed_at_step"] - 73) <= 3
    linear, _ = flown("afrl_formation_nonlinear", plant__motion="hill")
    apart = np.linalg.norm(flight.position - linear.position, axis=2).max()
    assert 1.0 < apart < 100.0
    assert m["false_alarms"] == []


def refused(capsys, *overrides):
    """Return the lines with which `gnc check` refuses a scenario, after asserting exit code 2."""
    words = [word for override in overrides for word in ("--set", override)]
    with pytest.raises(SystemExit) as ended:
        main(["check", "afrl_formation", *words])
    assert ended.value.code == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    lines = captured.err.strip().splitlines()
    assert all(line.startswith("error: ") or ": received " in line for line in lines)
    return captured.err


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        (["plant.max_delta_v=0.0"], "plant.max_delta_v: received 0.0"),
        (["plant.spacecraft=[sc1]"], "two spacecraft or more"),
        (["reference_governor.phase=[16, 0, 66]"], "sc1 and sc3 share a place"),
        (["plant.time_step=100.0"], "use 99.85976280263239 (55 control steps)"),
        (["plant.radial_semi_axis=500.0"], "sc1 and sc2 come as near as 849.307 m"),
    ],
)
def test_bad_input_is_refused_before_flight(overrides, words, capsys):
    assert words in refused(capsys, *overrides)


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        (["plant.max_delta_v=0.5"], ("delta-v of sc2", "limit 0.5 m/s", "now")),
        (
            [
                "plant.initial_phase=[29.0, 25.0, 33.0]",
                "plant.initial_along_track_offset=[7500.0, 3900.0, 7900.0]",
                "plant.initial_amplitude=[1.5, 1.6, 1.0]",
            ],
            ("separation of sc1 and sc3: 894.2 m", "limit 1000 m", "in 2 steps", "10.6 %"),
        ),
        (
            ["plant.max_communication_angle_deg=10.0"],
            ("angle between", "sc2 and sc3", "limit 10 deg", "in 21 steps"),
        ),
    ],
)
def test_a_start_without_admissible_shifts_tells_what_it_breaks(overrides, words, capsys):
    told = refused(capsys, *overrides)
    assert "plant.initial_phase" in told
    assert "125000 combinations" in told
    assert " %" in told
    for word in words:
        assert word in told
