"""A bag of two spacecraft: each command reads the one that ``--namespace`` names."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest
from flown_bags import SECTIONS, fly, messages_of
from recording.bags import announce

from spacecraft_gnc.cli.main import main
from spacecraft_gnc.recording.writer import BagWriter
from spacecraft_gnc.scenario.scenario import sections_to_yaml

STEPS = {"chaser": 12, "target": 7}


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a bag of two spacecraft, the second of which stopped early."""
    folder = tmp_path_factory.mktemp("two")
    flown = messages_of(fly(folder / "alone"))
    with BagWriter(folder / "bag") as both:
        both.attach("scenario.yaml", "application/yaml", sections_to_yaml(SECTIONS).encode())
        for name in STEPS:
            announce(both, f"/{name}")
        for topic, stamp, data in flown:
            for name, steps in STEPS.items():
                last = topic in ("/attitude_state", "/plant_invariants")
                if topic != "/wall_timing" and stamp < (steps + last) * 400_000_000:
                    both.write(f"/{name}{topic}", stamp, stamp, data)
    return folder / "bag"


def run(*words: object) -> int:
    with pytest.raises(SystemExit) as ended:
        main([*map(str, words)])
    return int(ended.value.code or 0)


COMMANDS = {
    "audit": ["audit", "--unfinished"],
    "plot": ["plot", "--only", "torque", "--format", "svg", "--out", "{}/figures"],
    "report": ["report", "--out", "{}/report.html"],
    "export": ["export", "--format", "csv", "--out", "{}/flight.csv"],
    "replay": ["replay"],
}


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
@pytest.mark.parametrize("name", STEPS)
def test_one_is_read(
    command: list[str], name: str, bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [word.format(tmp_path) for word in command]
    assert run(*words, bag, "--namespace", name, "--json") == 0
    answer = json.loads(capsys.readouterr().out)
    found = answer.get("steps")
    if command[0] == "plot":
        found = answer["metrics"]["steps"]
    elif command[0] == "report":
        found = answer["runs"][0]["metrics"]["steps"]
        assert ("all" in answer["runs"][0]["audit"]["text"]) == (name == "chaser")
    elif command[0] == "export":
        assert answer["left_out"] == []
        with (tmp_path / "flight.csv").open(newline="") as file:
            found = len(list(csv.reader(file))) - 2  # the head, and the state at the end
    assert found == STEPS[name]


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
@pytest.mark.parametrize(
    ("words", "reason"),
    [
        ([], "several spacecraft (/chaser, /target); required one; name it with --namespace"),
        (["--namespace", "third"], "no topic attitude_state in namespace third; required"),
    ],
)
def test_otherwise_it_is_refused(
    command: list[str],
    words: list[str],
    reason: str,
    bag: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(*(word.format(tmp_path) for word in command), bag, *words) == 2
    (error,) = capsys.readouterr().err.splitlines()
    assert reason in error
    assert list(tmp_path.iterdir()) == []
