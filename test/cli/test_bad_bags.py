"""What is no bag of one whole flight is refused by every command: one line, exit code 2."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from bad_bags import CASES, ITEMS, check_refused
from recording.bags import record

from spacecraft_gnc.cli.main import main

COMMANDS = {
    "audit": ["audit"],
    "plot": ["plot", "--out", "{}/figures"],
}
"""Every command that reads a bag; ``{}`` stands for a folder."""


def filled(command: list[str], folder: Path) -> list[str]:
    return [word.format(folder) for word in command]


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
@pytest.mark.parametrize("name", CASES)
def test_refused(
    name: str, command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    check_refused(CASES[name], tmp_path, capsys, *filled(command, tmp_path))


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_the_good_bag_is_read(
    command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The bag that the cases spoil is none of them: it holds random numbers, but all of them."""
    bag = record(tmp_path / "bag", ITEMS)
    with pytest.raises(SystemExit) as ended:
        main([*filled(command, tmp_path), "--json", str(bag)])
    captured = capsys.readouterr()
    assert ended.value.code in (0, 1), captured.err
    assert json.loads(captured.out)
