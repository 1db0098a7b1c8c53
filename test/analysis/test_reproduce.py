"""``gnc reproduce``: the papers' figures come out, and what is printed, written and refused."""

from __future__ import annotations

import contextlib
import io
import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.cli.main import main
from spacecraft_gnc.scenario import load
from spacecraft_gnc.scenario.shipped import shipped
from spacecraft_gnc.studies import PAPERS, bagherzadeh2023_study
from spacecraft_gnc.studies.report import Check, Table, seconds, table_lines


@pytest.fixture(scope="module", autouse=True)
def coarse_laws():
    """Solve fewer points of the laws of two wheels than are drawn in docs/reproduce."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("spacecraft_gnc.studies.afrl2016_two_wheel_study.POINTS", 24)
        patch.setattr("spacecraft_gnc.studies.afrl2016_two_wheel_study.CELLS", 3)
        yield


def run(*arguments):
    """Run ``gnc reproduce`` and return its exit code."""
    with pytest.raises(SystemExit) as ended:
        main(["reproduce", *map(str, arguments)])
    return ended.value.code or 0


class Everything(NamedTuple):
    """All papers, run as a user does: exit code, figures, stdout and folder of the pictures."""

    code: int
    results: dict[str, Any]
    printed: str
    folder: Path


@pytest.fixture(scope="module")
def everything(tmp_path_factory):
    file = tmp_path_factory.mktemp("reproduce") / "figures.json"
    folder = file.with_name("pictures")
    with contextlib.redirect_stdout(io.StringIO()) as out:
        code = run("--no-baselines", "--runs", 0, "--json", file, "--out", folder)
    results = json.loads(file.read_text(encoding="utf-8"))
    return Everything(code, results, out.getvalue(), folder)


@pytest.fixture(scope="module")
def bagherzadeh(everything):
    return everything.results["bagherzadeh2023"]["values"]


@pytest.mark.long
@pytest.mark.parametrize("paper", PAPERS)
def test_every_figure_comes_out(everything, paper):
    checks = everything.results[paper]["checks"]
    assert len(checks) > 20
    assert not [check for check in checks if not check["ok"]]


@pytest.mark.long
def test_the_report_is_as_wide_as_a_wide_terminal(everything):
    lines = everything.printed.splitlines()
    assert max(len(line) for line in lines if not line.startswith("written to ")) <= 132
    assert not any(line != line.rstrip() for line in lines)


@pytest.mark.long
def test_neighboring_extremals_do_not_drift_but_their_open_loop_does(bagherzadeh):
    for start in bagherzadeh["starts"].values():
        largest, end = start["error_max_deg"], start["error_end_deg"]
        assert end["NE not cut"] < 0.02 * largest["NE not cut"] + 0.01
        assert end["NE open loop"] > 100.0 * end["NE not cut"]
        assert largest["NE on line"] < largest["NE + exact every 10"] < largest["NE"]
        assert start["hit_rate"] > 0.8


@pytest.mark.long
def test_the_estimated_sensitivities_lead_to_the_same_torques(bagherzadeh):
    for variant in bagherzadeh["variants"].values():
        assert np.max(variant["integral_square_error"]) < 1e-18


@pytest.mark.parametrize("name", ["bagherzadeh2023_ne", "bagherzadeh2023_ne_exact10"])
def test_the_second_initial_condition_is_that_of_the_scenarios(name):
    angle, axis = bagherzadeh2023_study.STARTS[bagherzadeh2023_study.TIMED]
    start = lie.log(bagherzadeh2023_study.start_of(angle, axis))
    # The file has twelve digits.
    assert load(shipped(name)).plant.initial_rotation_vector == pytest.approx(start, abs=1e-12)


@pytest.mark.long
def test_all_papers_are_run_printed_written_and_drawn(everything):
    code, results, printed, folder = everything
    assert code == 0
    assert list(results) == list(PAPERS)
    for result in results.values():
        assert result["ok"]
        assert result["title"] in printed
        assert all(check["quantity"] in printed for check in result["checks"])
    flights = results["gupta2015"]["values"]["flights"]
    assert flights["I, backward sweep"]["metrics"]["saturated_steps"] == 32
    assert flights["I, backward sweep"]["times"]["total"] > 0.0
    pictures = sorted(folder.iterdir())
    assert [path.stem for path in pictures] == [
        "afrl2016_circle", "afrl2016_docking_constraints", "afrl2016_docking_controls",
        "afrl2016_docking_references", "afrl2016_docking_snapshots",
        "afrl2016_docking_thruster_failed", "afrl2016_docking_tilted", "afrl2016_euler_angles",
        "afrl2016_formation", "afrl2016_formation_deadlock", "afrl2016_formation_loss",
        "afrl2016_formation_nonlinear", "afrl2016_plane", "afrl2016_wheels",
        "bagherzadeh2023_extremals", "bagherzadeh2023_variants", "governed_nmpc",
        "gupta2015_case1", "gupta2015_case2", "kalabic2014_flip", "kalabic2014_governor",
        "kalabic2014_nmpc", "phogat_figure4", "phogat_range",
    ]  # fmt: skip
    for path in pictures:
        assert path.stat().st_size > 40_000
        assert str(path) in printed


@pytest.mark.parametrize(
    ("name", "remedy"), [("gupta2016", "did you mean gupta2015?"), ("x", "choose one")]
)
def test_a_wrong_name_is_one_line_and_exit_code_2(name, remedy, capsys):
    assert run(name) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("error: ")
    assert len(captured.err.splitlines()) == 1
    assert remedy in captured.err
    assert captured.out == ""


def test_a_file_that_cannot_be_written_is_refused_before_anything_flies(tmp_path, capsys):
    assert run("gupta2015", "--json", tmp_path / "none" / "file.json", "--out", tmp_path) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("error: --json: received ")
    assert "mkdir -p" in captured.err
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_a_file_is_refused_before_anything_flies(tmp_path, capsys):
    (tmp_path / "figures").write_text("mine")
    assert run("gupta2015", "--out", tmp_path / "figures") == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: --out: received ")
    assert "a file; required a folder" in line


def test_a_figure_that_does_not_come_out_ends_with_1(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("spacecraft_gnc.studies.bagherzadeh2023.LINEAR", (0.9, 3.6, 7.0))
    assert run("bagherzadeh2023", "--quiet", "--out", tmp_path) == 1
    captured = capsys.readouterr()
    assert captured.out == ""
    (line,) = captured.err.splitlines()
    assert line.startswith("error: reproduce: 1 figure did not come out")
    assert "10 deg, [1,1,1]: NE open loop" in line


@pytest.mark.parametrize(("ours", "ok"), [(1.05, True), (0.85, False), (np.nan, False)])
def test_a_check_holds_within_its_tolerance(ours, ok):
    assert Check("", 1.0, ours, 0.1).ok is ok


def test_a_table_is_aligned():
    table = Table("title", ("name", "value"), [("a", "1"), ("long name", "22")], ["note"])
    assert list(table_lines(table)) == [
        "title", "  name       value", "  a              1", "  long name     22", "  note",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("value", "text"), [(12.345, "12.35 s"), (0.0123, "12.3 ms"), (1.2e-5, "12 us"), (np.nan, "-")]
)
def test_times_in_their_unit(value, text):
    assert seconds(value) == text
