"""Standard output that cannot be written, and texts that its encoding cannot hold."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SHORT_TURN = ROOT / "config" / "sun_moon_pd.yaml"
FULL = "error: standard output: received 'No space left on device' while writing; required "


def gnc(*argv: str, **options) -> subprocess.CompletedProcess[str]:
    """Run ``gnc`` as a process whose streams are those of the caller's choice."""
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    changes = options.pop("env", {})
    return subprocess.run(
        [sys.executable, "-m", "spacecraft_gnc", *map(str, argv)],
        **{**streams, **options},
        env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "", **changes},
        text=True,
        timeout=120,
        check=False,
    )


@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize(
    "argv",
    [("check", SHORT_TURN), ("simulate", SHORT_TURN, "--json"), ("--help",)],
    ids=lambda a: a[0],
)
def test_a_full_disk_is_one_line(argv: tuple[str, ...], unbuffered: str) -> None:
    with Path("/dev/full").open("w") as full:
        result = gnc(*argv, stdout=full, env={"PYTHONUNBUFFERED": unbuffered})
    assert result.returncode == 1
    assert result.stderr.startswith(FULL)
    assert result.stderr.count("\n") == 1


def test_a_refusal_is_told_though_the_disk_is_full() -> None:
    with Path("/dev/full").open("w") as full:
        result = gnc("check", "nowhere.yaml", stdout=full)
    assert result.returncode == 2
    assert result.stderr.startswith("error: nowhere.yaml: received no such file; ")


def test_an_error_that_cannot_be_told_keeps_its_exit_code() -> None:
    with Path("/dev/full").open("w") as full:
        result = gnc("check", "nowhere.yaml", stderr=full)
    assert (result.returncode, result.stdout) == (2, "")


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_reader_that_has_gone_ends_the_command_as_sigpipe_does(unbuffered: str) -> None:
    read, write = os.pipe()
    os.close(read)
    try:
        changes = {"PYTHONUNBUFFERED": unbuffered}
        result = gnc("check", SHORT_TURN, "--json", stdout=write, env=changes)
    finally:
        os.close(write)
    assert (result.returncode, result.stderr) == (141, "")


def test_a_closed_output_is_one_line() -> None:
    command = f"exec {sys.executable} -m spacecraft_gnc check {SHORT_TURN} >&-"
    result = subprocess.run(
        ["sh", "-c", command], cwd=ROOT, capture_output=True, text=True, timeout=60, check=False
    )
    assert result.returncode == 1
    assert result.stderr.startswith("error: standard output: received 'Bad file descriptor' while ")
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize(
    "locale",
    [
        {"PYTHONIOENCODING": "ascii"},
        {"LC_ALL": "C"},
        {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
    ],
    ids=["ascii", "C", "C without UTF-8"],
)
@pytest.mark.parametrize(
    "name", [b"gr\xc3\xb6\xc3\x9fe.yaml", b"caf\xe9.yaml"], ids=["utf-8", "latin"]
)
def test_a_path_beyond_the_encoding_is_printed(name: bytes, locale: dict, tmp_path: Path) -> None:
    path = os.fsdecode(os.fsencode(tmp_path) + b"/" + name)
    shutil.copy(SHORT_TURN, path)
    good = gnc("check", path, env=locale, errors="surrogateescape")
    assert (good.returncode, good.stderr) == (0, "")
    assert "yaml: can fly\n" in good.stdout
    Path(path).unlink()
    bad = gnc("check", path, env=locale, errors="surrogateescape")
    assert (bad.returncode, bad.stdout) == (2, "")
    assert "yaml: received no such file; required a readable" in bad.stderr
    assert bad.stderr.count("\n") == 1
