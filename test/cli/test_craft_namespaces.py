"""A flight of several craft: a craft means the flight, and another namespace is refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from formation_bags import fly, ungoverned

from spacecraft_gnc.analysis.agents import agents
from spacecraft_gnc.cli.main import main
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.steps import craft_in, flight_namespaces
from spacecraft_gnc.scenario import from_sections
from spacecraft_gnc.vehicles.formation.signals import COMMAND, STATE

STEPS = 9
COMMANDS = {
    "audit": ["audit"],
    "export": ["export", "--format", "csv", "--out", "{}/flight.csv"],
    "replay": ["replay"],
    "report": ["report", "--out", "{}/report.html"],
}


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return Path(fly(tmp_path_factory.mktemp("craft"), ungoverned()))


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    scenario = from_sections(ungoverned())
    flight = scenario.build().run()
    return Path(flight.save(tmp_path_factory.mktemp("craft") / "flight.npz", scenario.to_yaml()))


def run(*words: object) -> int:
    with pytest.raises(SystemExit) as ended:
        main([*map(str, words)])
    return int(ended.value.code or 0)


def steps_in(answer: dict[str, object]) -> object:
    runs = answer.get("runs")
    return runs[0]["metrics"]["steps"] if isinstance(runs, list) else answer.get("steps")


@pytest.mark.parametrize("name", ["sc2", "/", "/sc3"])
@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_a_craft_means_the_flight(
    command: list[str], name: str, bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [word.format(tmp_path) for word in command]
    assert run(*words, bag, "--namespace", name, "--json") == 0
    answer = json.loads(capsys.readouterr().out)
    if command[0] != "export":
        assert steps_in(answer) == STEPS
        return
    head = (tmp_path / "flight.csv").read_text().splitlines()[0]
    assert "hill_state.position.0" in head
    assert "sc1/delta_v_command.delta_v.x" in head


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_another_namespace_is_refused_in_one_line(
    command: list[str], bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [word.format(tmp_path) for word in command]
    assert run(*words, bag, "--namespace", "sc9") == 2
    (error,) = capsys.readouterr().err.splitlines()
    assert "in namespace sc9; required a flight" in error
    assert "/sc3/delta_v_command" in error


@pytest.mark.parametrize("name", ["sc2", "/", None])
def test_a_file_of_one_flight_is_read_by_its_craft(
    name: str | None, file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [] if name is None else ["--namespace", name]
    assert run("report", file, "--out", tmp_path / "page.html", *words, "--json") == 0
    assert steps_in(json.loads(capsys.readouterr().out)) == STEPS


def test_a_file_refuses_what_is_no_craft(
    file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("report", file, "--out", tmp_path / "page.html", "--namespace", "sc9") == 2
    (error,) = capsys.readouterr().err.splitlines()
    assert "a flight of several craft (/sc1, /sc2, /sc3), none of them sc9" in error


def test_the_craft_of_a_bag_are_no_flights(bag: Path) -> None:
    assert agents(bag) == (None,)
    with open_bag(bag) as opened:
        assert flight_namespaces(opened) == flight_namespaces(opened, [STATE]) == [""]
        assert craft_in(opened, COMMAND, STATE, "sc2") == ("sc1", "sc2", "sc3")
