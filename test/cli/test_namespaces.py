"""A bag of two spacecraft: each command reads the one that ``--namespace`` names."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest
from flown_bags import SECTIONS, announce_all, fly, messages_of

from spacecraft_gnc.cli.main import main
from spacecraft_gnc.recording.writer import BagWriter
from spacecraft_gnc.scenario.provenance import RUN_RECORD
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
            announce_all(both, namespace=f"/{name}")
        for topic, stamp, data in flown:
            if topic == "/clock":  # one for both
                both.write(topic, stamp, stamp, data)
            for name, steps in STEPS.items():
                last = topic in ("/attitude_state", "/plant_invariants", "/pose")
                if topic not in ("/wall_timing", "/clock") and stamp < (steps + last) * 400_000_000:
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
        assert f"/{name}/attitude_state" not in answer["left_out"]
        with (tmp_path / "flight.csv").open(newline="") as file:
            found = len(list(csv.reader(file))) - 2  # the head, and the state at the end
    assert found == STEPS[name]


ONE = "several spacecraft (/chaser, /target); required one; name it with --namespace"
THIRD = ["--namespace", "third"], "in namespace third; required a flight"


@pytest.mark.parametrize(
    ("command", "words", "reason"),
    [
        *((command, *THIRD) for command in COMMANDS.values()),
        *((COMMANDS[name], [], ONE) for name in ("plot", "export", "replay")),
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


def test_all_are_audited_and_named(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("audit", "--unfinished", bag) == 0
    out = capsys.readouterr().out
    assert [line for line in out.splitlines() if line.endswith(":")] == ["chaser:", "target:"]
    assert run("audit", "--unfinished", bag, "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["bag"], told["passed"]) == (str(bag), True)
    assert {name: audit["steps"] for name, audit in told["agents"].items()} == STEPS


def test_the_one_that_differs_is_named(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Only the second one stopped before its scenario was over."""
    assert run("audit", bag) == 1
    (error,) = capsys.readouterr().err.splitlines()[-1:]
    assert f"{bag}: target: the first difference is at step 7" in error


def test_all_are_shown_side_by_side(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("report", "--out", tmp_path / "both.html", bag, "--json") == 0
    runs = json.loads(capsys.readouterr().out)["runs"]
    assert {one["name"]: one["metrics"]["steps"] for one in runs} == {
        f"bag {name}": steps for name, steps in STEPS.items()
    }


def test_a_vehicle_that_is_not_installed_is_named_and_its_bag_can_still_be_exported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    flown = messages_of(fly(tmp_path / "alone"))
    with BagWriter(tmp_path / "bag") as one:
        announce_all(one)
        one.metadata(RUN_RECORD, {"vehicle": "sail", "vehicle_package": "sails 2.0"})
        for topic, stamp, data in flown:
            if topic != "/wall_timing":
                one.write(topic, stamp, stamp, data)
    reason = "received a flight of vehicle 'sail' of package sails 2.0, which is not installed"
    for command in (["audit"], ["report", "--out", tmp_path / "report.html"], ["plot"]):
        assert run(*command, tmp_path / "bag") == 2
        (error,) = capsys.readouterr().err.splitlines()
        assert reason in error
    out = tmp_path / "flight.csv"
    assert run("export", tmp_path / "bag", "--format", "csv", "--out", out) == 0
    assert out.stat().st_size > 1000
