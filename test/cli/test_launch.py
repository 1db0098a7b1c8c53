"""What ``gnc launch`` makes of the bag that a flight has left."""

from __future__ import annotations

import json
import os
import re
import signal
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from flown_bags import fly, messages_of, rewrite, sections
from recording.bags import CODEC

from spacecraft_gnc.cli.launch import _never_published
from spacecraft_gnc.cli.main import main
from spacecraft_gnc.launcher.launcher import Launcher
from spacecraft_gnc.launcher.outcome import Interrupted, Outcome
from spacecraft_gnc.launcher.plan import LaunchPlan, make_plan
from spacecraft_gnc.recording.writer import BagWriter
from spacecraft_gnc.scenario import load
from spacecraft_gnc.scenario.fingerprint import fingerprint
from spacecraft_gnc.scenario.scenario import sections_to_yaml

CASE1 = Path(__file__).resolve().parents[2] / "config" / "gupta2015_case1.yaml"
STRING = "std_msgs/msg/String"
A = b"\0\1\0\0\2\0\0\0a\0"


def record(plan: LaunchPlan, lost: int) -> Outcome:
    """Leave a bag of one message and ``lost`` lost ones."""
    with BagWriter(plan.bag) as bag:
        bag.add_topic("/words", STRING, CODEC.texts[STRING])
        bag.add_topic("/silent", STRING, CODEC.texts[STRING])
        bag.write("/words", 0, 0, A)
        bag.report_loss("/words", lost)
    return Outcome(
        domain_id=1,
        steps=1,
        simulated_time=0.4,
        wall_time=0.1,
        startup_time=1.0,
        missed_deadlines=0,
        restarts=(),
        bags=(str(plan.bag),),
    )


@pytest.mark.parametrize("lost", [0, 7])
def test_a_loss_is_a_failure(monkeypatch: Any, capsys: Any, tmp_path: Path, lost: int) -> None:
    monkeypatch.setattr(Launcher, "run", lambda self: record(self.plan, lost))
    code = 0
    try:
        main(["launch", str(CASE1), "--out", str(tmp_path / "run"), "--quiet"])
    except SystemExit as end:
        code = int(end.code or 0)
    out, err = capsys.readouterr()
    bag = tmp_path / "run" / "bag"
    shout = f"error: {bag}: MESSAGES LOST, the bag is not complete: /words 7\n"
    assert (code, out, err) == ((1, "", shout) if lost else (0, "", ""))


def test_a_stranger_is_a_failure(monkeypatch: Any, capsys: Any, tmp_path: Path) -> None:
    """It was named when it came; the summary repeats who it was, and who refused how much."""
    line = "/torque_command: /stranger"
    refused = {"plant": {"torque_command/seal": 3, "torque_command/step": 2}}

    def run(self: Launcher) -> Outcome:
        return replace(record(self.plan, 0), bags=(), strangers=(line,), refused=refused)

    monkeypatch.setattr(Launcher, "run", run)
    told = []
    for name, option in (("a", "--quiet"), ("b", "--json"), ("c", "--strict")):
        given = () if option == "--strict" else (option,)
        with pytest.raises(SystemExit) as end:
            main(["launch", str(CASE1), "--out", str(tmp_path / name), *given])
        assert end.value.code == 1
        told.append(capsys.readouterr().out)
    assert told[0] == ""
    values = json.loads(told[1])
    assert (values["strangers"], values["messages_refused"]) == ([line], refused)
    rows = dict(re.split(r"\s{2,}", text.strip(), maxsplit=1) for text in told[2].splitlines()[1:])
    assert rows["STRANGER"] == line
    assert rows["messages refused"] == "5 by plant: torque_command/seal 3, torque_command/step 2"


def test_limits_cannot_be_judged_without_a_recording(capsys: Any, tmp_path: Path) -> None:
    out_folder = tmp_path / "run"
    with pytest.raises(SystemExit) as end:
        main(["launch", str(CASE1), "--no-record", "--strict", "--out", str(out_folder)])
    out, err = capsys.readouterr()
    assert (end.value.code, out) == (2, "")
    assert err.startswith("error: --strict: received a flight without a recorder; required one, ")
    assert not out_folder.exists()


@pytest.mark.parametrize("penalty", [1.0, 1e10])
def test_a_limit_that_is_exceeded_fails_if_asked(
    monkeypatch: Any, capsys: Any, tmp_path: Path, penalty: float
) -> None:
    """The flight is that of the cores; what is made of its bag is the command's."""
    flown = sections(nmpc_controller={"torque_penalty": penalty}, launcher={"cut_short": True})
    file = tmp_path / "soft.yaml"
    file.write_text(sections_to_yaml(flown), encoding="utf-8")

    def recorded(launcher: Launcher) -> Outcome:
        bag = fly(tmp_path, flown)
        kept = [item for item in messages_of(bag) if item[0] != "/wall_timing"]
        whole = rewrite(bag, tmp_path / "whole", kept)
        return replace(record(launcher.plan, 0), bags=(str(whole),))

    monkeypatch.setattr(Launcher, "run", recorded)
    code = 0
    try:
        main(["launch", str(file), "--out", str(tmp_path / "run"), "--strict", "--json"])
    except SystemExit as end:
        code = int(end.code or 0)
    out, err = capsys.readouterr()
    metrics = json.loads(out)
    assert metrics["scenario_hash"] == fingerprint(load(file))
    if penalty == 1.0:
        (exceeded,) = metrics["limits_exceeded"]
        assert code == 1
        assert f"limits exceeded: {exceeded['text']}; --strict requires" in err
    else:
        assert (code, err, metrics["limits_exceeded"]) == (0, "", [])


def test_a_loss_is_told_after_ctrl_c_too(monkeypatch: Any, capsys: Any, tmp_path: Path) -> None:
    def interrupted(launcher: Launcher) -> Outcome:
        record(launcher.plan, 7)
        raise Interrupted(signal.SIGINT)

    monkeypatch.setattr(Launcher, "run", interrupted)
    with pytest.raises(SystemExit) as end:
        main(["launch", str(CASE1), "--out", str(tmp_path / "run"), "--quiet"])
    assert end.value.code == 130
    ended, where, shout = capsys.readouterr().err.splitlines()
    assert ended == "error: ended by SIGINT"
    assert where == f"  recorded until then in {tmp_path}/run/bag"
    assert "MESSAGES LOST" in shout


def test_topics_that_nobody_published(tmp_path: Path) -> None:
    topics = "recorder.topics=['*', words, /silent, /nowhere/at_all]"
    plan = make_plan(CASE1, [topics], out=tmp_path / "run")
    assert _never_published(plan, record(plan, 0)) == ["/silent", "/nowhere/at_all"]


def test_ctrl_c_while_the_command_is_loaded(monkeypatch: Any) -> None:
    from spacecraft_gnc import __main__

    def interrupt() -> None:
        os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr("spacecraft_gnc.cli.main.main", interrupt)
    # a shell starts what it puts into the background with SIGINT ignored
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(SystemExit) as end:
            __main__.main()
    finally:
        signal.signal(signal.SIGINT, before)
    assert end.value.code == 130
