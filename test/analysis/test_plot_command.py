"""``gnc plot`` as a user meets it."""

from __future__ import annotations

import json

import numpy as np
import pytest
from analysis.flights import DATA, case1

from spacecraft_gnc.cli.main import main

SCENARIO = DATA.parents[1] / "config" / "gupta2015_case1.yaml"


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
    assert len(printed) == 6


def sorted_as_printed(folder, printed):
    return sorted(folder.iterdir(), key=lambda path: printed.index(str(path)))


def test_the_default_folder_is_named_after_the_source(flight, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run(flight, "--format", "pdf", "--quiet") == 0
    assert capsys.readouterr().out == ""
    assert (tmp_path / "case1-figures" / "overview.pdf").is_file()


def test_json_names_files_and_metrics(flight, tmp_path, capsys):
    arguments = ("-o", tmp_path / "out", "-f", "svg", "--json", "--scenario", SCENARIO)
    assert run(flight, *arguments) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["metrics"]["saturated_steps"] == 32
    assert len(answer["files"]) == 6


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


def test_an_unknown_format_is_refused(flight, capsys):
    assert run(flight, "-f", "gif") == 2
    assert "gif" in capsys.readouterr().err


def test_what_is_missing_is_a_warning_on_stderr(tmp_path, capsys):
    from recording.bags import flight_messages, random_flight, record

    items = [
        item for item in flight_messages(random_flight(5)) if item[:2] != ("attitude_reference", 2)
    ]
    bag = record(tmp_path / "bag", items)
    assert run(bag, "-o", tmp_path / "out", "-f", "svg") == 0
    captured = capsys.readouterr()
    assert "warning: " in captured.err
    assert "attitude_reference lacks step 2" in captured.err
    assert np.all([line.endswith(".svg") for line in captured.out.split()])


@pytest.mark.parametrize("named", ["case1-1", "case1-1/bag"])
def test_the_folder_of_a_run_is_as_good_as_its_bag(tmp_path, capsys, monkeypatch, named):
    from recording.bags import flight_messages, random_flight, record

    (tmp_path / "case1-1").mkdir()
    (tmp_path / "case1-1" / "scenario.yaml").write_text("")
    record(tmp_path / "case1-1" / "bag", flight_messages(random_flight(5)))
    monkeypatch.chdir(tmp_path)
    assert run(named, "-f", "svg") == 0
    printed = capsys.readouterr().out.split()
    assert {line.rpartition("/")[0] for line in printed} == {"case1-1-figures"}
