"""``gnc`` itself: help, unknown commands, what runs it, how errors leave it."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from spacecraft_gnc import SILENT_COMPILER, __version__
from spacecraft_gnc.cli import main as module
from spacecraft_gnc.cli.main import COMMANDS, main

ROOT = Path(__file__).resolve().parents[2]
INSPECT = ("nodes", "topics", "lifecycle", "watch", "echo", "hz", "delay", "params")


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
        assert f"\n  {name} " in out
        assert command.summary in " ".join(out.split())


WORDS = [
    *((name,) for name in COMMANDS),
    *(("inspect", name) for name in INSPECT),
    *(("campaign", name) for name in ("report", "rerun")),
    *(("inspect", "params", name) for name in ("list", "get", "set")),
]


@pytest.mark.parametrize("words", WORDS, ids=" ".join)
def test_every_command_explains_itself(words, capsys, monkeypatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    code, out, err = run(capsys, *words, "-h")
    assert (code, err) == (0, "")
    assert out.startswith(f"Usage: gnc {' '.join(words)} ")
    assert out == run(capsys, *words, "--help")[1]
    assert max(map(len, out.splitlines())) <= 80
    assert not re.search(r"<\w", out), "a type in place of a name"
    assert "{" not in out
    assert "...\n" not in out.partition("\n")[2], "a summary is cut"


def test_a_usage_line_shows_what_may_be_left_out(capsys) -> None:
    usages = {
        ("campaign",): "Usage: gnc campaign [OPTIONS] SCENARIO.yaml VARIATIONS.yaml",
        ("campaign", "report"): "Usage: gnc campaign report [OPTIONS] DIR",
        ("check",): "Usage: gnc check [OPTIONS] SCENARIO.yaml",
        ("plot",): "Usage: gnc plot [OPTIONS] RUN...",
        ("view",): "Usage: gnc view [OPTIONS] [BAG|FILE.npz]",
        ("warmup",): "Usage: gnc warmup [OPTIONS] [SCENARIO.yaml...]",
        ("inspect", "params", "set"): "Usage: gnc inspect params set [OPTIONS] NODE NAME VALUE",
    }
    for words, usage in usages.items():
        assert run(capsys, *words, "-h")[1].partition("\n")[0] == usage


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(capsys, "--version") == (0, f"spacecraft_gnc {__version__}\n", "")


def test_unknown_command(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "simulat")
    assert (code, out) == (2, "")
    assert err == "error: gnc: no such command 'simulat'; did you mean 'simulate'? See gnc --help\n"


def test_command_unlike_any(capsys: pytest.CaptureFixture[str]) -> None:
    code, _, err = run(capsys, "xyz")
    assert code == 2
    assert "use launch, simulate, check" in err


REFUSED = {
    ("check",): "gnc check: missing argument 'SCENARIO.yaml'; see gnc check --help",
    ("check", "a", "b"): "gnc check: got unexpected extra argument(s) (b); see gnc check --help",
    ("check", "a", "--nope"): "gnc check: no such option: --nope; see gnc check --help",
    ("view", "--port"): "gnc view: option '--port' requires an argument; see gnc view --help",
    ("view", "--port", "x"): "gnc view: '--port': received 'x'; required a valid integer; "
    "see gnc view --help",
    ("plot", "x", "-f", "gif"): "gnc plot: '--format' / '-f': received 'gif'; required one of "
    "'png', 'svg', 'pdf'; see gnc plot --help",
    ("campaign", "a.yaml"): "gnc campaign: missing argument 'VARIATIONS.yaml'; "
    "see gnc campaign --help",
    ("inspect", "nodez"): "gnc inspect: no such command 'nodez'. Did you mean 'nodes'? "
    "See gnc inspect --help",
}


@pytest.mark.parametrize("argv", REFUSED, ids=" ".join)
def test_wrong_usage_is_one_line(argv: tuple[str, ...], capsys) -> None:
    assert run(capsys, *argv) == (2, "", f"error: {REFUSED[argv]}\n")


@pytest.mark.parametrize("argv", [(), ("inspect",), ("inspect", "params")], ids=" ".join)
def test_a_group_without_a_command_shows_its_help(argv: tuple[str, ...], capsys) -> None:
    code, out, err = run(capsys, *argv)
    assert (code, out) == (2, "")
    assert err == run(capsys, *argv, "--help")[1]


def completed(words: str, monkeypatch, capsys) -> list[str]:
    """Return what bash is offered after some words."""
    monkeypatch.setenv("_GNC_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", words)
    monkeypatch.setenv("COMP_CWORD", str(words.count(" ")))
    code, out, err = run(capsys)
    assert (code, err) == (0, "")
    return out.split()


def test_commands_are_completed_without_importing_one(monkeypatch, capsys) -> None:
    def never(*_: object) -> None:
        raise AssertionError("a command was imported")

    monkeypatch.setattr(module, "_load", never)
    assert completed("gnc ", monkeypatch, capsys) == list(COMMANDS)
    assert completed("gnc rep", monkeypatch, capsys) == ["report", "replay", "reproduce"]
    assert "--show-completion" in completed("gnc --", monkeypatch, capsys)


def test_the_words_of_a_command_are_completed(monkeypatch, capsys) -> None:
    assert "--out" in completed("gnc simulate --", monkeypatch, capsys)
    assert completed("gnc export x -f p", monkeypatch, capsys) == ["parquet"]
    assert "--workers" in completed("gnc campaign --", monkeypatch, capsys)
    assert "--png" in completed("gnc campaign report --", monkeypatch, capsys)
    assert completed("gnc inspect w", monkeypatch, capsys) == ["watch"]
    assert "--domain-id" in completed("gnc inspect params get --", monkeypatch, capsys)


@pytest.mark.parametrize("option", ["--install-completion", "--show-completion"])
def test_completion_for_an_unknown_shell_is_refused(option: str, monkeypatch, capsys) -> None:
    monkeypatch.setattr("shellingham.detect_shell", lambda: ("dash", "/bin/dash"))
    code, out, err = run(capsys, option)
    assert (code, out) == (2, "")
    assert err.startswith(f"error: {option}: received a call from the shell dash; required bash, ")


def test_completion_is_installed_and_shown(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.setattr("shellingham.detect_shell", lambda: ("bash", "/bin/bash"))
    monkeypatch.setenv("HOME", str(tmp_path))
    code, shown, _ = run(capsys, "--show-completion")
    assert code == 0
    assert run(capsys, "--install-completion")[0] == 0
    (script,) = (tmp_path / ".bash_completions").iterdir()
    assert script.read_text().strip() == shown.strip()
    assert str(script) in (tmp_path / ".bashrc").read_text()


def test_completion_that_cannot_be_installed_is_one_line(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.setattr("shellingham.detect_shell", lambda: ("bash", "/bin/bash"))
    (tmp_path / ".bash_completions").write_text("a file in the way")
    monkeypatch.setenv("HOME", str(tmp_path))
    code, _, err = run(capsys, "--install-completion")
    assert code == 2
    assert err.startswith("error: --install-completion: received ")
    assert err.count("\n") == 1


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


@pytest.mark.parametrize("argv", [("warmup", "--nope"), ("check", "nowhere.yaml", "-q")])
def test_nothing_is_said_of_kernels_that_are_compiled_by_intention_or_in_quiet(
    argv: tuple[str, ...], monkeypatch, capsys
) -> None:
    monkeypatch.setenv(SILENT_COMPILER, "0")
    assert run(capsys, "check", "nowhere.yaml")[0] == 2
    assert os.environ[SILENT_COMPILER] == "0"
    assert run(capsys, *argv)[0] == 2
    assert os.environ[SILENT_COMPILER] == "1"
