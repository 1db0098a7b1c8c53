"""``gnc`` itself: help, unknown commands, what runs it, how errors leave it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from spacecraft_gnc import __version__
from spacecraft_gnc.cli import main as module
from spacecraft_gnc.cli.main import COMMANDS, main

ROOT = Path(__file__).resolve().parents[2]


def run(capsys: pytest.CaptureFixture[str], *argv: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as end:
        main(argv)
    captured = capsys.readouterr()
    return int(end.value.code or 0), captured.out, captured.err


def gnc(*argv: str) -> subprocess.CompletedProcess[str]:
    """Run ``python -m spacecraft_gnc`` as a user does."""
    return subprocess.run(
        [sys.executable, "-m", "spacecraft_gnc", *argv],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def test_help_lists_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "--help")
    assert (code, err) == (0, "")
    for name, command in COMMANDS.items():
        assert (f"\n  {name} " in out) is not command.hidden


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_explains_itself(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, name, "--help")
    assert (code, err) == (0, "")
    assert out.startswith(f"Usage: gnc {name} ")


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(capsys, "--version") == (0, f"spacecraft_gnc {__version__}\n", "")


def test_unknown_command(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "simulat")
    assert (code, out) == (2, "")
    assert "No such command 'simulat'; did you mean 'simulate'?" in err


def test_command_unlike_any(capsys: pytest.CaptureFixture[str]) -> None:
    code, _, err = run(capsys, "xyz")
    assert code == 2
    assert "use launch, simulate, check" in err
    assert "warmup" not in err


@pytest.mark.parametrize("argv", [("check",), ("check", "a", "b"), ("check", "a", "--nope")])
def test_wrong_usage(argv: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, *argv)
    assert (code, out) == (2, "")
    assert err.startswith("Usage: gnc check ")


def test_a_defect_of_ours_keeps_its_traceback(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(**_: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(module, "app", fail)
    with pytest.raises(ZeroDivisionError):
        main([])


def test_a_refusal_in_a_process_of_its_own() -> None:
    result = gnc("check", "no_such_file.yaml")
    assert (result.returncode, result.stdout) == (2, "")
    assert result.stderr == (
        "error: no_such_file.yaml: received no such file; "
        "required a readable ROS 2 parameter file; check the path\n"
    )


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys\nfrom spacecraft_gnc.cli.main import main\n"
        "try: main(['--help'])\n"
        "finally: print(sorted({'numpy', 'numba', 'rclpy', 'matplotlib', 'rich', 'mcap'}"
        " & set(sys.modules)), file=sys.stderr)\n"
    )
    result = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=60,
        check=False,
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    assert result.stderr == "[]\n"
