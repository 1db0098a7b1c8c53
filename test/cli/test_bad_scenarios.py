"""Every scenario a user can get wrong: one clear line, exit code 2, no traceback."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import yaml
from bad_controllers import CONTROLLER_CASES
from bad_scenarios import CASES, FILES, GOOD, SETTINGS, Bad

from spacecraft_gnc.cli.main import main


def run(capsys: pytest.CaptureFixture[str], *argv: str) -> tuple[int, str, str]:
    """Run ``gnc`` in this process; return exit code, stdout and stderr."""
    with pytest.raises(SystemExit) as end:
        main(argv)
    code = end.value.code
    captured = capsys.readouterr()
    return code if isinstance(code, int) else int(code is not None), captured.out, captured.err


def write(folder: Path, text: str) -> str:
    path = folder / "scenario.yaml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def test_the_unspoilt_scenario_is_good(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write(tmp_path, GOOD)
    code, out, err = run(capsys, "check", path, "--set", "launcher.cut_short=true")
    assert (code, err) == (0, "")
    assert "can fly" in out


@pytest.mark.parametrize("case", CASES.values(), ids=CASES.keys())
def test_bad_scenario(case: Bad, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert GOOD.count(case.old) >= 1
    text = GOOD.replace(case.old, case.new, 1)
    path = write(tmp_path, text)
    code, out, err = run(capsys, "check", path)
    assert (code, out) == (2, "")
    lines = [line for line in err.splitlines() if f": {case.key}: received " in line]
    assert lines, err
    assert all(line.startswith(f"error: {path}") for line in err.splitlines())
    line = lines[0]
    _, _, rest = line.partition(": received ")
    received, _, rest = rest.partition("; required ")
    requirement, _, remedy = rest.rpartition("; ")
    assert received
    assert case.required in requirement
    assert case.remedy in remedy


def test_every_problem_is_listed_at_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = GOOD.replace("horizon: 5", "horizon: 0").replace("duration: 4.0", "duration: 4")
    text = text.replace("time_step: 0.8", "time_step: 1.0").replace("launcher:", "lancher:")
    path = write(tmp_path, text)
    code, _, err = run(capsys, "check", path)
    assert code == 2
    assert [line.split(": ")[2] for line in err.splitlines()] == [
        "plant.duration", "nmpc_controller.time_step", "nmpc_controller.horizon", "lancher",
    ]  # fmt: skip
    assert err.splitlines()[0].startswith(f"error: {path}:5: ")


def test_problems_as_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write(tmp_path, GOOD.replace("horizon: 5", "horizon: 0"))
    code, out, err = run(capsys, "check", path, "--json")
    assert (code, err) == (2, "")
    result = json.loads(out)
    assert result["ok"] is False
    (problem,) = result["problems"]
    assert problem == {
        "file": path,
        "line": 10,
        "key": "nmpc_controller.horizon",
        "value": "0",
        "requirement": "an integer [steps], 1 to 10000",
        "remedy": "raise it (1 to 10000)",
    }


@pytest.mark.parametrize("name", FILES)
def test_unreadable_file(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data, received, remedy = FILES[name]
    path = tmp_path / "scenario.yaml"
    path.write_bytes(data)
    code, out, err = run(capsys, "check", str(path))
    assert (code, out) == (2, "")
    assert len(err.splitlines()) == 1
    assert err.startswith(f"error: {path}")
    assert received in err
    assert "required a readable ROS 2 parameter file" in err
    assert err.rstrip().endswith(remedy) or remedy in err.rpartition("; ")[2]


def test_line_of_broken_yaml(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write(tmp_path, "plant:\n  ros__parameters:\n    a: 1.0\n   b: 2.0\n")
    _, _, err = run(capsys, "check", path)
    assert err.startswith(f"error: {path}:4: ")


def test_missing_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "none.yaml"
    code, _, err = run(capsys, "check", str(path))
    assert code == 2
    assert err == (
        f"error: {path}: received no such file; required a readable ROS 2 parameter file; "
        "check the path\n"
    )


def test_directory(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, _, err = run(capsys, "check", str(tmp_path))
    assert code == 2
    assert "received a directory; " in err


@pytest.mark.parametrize("name", SETTINGS)
def test_bad_setting(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    setting, requirement, remedy = SETTINGS[name]
    code, out, err = run(capsys, "check", write(tmp_path, GOOD), "--set", setting)
    assert (code, out) == (2, "")
    assert len(err.splitlines()) == 1
    assert err.startswith("error: --set: ")
    assert requirement in err.partition("; required ")[2]
    assert remedy in err.rpartition("; ")[2]


@pytest.mark.parametrize("command", ["check", "simulate", "launch"])
def test_every_command_refuses_alike(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write(tmp_path, GOOD.replace("horizon: 5", "horizon: 0"))
    code, out, err = run(capsys, command, path)
    assert (code, out) == (2, "")
    assert err == (
        f"error: {path}:10: nmpc_controller.horizon: received 0; "
        "required an integer [steps], 1 to 10000; raise it (1 to 10000)\n"
    )


@pytest.mark.parametrize("command", ["check", "simulate", "launch"])
@pytest.mark.parametrize("name", CONTROLLER_CASES)
def test_no_command_flies_it(
    command: str, name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case = CONTROLLER_CASES[name]
    path = write(tmp_path, GOOD.replace(case.old, case.new, 1))
    code, out, err = run(capsys, command, path)
    assert (code, out) == (2, "")
    assert f": {case.key}: received " in err
    assert "Traceback" not in err
    assert [file.name for file in tmp_path.iterdir()] == ["scenario.yaml"]


def test_a_flight_may_be_cut_short(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write(tmp_path, GOOD)
    code, _, err = run(capsys, "check", path, "--set", "plant.duration=0.8")
    assert (code, err) == (0, "")


def test_a_pair_of_zones_is_told_at_the_line_of_the_second(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case = CONTROLLER_CASES["exclusion around exclusion"]
    path = write(tmp_path, GOOD.replace(case.old, case.new, 1))
    _, _, err = run(capsys, "check", path)
    assert err == (
        f"error: {path}:20: nmpc_controller.zones.star.half_angle_deg: received 5 deg, a cone "
        "wholly inside that of exclusion zone 'moon' (30 deg) for the same body axis; required a "
        "zone that forbids what 'moon' does not forbid already; remove 'star', or mend its axes\n"
    )


def test_good_is_valid_yaml_for_other_readers() -> None:
    assert set(yaml.safe_load(GOOD)) == {"plant", "nmpc_controller", "launcher"}
