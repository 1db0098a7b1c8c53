"""``gnc simulate``, ``gnc check`` and ``gnc warmup`` on good input."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path

import numpy as np
import pytest

from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.analysis.reader import load_run
from spacecraft_gnc.cli import simulate as module
from spacecraft_gnc.cli._common import json_able
from spacecraft_gnc.cli.main import main
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.loop import ClosedLoop
from spacecraft_gnc.scenario import load
from spacecraft_gnc.scenario.fingerprint import fingerprint
from spacecraft_gnc.vehicles.rigid_body.flight import RigidBodyFlight

CONFIG = Path(__file__).resolve().parents[2] / "config"
CASE_1 = str(CONFIG / "gupta2015_case1.yaml")
GOVERNED = str(CONFIG / "kalabic2014_governor.yaml")
SHORT = ("--set", "plant.duration=4")


def run(capsys: pytest.CaptureFixture[str], *argv: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as end:
        main(argv)
    captured = capsys.readouterr()
    return int(end.value.code or 0), captured.out, captured.err


def test_check_says_what_would_fly(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "check", CASE_1)
    assert code == 0
    (warning,) = err.splitlines()  # the paper's flight ends at 0.21 deg
    assert "plant.duration: received 150 s; required at least 170 s, after which" in warning
    assert "below 0.1 deg for good from 170 s, predicted" in out
    assert "375 control steps of 0.4 s" in out
    assert "42.97 deg from the target" in out
    assert "horizon 5 steps" in out
    assert "0.01 N m" in out


def test_check_names_what_a_method_has_and_what_a_governor_keeps(
    capsys: pytest.CaptureFixture[str],
) -> None:
    code, out, err = run(capsys, "check", GOVERNED)
    assert (code, err) == (0, "")
    rows = {line[2:16].strip(): line[16:] for line in out.splitlines()[1:]}
    assert rows["controller"] == "feedback"
    assert rows["governor"] == "attitude, torque limit 0.02 N m"


IN_A_ZONE = ("gupta2015_case2", "--set", "plant.initial_rotation_vector=[0.0, 0.0, 0.4]")


@pytest.mark.parametrize("command", ["check", "simulate"])
def test_a_start_inside_a_soft_zone_is_told(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    code, _, err = run(capsys, command, *IN_A_ZONE, *SHORT)
    assert code == 0
    (line,) = err.splitlines()
    assert line.startswith("warning: --set: plant.initial_rotation_vector: [0.0, 0.0, 0.4], the st")
    _, out, err = run(capsys, command, *IN_A_ZONE, *SHORT, "--json")
    assert json.loads(out)["warnings"] == [line.removeprefix("warning: ")]
    assert err == ""


def test_check_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "check", CASE_1, "--json", *SHORT)
    result = json.loads(out)
    assert (code, err, result["ok"], result["problems"]) == (0, "", True, [])
    assert (result["steps"], result["horizon"], result["max_torque"]) == (10, 5, 0.01)
    assert result["initial_error_deg"] == pytest.approx(math.degrees(0.75), rel=1e-12)


def test_check_quietly(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(capsys, "check", CASE_1, "--quiet") == (0, "", "")


def test_case_1_has_the_figures_of_the_paper_notes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out_file = tmp_path / "case1.npz"
    code, out, err = run(capsys, "simulate", CASE_1, "--json", "--out", str(out_file))
    assert (code, err) == (0, "")
    result = json.loads(out)
    assert result["final_error_deg"] == pytest.approx(0.21364, abs=1e-4)
    assert result["max_torque"] == pytest.approx(0.01, abs=1e-8)
    assert result["settle_time_5deg"] == pytest.approx(55.2, abs=0.2)
    assert result["settle_time_1deg"] == pytest.approx(105.2, abs=0.2)
    assert result["settle_time_0.1deg"] is None
    assert result["cost"] == pytest.approx(0.0550925764, abs=1e-9)
    assert (result["saturated_steps"], result["iterations_max"]) == (32, 3)
    trajectory = RigidBodyFlight.load(out_file)
    again = load(CASE_1).build().run()
    np.testing.assert_array_equal(trajectory.torque, again.torque)
    assert [path.name for path in tmp_path.iterdir()] == ["case1.npz"]


def test_the_file_holds_the_arrays_that_the_design_names(tmp_path: Path) -> None:
    out_file = tmp_path / "a.npz"
    with pytest.raises(SystemExit, match="0"):
        main(["simulate", CASE_1, *SHORT, "--quiet", "--out", str(out_file)])
    with np.load(out_file) as arrays:
        shapes = {name: arrays[name].shape for name in arrays.files}
    assert shapes["time"] == shapes["iterations"] == shapes["status"] == (10,)
    assert shapes["source"] == shapes["residual"] == shapes["solve_time"] == (10,)
    assert shapes["attitude"] == shapes["reference"] == (10, 3, 3)
    assert shapes["momentum"] == shapes["torque"] == (10, 3)
    assert shapes["scenario"] == ()


def test_the_file_tells_what_flew(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With the overrides, so that a report knows the limit that was kept."""
    file = tmp_path / "a.npz"
    limit = ("--set", "nmpc_controller.max_torque=0.005")
    assert run(capsys, "simulate", CASE_1, *SHORT, *limit, "--quiet", "--out", str(file))[0] == 0
    info = load_run(file).info
    assert info.scenario is not None
    assert info.warnings() == []
    assert info.scenario.controller.max_torque == 0.005
    assert info.scenario.values == load(CASE_1, [*SHORT[1::2], limit[1]]).values
    page = str(tmp_path / "a.html")
    code, out, _ = run(capsys, "report", str(file), "--json", "--out", page)
    (told,) = json.loads(out)["runs"]
    assert (code, told["metrics"]["torque_limit"], told["warnings"]) == (0, 0.005, [])
    assert run(capsys, "replay", str(file), "--quiet") == (0, "", "")


def test_summary_for_people(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "simulate", CASE_1, *SHORT)
    assert (code, err) == (0, "")
    assert "10 of 0.4 s" in out
    assert "limit 0.01 N m" in out
    assert "zone margin" not in out  # no zone, no row
    assert "\x1b" not in out


def test_the_summary_tells_of_a_standstill() -> None:
    metrics = summarize(load(CASE_1, ["plant.duration=4"]).build().run())
    labels = {"steps at a standstill", "standstill escapes"}
    assert not labels & dict(module.summary_rows(metrics)).keys()
    rows = dict(module.summary_rows({**metrics, "stalled_steps": 3, "escaping_steps": 2}))
    assert rows["steps at a standstill"].startswith("3,")
    assert rows["standstill escapes"].startswith("2, by a small torque")


def test_the_summary_tells_where_a_governor_stopped_and_what_it_could_not_keep() -> None:
    changes = {"reference_governor.max_torque": 0.003, "plant.duration": 2.0}
    metrics = summarize(load(GOVERNED, changes).build().run(), load(GOVERNED, changes))
    rows = module.summary_rows({**metrics, "inadmissible_steps": 3})
    assert dict(rows)["target admitted"].startswith("never, reference 5")
    assert ("warning", "no reference was admissible at 3 of 20 steps") in rows
    assert "warning" not in dict(module.summary_rows(metrics))


SOFT = ("--set", "nmpc_controller.torque_penalty=1.0")  # next to nothing for the excess


def test_a_limit_that_is_exceeded_is_told_and_fails_if_asked(
    capsys: pytest.CaptureFixture[str],
) -> None:
    code, out, err = run(capsys, "simulate", CASE_1, *SHORT, *SOFT)
    assert (code, err) == (0, "")
    (warning,) = [line for line in out.splitlines() if line.startswith("  warning ")]
    assert "limits exceeded: torque " in warning
    code, out, err = run(capsys, "simulate", CASE_1, *SHORT, *SOFT, "--json", "--strict")
    (exceeded,) = json.loads(out)["limits_exceeded"]
    assert (code, exceeded["limit"]) == (1, "torque")
    assert exceeded["factor"] == pytest.approx(json.loads(out)["max_torque"] / 0.01)
    told = f"limits exceeded: {exceeded['text']}; --strict requires every limit kept"
    assert err == f"error: {CASE_1}: {told}\n"
    code, out, err = run(capsys, "simulate", CASE_1, *SHORT, *SOFT, "--quiet", "--strict")
    assert (code, out, len(err.splitlines())) == (1, "", 1)
    assert run(capsys, "simulate", CASE_1, *SHORT, "--quiet", "--strict") == (0, "", "")


def test_the_scenario_is_named_by_its_hash(capsys: pytest.CaptureFixture[str]) -> None:
    expected = fingerprint(load(CASE_1, SHORT[1:]))
    _, out, _ = run(capsys, "simulate", CASE_1, *SHORT)
    assert out.splitlines()[-1].split() == ["scenario", "sha256", expected]
    _, out, _ = run(capsys, "simulate", CASE_1, *SHORT, "--json")
    assert json.loads(out)["scenario_hash"] == expected


def test_quietly(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(capsys, "simulate", CASE_1, *SHORT, "-q") == (0, "", "")


def refused(capsys: pytest.CaptureFixture[str], out: Path) -> str:
    code, stdout, err = run(capsys, "simulate", CASE_1, *SHORT, "--out", str(out))
    assert (code, stdout) == (2, "")
    assert len(err.splitlines()) == 1
    assert err.startswith(f"error: --out: received {str(out)!r}, ")
    assert "; required a .npz file in a writable folder; " in err
    return err


def test_output_in_a_folder_that_is_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    err = refused(capsys, tmp_path / "none" / "a.npz")
    assert err.endswith(f"create it: mkdir -p {tmp_path / 'none'}\n")


def test_output_that_is_a_directory(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.npz").mkdir()
    assert "name a file in it" in refused(capsys, tmp_path / "a.npz")


def test_output_of_another_kind(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "name it a.npz" in refused(capsys, tmp_path / "a.csv")


def test_output_in_a_read_only_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    may_write = os.access  # root may write anywhere
    monkeypatch.setattr(os, "access", lambda path, mode: mode == os.R_OK and may_write(path, mode))
    assert "choose another folder" in refused(capsys, tmp_path / "a.npz")


def test_a_full_disk_leaves_nothing_behind(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_args: object, **_kwargs: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez", fail)
    monkeypatch.setattr(np, "savez_compressed", fail)
    code, out, err = run(
        capsys, "simulate", CASE_1, *SHORT, "--json", "--out", str(tmp_path / "a.npz")
    )
    assert (code, out) == (2, "")
    assert "No space left on device" in err
    assert list(tmp_path.iterdir()) == []


def test_a_flight_that_fills_the_memory_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "simulate", CASE_1, "--set", "plant.duration=3.9e8")
    assert (code, out) == (2, "")
    assert err.startswith("error: plant.duration: received 975000000 control steps; required at")
    assert err.endswith("shorten it\n")


def test_a_flight_that_fails_ends_with_1(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_self: ClosedLoop, _progress: object) -> None:
        raise ParameterError("momentum: received 9; required less; slow down")

    monkeypatch.setattr(ClosedLoop, "run", fail)
    code, out, err = run(capsys, "simulate", CASE_1, *SHORT)
    assert (code, out) == (1, "")
    assert err == "error: momentum: received 9; required less; slow down\n"


def test_warmup(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "warmup", CASE_1)
    assert (code, err) == (0, "")
    assert out.startswith("kernels ready after ")


def test_json_has_neither_nan_nor_numpy() -> None:
    values = {"a": np.float64(math.nan), "b": np.arange(2), "c": (math.inf, Path("x")), "d": True}
    assert json_able(values) == {"a": None, "b": [0, 1], "c": [None, "x"], "d": True}
