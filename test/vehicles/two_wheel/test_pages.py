"""Report, figures, export and replay of a flight with wheels."""

from __future__ import annotations

import json

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from PIL import Image
from wheel_bags import fly, sections

from spacecraft_gnc.analysis.flown import flown
from spacecraft_gnc.analysis.reader import load_run
from spacecraft_gnc.cli.main import main
from spacecraft_gnc.drawing import style
from spacecraft_gnc.vehicles.two_wheel.animation import Scene, animated_run


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return fly(tmp_path_factory.mktemp("flown"))[0]


def told(capsys, *argv, code=0):
    """Return what a command prints on stdout and stderr, and require its exit code."""
    capsys.readouterr()
    try:
        main([*map(str, argv)])
        found = 0
    except SystemExit as end:
        found = end.code or 0
    captured = capsys.readouterr()
    assert found == code, captured.err
    return captured


def test_the_page_holds_the_wheels_and_the_audit(bag, tmp_path, capsys):
    page = tmp_path / "report.html"
    told(capsys, "report", bag, "-o", page, "-q")
    text = page.read_text()
    for words in ("Wheel speeds", "Wheel accelerations", "Total momentum", "Wheels lost"):
        assert words in text
    assert "badge passed" in text


@pytest.fixture(scope="module")
def watched(tmp_path_factory):
    """Return a bag of a flight with friction in which a lost wheel is noticed."""
    friction = {"wheel_viscous_friction": [1e-4] * 4, "wheel_coulomb_friction": [1e-3] * 4}
    flown = sections(plant={**friction, "wheel_lost_at": [-1.0, 3.0, -1.0, -1.0]})
    return fly(tmp_path_factory.mktemp("watched"), flown, watching=True)[0]


def test_the_page_marks_when_a_wheel_was_lost_and_excluded(watched, tmp_path, capsys):
    page = tmp_path / "report.html"
    told(capsys, "report", watched, "-o", page, "-q")
    text = page.read_text()
    for words in ("Residuals of the wheels", "wheel 2 lost", "wheel 2 excluded", "reallocated"):
        assert words in text
    found = json.loads(told(capsys, "report", watched, "-o", page, "--json", "-q").out)
    (run,) = found["runs"]
    assert run["metrics"]["wheel_lost_at"] == 3.0
    assert 3.0 < run["metrics"]["wheel_loss_detected_at"] <= 3.6
    assert run["metrics"]["modes"]["reallocated"] > 0


def test_two_flights_are_compared(bag, tmp_path, capsys):
    changed = sections(nmpc_controller={"feedback_damping_ratio": 0.7})
    other, _ = fly(tmp_path, changed)
    told(capsys, "report", bag, other, "-o", tmp_path / "two.html", "-q")
    told(capsys, "plot", bag, other, "-o", tmp_path / "two", "-f", "svg", "-q")
    names = {path.stem for path in (tmp_path / "two").iterdir()}
    assert names == {"comparison_error", "comparison_wheels"}


def test_every_figure_is_drawn(bag, tmp_path, capsys):
    out = told(capsys, "plot", bag, "-o", tmp_path, "-f", "svg", "--json", "-q").out
    names = {"overview", "attitude", "rate", "wheels", "momentum"}
    assert {path.stem for path in tmp_path.glob("*.svg")} == names
    assert json.loads(out)["metrics"]["wheel_lost_at"] == 1.0


def test_the_moving_picture_shows_a_lost_wheel_red_and_crossed_out(watched, tmp_path, capsys):
    path = tmp_path / "flight.gif"
    told(capsys, "plot", watched, watched, "--animate", path, "-q")
    with Image.open(path) as picture:
        assert (picture.size, picture.n_frames) == ((800, 640), 21)
    recorded = load_run(watched)
    run = animated_run(flown("watched", recorded, recorded.info.scenario), 0)
    red = [np.array(to_rgb(style.LIMIT_COLOR)) * 255.0]
    shown = []
    with style.applied():
        scene = Scene([run._replace(events=[], beliefs=[""] * 21, limit=0.0)])
        for time in (2.8, 3.0, 4.0):  # healthy; lost; excluded
            off = np.abs(scene.frame(time).astype(float) - red).max(axis=2)
            shown.append(int(np.count_nonzero(off < 8.0)))
    assert shown[0] == 0
    assert shown[1] > 50
    assert shown[2] > shown[1] + 20


def test_more_flights_than_fit_beside_each_other_are_refused(bag, tmp_path, capsys):
    error = told(capsys, "plot", *[bag] * 4, "--animate", tmp_path / "x.gif", code=2).err
    assert "received 4 runs; required 3" in error


def test_replay_repeats_the_commands_bit_for_bit(bag, capsys):
    same = json.loads(told(capsys, "replay", bag, "--json", "-q").out)
    assert (same["check"], same["first_difference"], same["steps"]) == ("exact", None, 20)
    other = "nmpc_controller.feedback_bandwidth=0.5"
    changed = json.loads(told(capsys, "replay", bag, "--set", other, "--json", "-q").out)
    assert changed["first_difference"] == 0
    assert changed["max_acceleration_difference"] > 0.1


def test_replay_draws_both(bag, tmp_path, capsys):
    told(capsys, "replay", bag, "--out", tmp_path, "-q")
    assert (tmp_path / "replay.svg").exists()
    error = told(capsys, "replay", bag, "--steps", "5:40", code=2).err
    assert "0 <= A < B <= 20" in error


def test_export_has_a_column_for_each_wheel(bag, tmp_path, capsys):
    told(capsys, "export", bag, "-f", "npz", "-o", tmp_path / "flight.npz", "-q")
    with np.load(tmp_path / "flight.npz") as arrays:
        speeds = [name for name in arrays.files if "wheel_speed" in name]
        assert speeds
        assert sum(arrays[name].reshape(21, -1).shape[1] for name in speeds) == 4
