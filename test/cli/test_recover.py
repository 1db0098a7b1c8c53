"""What is told of bags with losses, and what ``gnc recover`` refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from recording.bags import announce, flight_messages, random_flight

from spacecraft_gnc.cli.launch import _shout_losses
from spacecraft_gnc.cli.main import main
from spacecraft_gnc.recording.writer import BagWriter


@pytest.fixture
def cut(tmp_path: Path) -> Path:
    """Return a bag whose recorder was killed."""
    bag = BagWriter(tmp_path / "bag")
    announce(bag)
    for topic, step, data in flight_messages(random_flight(12)):
        bag.write(f"/{topic}", step * 10**9, step * 10**9, data)
    bag.abort()
    return tmp_path / "bag"


def gnc(*words: object) -> int:
    with pytest.raises(SystemExit) as ended:
        main(["recover", *map(str, words)])
    return int(ended.value.code or 0)


def test_it_tells_what_was_saved_and_what_was_not(
    cut: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert gnc(cut) == 0
    told = capsys.readouterr()
    assert told.err == ""
    rows = {line.split("  ")[1].strip(): line for line in told.out.splitlines()[1:]}
    assert told.out.startswith(f"{cut}: 74 messages recovered into {cut}-recovered\n")
    assert rows["/attitude_state"].endswith(" 13")
    assert rows["/torque_command"].endswith(" 12")
    assert rows["last whole step"].endswith(" 11")
    assert rows["recorded until"].endswith(" 12 s")
    assert rows["not in the file"].endswith("its last second at most")


def test_json(cut: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "new"
    assert gnc(cut, "--out", out, "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert told["out"] == str(out)
    assert told["messages"] == sum(told["topics"].values()) == 74
    assert told["last_whole_step"] == 11
    assert (told["cut_bytes"], told["damaged_chunks"], told["missing_steps"]) == (0, 0, {})


def test_quiet(cut: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert gnc(cut, "--quiet") == 0
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize("flags", [[], ["--json"], ["--quiet"]])
def test_a_whole_bag_and_an_existing_output(
    cut: Path, flags: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert gnc(cut, "--quiet") == 0
    whole = f"{cut}-recovered"
    for words, reason in (
        ([whole], f"error: {whole}: received a whole bag; required one that was cut off; "),
        ([cut], f"error: {whole}: exists and is not an empty folder; "),
    ):
        assert gnc(*words, *flags) == 2
        told = capsys.readouterr()
        assert told.out == ""
        assert told.err.startswith(reason)
        assert len(told.err.splitlines()) == 1


def test_a_launch_shouts_what_its_bag_lacks(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with BagWriter(tmp_path / "bag") as bag:
        announce(bag)
        for topic, step, data in flight_messages(random_flight(3)):
            bag.write(f"/{topic}", step, step, data)
        bag.report_loss("/torque_command", 7)
    assert _shout_losses([])
    assert not _shout_losses([tmp_path / "bag"])
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err == (
        f"error: {tmp_path}/bag: MESSAGES LOST, the bag is not complete: /torque_command 7\n"
    )


def test_the_folder_of_a_run_is_enough(cut: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cut.name == "bag"
    assert gnc(cut.parent) == 0
    assert capsys.readouterr().out.startswith(f"{cut.parent}: 74 messages recovered into {cut}-")
