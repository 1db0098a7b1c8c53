"""What is no bag of one whole flight is refused by every command: one line, exit code 2."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from bad_bags import CASES, ITEMS, BadBag, check_refused
from recording.bags import record

from spacecraft_gnc.cli.main import main

SCENARIO = """\
plant:
  ros__parameters:
    inertia: [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]
"""
COMMANDS = {
    "audit": ["audit"],
    "plot": ["plot", "--out", "{}/figures"],
    "report": ["report", "--out", "{}/report.html"],
    "export": ["export", "--format", "csv", "--out", "{}/flight.csv"],
    "replay": ["replay", "--out", "{}/figures"],
    "view": ["view", "--no-browser", "--port", "1"],
}
"""Every command that reads a flight; ``{}`` stands for a folder."""
IN_PART = {"a bag without a whole step", "a bag without torques"}
"""What `gnc export` writes as far as it goes: it tells of messages, not of control steps."""
WITHOUT_STEPS = {
    "a bag without topics",
    "a bag of another package",
    "a topic of another package",
    "a message of nothing we know",
}
"""What `gnc export` refuses by another line: it reads topics of any vehicle that carry a step."""
SEVERAL = "two spacecraft"
"""Read by `gnc report` (both) and `gnc view` (the first); `gnc audit` lacks their scenario."""
SERVERS = {"view"}
"""Those that serve a good bag until somebody ends them."""
NO_BAGS = [name for name, case in CASES.items() if case.required in ("a bag", "a bag folder")]
"""What holds no message at all, whole or not: even ``gnc recover`` has nothing to save."""


def filled(command: list[str], folder: Path) -> list[str]:
    return [word.format(folder) for word in command]


def case_for(command: str, name: str) -> BadBag:
    """Return the case with what this command says of it."""
    case = CASES[name]
    if command == "export" and name in WITHOUT_STEPS:
        return case._replace(received="no topic of a control step", required="a flight recorded by")
    if command == "audit" and name == SEVERAL:
        return case._replace(received="no scenario to audit by", required="scenario.yaml")
    return case


@pytest.mark.parametrize(
    ("name", "command"),
    [
        pytest.param(name, words, id=f"{name}-{command}")
        for name in CASES
        for command, words in COMMANDS.items()
        if name != SEVERAL or command not in {"report", "view"}
    ],
)
def test_refused(
    name: str, command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if command[0] == "export" and name in IN_PART:
        assert exported(CASES[name].make(tmp_path), tmp_path / "flight.npz") > 0
        return
    check_refused(case_for(command[0], name), tmp_path, capsys, *filled(command, tmp_path))


def test_several_spacecraft_are_reported_as_several_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = CASES[SEVERAL].make(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main([*filled(COMMANDS["report"], tmp_path), "--json", str(bag)])
    assert ended.value.code == 0
    runs = json.loads(capsys.readouterr().out)["runs"]
    assert [one["name"] for one in runs] == ["bag chaser", "bag target"]


def exported(bag: Path, target: Path) -> int:
    """Return how many topics ``gnc export`` writes."""
    with pytest.raises(SystemExit) as ended:
        main(["export", "-f", "npz", "-o", str(target), "-q", str(bag)])
    assert ended.value.code == 0
    with np.load(target) as arrays:
        return len({name.partition(".")[0] for name in arrays.files})


@pytest.mark.parametrize("name", NO_BAGS)
def test_nothing_to_recover(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    check_refused(CASES[name], tmp_path, capsys, "recover")


@pytest.mark.parametrize("name", sorted(COMMANDS.keys() - SERVERS))
def test_the_good_bag_is_read(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The bag that the cases spoil is none of them: it holds random numbers, but all of them."""
    bag = record(tmp_path / "bag", ITEMS, scenario=SCENARIO)
    with pytest.raises(SystemExit) as ended:
        main([*filled(COMMANDS[name], tmp_path), "--json", str(bag)])
    captured = capsys.readouterr()
    assert ended.value.code in (0, 1), captured.err
    assert json.loads(captured.out)
