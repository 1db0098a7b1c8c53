"""``gnc plot`` as a user meets it."""

from __future__ import annotations

import json

import pytest
from analysis.flights import DATA, at_rest, case1
from flown_bags import fly

from spacecraft_gnc.cli.main import main

SCENARIO = DATA.parents[1] / "config" / "gupta2015_case1.yaml"
KALABIC = SCENARIO.with_name("kalabic2014_governor.yaml")
MOTION = ("overview", "attitude_error", "momentum", "torque", "sphere", "solver")
RECORD = (
    "quaternion", "roll_pitch_yaw", "rotation_vector", "sources", "invariants", "residual",
    "solve_times",
)  # fmt: skip


@pytest.fixture
def flight(tmp_path):
    return case1().save(tmp_path / "case1.npz")


def run(*arguments):
    """Run ``gnc plot`` and return its exit code."""
    with pytest.raises(SystemExit) as ended:
        main(["plot", *map(str, arguments)])
    return ended.value.code or 0


def test_the_files_are_named_on_stdout(flight, tmp_path, capsys):
    assert run(flight, "-o", tmp_path / "out", "-f", "svg", "--scenario", SCENARIO) == 0
    printed = capsys.readouterr().out.split()
    assert printed == [str(path) for path in sorted_as_printed(tmp_path / "out", printed)]
    names = [path.rpartition("/")[2].removesuffix(".svg") for path in printed]
    assert names == [*MOTION, *RECORD]


def sorted_as_printed(folder, printed):
    return sorted(folder.iterdir(), key=lambda path: printed.index(str(path)))


def test_the_default_folder_is_named_after_the_source(flight, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run(flight, "--format", "pdf", "--quiet", "--only", "overview") == 0
    assert capsys.readouterr().out == ""
    assert (tmp_path / "case1-figures" / "overview.pdf").is_file()


def test_json_names_files_and_metrics(flight, tmp_path, capsys):
    arguments = ("-o", tmp_path / "out", "-f", "svg", "--json", "--scenario", SCENARIO)
    assert run(flight, *arguments, "--only", "torque", "--only", "residual") == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["metrics"]["saturated_steps"] == 32
    names = ("torque", "residual")
    assert answer["files"] == [str(tmp_path / "out" / f"{name}.svg") for name in names]


@pytest.mark.parametrize(
    ("name", "reason"),
    [("none.npz", "cannot be read"), ("none", "no such file"), (".", "a folder without a bag")],
)
def test_bad_input_is_one_line_and_exit_code_2(tmp_path, capsys, name, reason):
    assert run(tmp_path / name, "-o", tmp_path / "out") == 2
    captured = capsys.readouterr()
    assert captured.err.startswith("error: ")
    assert len(captured.err.splitlines()) == 1
    assert reason in captured.err
    assert captured.out == ""
    assert not (tmp_path / "out").exists()


def test_a_folder_that_is_a_file_is_refused(flight, tmp_path, capsys):
    (tmp_path / "out").write_text("mine")
    assert run(flight, "-o", tmp_path / "out") == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "a file; required a folder" in line


def test_an_unknown_format_is_refused(flight, capsys):
    assert run(flight, "-f", "gif") == 2
    assert "gif" in capsys.readouterr().err


def test_what_is_missing_is_a_warning_on_stderr(tmp_path, capsys):
    from recording.bags import flight_messages, random_flight, record

    items = [
        item for item in flight_messages(random_flight(5)) if item[:2] != ("attitude_reference", 2)
    ]
    bag = record(tmp_path / "bag", items)
    assert run(bag, "-o", tmp_path / "out", "-f", "svg", "--only", "attitude_error") == 0
    captured = capsys.readouterr()
    assert "warning: " in captured.err
    assert "attitude_reference lacks step 2" in captured.err
    assert captured.out == f"{tmp_path / 'out' / 'attitude_error.svg'}\n"


@pytest.mark.parametrize("named", ["case1-1", "case1-1/bag"])
def test_the_folder_of_a_run_is_as_good_as_its_bag(tmp_path, capsys, monkeypatch, named):
    from recording.bags import flight_messages, random_flight, record

    (tmp_path / "case1-1").mkdir()
    (tmp_path / "case1-1" / "scenario.yaml").write_text("")
    record(tmp_path / "case1-1" / "bag", flight_messages(random_flight(5)))
    monkeypatch.chdir(tmp_path)
    assert run(named, "-f", "svg", "--only", "torque") == 0
    assert capsys.readouterr().out == "case1-1-figures/torque.svg\n"


def test_only_the_figures_asked_for_are_drawn(flight, tmp_path, capsys):
    only = ("--only", "residual", "--only", "quaternion")
    assert run(flight, "-o", tmp_path / "out", "-f", "pdf", *only) == 0
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "residual.pdf",
        "quaternion.pdf",
    }


def test_a_figure_that_a_flight_has_not_is_refused_with_those_it_has(flight, tmp_path, capsys):
    assert run(flight, "-o", tmp_path / "out", "--only", "curvature") == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "received 'curvature'" in line
    assert "residual" in line
    assert not (tmp_path / "out").exists()


def test_several_flights_are_drawn_over_each_other(flight, tmp_path, capsys):
    other = case1().save(tmp_path / "other.npz")
    assert run(flight, other, "-o", tmp_path / "out", "-f", "svg", "--json") == 0
    answer = json.loads(capsys.readouterr().out)
    assert list(answer["runs"]) == ["case1", "other"]
    names = {path.stem for path in (tmp_path / "out").iterdir()}
    assert names >= {"attitude_error", "torque", "residual", "solve_times", "sources"}


def test_a_run_without_its_scenario_says_how_to_give_it(flight, tmp_path, capsys):
    words = ("-o", tmp_path / "out", "-f", "svg", "--only", "torque")
    assert run(flight, *words) == 0
    assert capsys.readouterr().err == (
        f"note: {flight}: the scenario is not known: no torque limit, no zones, no cost; name it "
        "with --scenario\n"
    )
    assert run(flight, *words, "--scenario", SCENARIO) == 0
    assert capsys.readouterr().err == ""


def test_a_scenario_beside_the_recorded_one_is_not_used(tmp_path, capsys):
    bag = fly(tmp_path)
    words = ("-o", tmp_path / "out", "-f", "svg", "--only", "torque", "--json")
    assert run(bag, *words) == 0
    own = json.loads(capsys.readouterr().out)
    assert run(bag, *words, "--scenario", KALABIC) == 0
    told = capsys.readouterr()
    assert json.loads(told.out) == own
    assert f"note: {bag}: holds what flew; --scenario is not used" in told.err.splitlines()


def test_a_moving_picture_is_written_instead_of_the_figures(tmp_path, capsys):
    runs = [at_rest(3).save(tmp_path / f"{name}.npz") for name in ("one", "two")]
    picture = tmp_path / "both.gif"
    assert run(*runs, "--animate", picture, "--scenario", SCENARIO) == 0
    assert capsys.readouterr().out == f"{picture}\n"
    assert sorted(tmp_path.iterdir()) == sorted([*runs, picture])


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (("--animate", "flight.mp4"), "--animate: received 'flight.mp4', no .gif file"),
        (("--animate", "none/flight.gif"), "in a folder that does not exist"),
        (("--animate", "flight.gif", "--only", "torque"), "--animate: received with --only"),
    ],
)
def test_a_moving_picture_is_refused_in_one_line(flight, options, reason, capsys):
    assert run(flight, *options) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert reason in line
