"""What no governor could fly is refused before anything is started: one line, exit code 2."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from bad_governors import CASES, GOOD
from cli.test_bad_scenarios import run, write

COMMANDS = ["check", "simulate", "launch"]


def test_the_unspoilt_scenario_flies(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write(tmp_path, GOOD)
    code, out, err = run(capsys, "check", path)
    assert (code, err) == (0, "")
    assert "can fly" in out
    code, _, err = run(capsys, "simulate", path)
    assert (code, err) == (0, "")


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("name", CASES)
def test_no_command_flies_it(
    command: str, name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case = CASES[name]
    assert GOOD.count(case.old) == 1
    path = write(tmp_path, GOOD.replace(case.old, case.new))
    code, out, err = run(capsys, command, path)
    assert (code, out) == (2, "")
    lines = [line for line in err.splitlines() if f": {case.key}: received " in line]
    assert lines, err
    assert all(line.startswith(f"error: {path}") for line in err.splitlines())
    requirement, _, remedy = lines[0].partition("; required ")[2].partition("; ")
    assert case.required in requirement
    assert case.remedy in remedy
    assert [file.name for file in tmp_path.iterdir()] == ["scenario.yaml"]


def test_the_margin_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    case = CASES["target within the steady margin"]
    path = write(tmp_path, GOOD.replace(case.old, case.new))
    _, _, err = run(capsys, "check", path)
    assert err == (
        f"error: {path}:21: reference_governor.target_rotation_vector: received [0.0, 1.0468, "
        "0.0], an attitude 0.022778 deg from the border of inclusion zone 'earth'; required at "
        "least 0.1 deg at rest (reference_governor.steady_margin_deg); choose another target, or "
        "lower steady_margin_deg\n"
    )


def test_what_the_prediction_refuses_is_told_as_json_too(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case = CASES["start that drifts out of a zone"]
    path = write(tmp_path, GOOD.replace(case.old, case.new))
    code, out, err = run(capsys, "check", path, "--json")
    assert (code, err) == (2, "")
    (problem,) = json.loads(out)["problems"]
    assert problem["file"] == path
    assert problem["key"] == "reference_governor (start)"
    assert "'earth' at predicted step" in problem["value"]


def test_without_a_governor_the_same_limits_are_no_fault(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case = CASES["target within the steady margin"]
    text = GOOD.replace(case.old, case.new).replace("governor: attitude", "governor: none")
    for own in ("    max_torque: 0.02\n", "    max_momentum: 0.5\n"):
        text = text.replace(own, "")
    path = write(tmp_path, text)
    code, _, err = run(capsys, "check", path, "--set", "launcher.cut_short=true")
    assert (code, err) == (0, "")
