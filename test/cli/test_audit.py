"""``gnc audit`` as a user meets it."""

from __future__ import annotations

import json
import math

import pytest
from cli.test_bad_scenarios import run
from flown_bags import fly, messages_of, rewrite


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return fly(tmp_path_factory.mktemp("flown"))


@pytest.fixture(scope="module")
def tampered(bag, tmp_path_factory):
    """Return the bag with the lowest bit of the commanded torque of step 5 changed."""
    changed = []
    for topic, stamp, data in messages_of(bag):
        other = bytearray(data)
        if (topic, stamp) == ("/torque_command", 5 * 400_000_000):
            other[36] ^= 1
        changed.append((topic, stamp, bytes(other)))
    return rewrite(bag, tmp_path_factory.mktemp("tampered") / "bag", changed)


@pytest.fixture(autouse=True)
def no_progress(monkeypatch):
    """Let no machine be so slow that it tells of its progress."""
    monkeypatch.setattr("spacecraft_gnc.cli._progress._PATIENCE", math.inf)


def test_a_flight_that_is_what_it_says(bag, capsys):
    code, out, err = run(capsys, "audit", str(bag))
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert lines[0].split() == ["check", "steps", "worst", "tolerance", "verdict"]
    assert lines[-1] == f"{bag}: 12 control steps, every check that applies passed"
    (skipped,) = [line for line in lines if line.strip().startswith("zone margins")]
    assert "not applicable  the scenario has no zones" in skipped
    assert not any(line.endswith(" ") for line in lines)


def test_a_flight_that_is_not(tampered, capsys):
    code, out, err = run(capsys, "audit", str(tampered))
    assert code == 1
    assert "FAIL" in out
    assert "first at step 5: torque_command.torque[0]" in out
    assert err == (
        f"error: {tampered}: the first difference is at step 5, torque_command.torque[0] (command "
        "= first torque of the plan); required bit for bit; 2 of 39 checks failed\n"
    )


def test_json_and_nothing_else(bag, tampered, capsys):
    code, out, err = run(capsys, "audit", str(bag), "--json")
    answer = json.loads(out)
    assert (code, err) == (0, "")
    assert answer["passed"]
    assert answer["first"] is None
    code, out, err = run(capsys, "audit", str(tampered), "--json")
    answer = json.loads(out)
    assert code == 1
    assert not answer["passed"]
    assert answer["first"] == {
        "check": "command = first torque of the plan",
        "step": 5,
        "field": "torque_command.torque[0]",
    }
    verdicts = {check["check"]: check["verdict"] for check in answer["checks"]}
    assert verdicts["applied torque = command"] == "FAIL"
    assert verdicts["integrator, from each state"] == "pass"


def test_quiet_says_errors_only(bag, tampered, capsys):
    assert run(capsys, "audit", str(bag), "--quiet") == (0, "", "")
    code, out, err = run(capsys, "audit", str(tampered), "-q")
    assert (code, out) == (1, "")
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize("value", ["-1", "nan", "inf"])
def test_a_tolerance_that_is_none(bag, capsys, value):
    code, out, err = run(capsys, "audit", str(bag), f"--tolerance={value}")
    assert (code, out) == (2, "")
    assert err.startswith("error: --tolerance: received ")
    assert "; required a number >= 0; " in err


def test_a_bag_without_a_scenario(bag, capsys, tmp_path):
    from recording.bags import record

    plain = record(
        tmp_path / "bag", [(t[1:], s // 400_000_000, d) for t, s, d in messages_of(bag)
                           if t != "/wall_timing"],
    )  # fmt: skip
    code, out, err = run(capsys, "audit", str(plain))
    assert (code, out) == (2, "")
    assert "received no scenario to audit by (none is attached); required" in err


def test_a_folder_of_a_run_is_audited_too(bag, capsys):
    assert run(capsys, "audit", str(bag.parent), "--quiet") == (0, "", "")
