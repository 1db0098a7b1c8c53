"""The commands of docs/analysis.md run, in their order, and say what the page shows."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "analysis.md"
_BLOCK = re.compile(r"^```console\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_SCRIPT = re.compile(r"`(\w+\.py)`:\n\n^```python\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_EXIT_CODE = re.compile(r"# exit code (\d)$")
_NUMBER = re.compile(r"[-+]?\d+(?:[.,]\d+)*(?:e[-+]?\d+)?")


class Shown(NamedTuple):
    """A command of the page, and what the page shows of its output."""

    command: str
    exit_code: int
    output: list[str]


def shown() -> Iterator[Shown]:
    """Yield the commands of the page in their order."""
    for block in _BLOCK.findall(PAGE.read_text(encoding="utf-8")):
        for part in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
            command, *output = part.rstrip("\n").splitlines()
            code = _EXIT_CODE.search(command)
            yield Shown(command, int(code.group(1)) if code else 0, output)


@pytest.fixture(scope="module")
def shell(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, str]]:
    """Return a folder with the page's scripts, and an environment whose ``gnc`` is this one."""
    folder = tmp_path_factory.mktemp("page")
    (folder / "config").symlink_to(ROOT / "config")
    for name, text in _SCRIPT.findall(PAGE.read_text(encoding="utf-8")):
        (folder / name).write_text(text, encoding="utf-8")
    bin_folder = folder / "bin"
    bin_folder.mkdir()
    for name, arguments in {"gnc": "-m spacecraft_gnc", "python": ""}.items():
        script = bin_folder / name
        script.write_text(f'#!/bin/sh\nexec "{sys.executable}" {arguments} "$@"\n')
        script.chmod(0o755)
    path = os.pathsep.join([str(bin_folder), os.environ["PATH"]])
    return folder, {**os.environ, "PATH": path, "PYTHONPATH": str(ROOT), "COLUMNS": "200"}


def normal(line: str) -> str:
    """Return a line with single spaces and without its figures, which differ between runs."""
    return _NUMBER.sub("#", " ".join(line.split()))


def matches(expected: str, line: str) -> bool:
    """Tell whether a normal line is as expected; ``...`` stands for anything."""
    return bool(re.fullmatch(".*".join(map(re.escape, normal(expected).split("..."))), line))


@pytest.mark.graph
def test_the_commands_of_the_page(shell: tuple[Path, dict[str, str]]) -> None:
    folder, environment = shell
    commands = list(shown())
    assert len(commands) > 10
    for command, exit_code, output in commands:
        done = subprocess.run(
            ["bash", "-c", command],
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            timeout=240,
            check=False,
        )
        said = done.stdout + done.stderr
        assert done.returncode == exit_code, f"$ {command}\n{said}"
        lines = [normal(line) for line in said.splitlines()]
        for line in (text for text in output if text.strip() not in {"", "..."}):
            assert any(matches(line, other) for other in lines), (
                f"$ {command}\nthe page shows: {line}\nit said:\n{said}"
            )
