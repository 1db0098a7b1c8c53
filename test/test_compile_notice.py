"""The line that says that kernels are being compiled: once, where it lasts, never when warm."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from spacecraft_gnc import SILENT_COMPILER, _kernels

ROOT = Path(__file__).resolve().parents[1]
NOTICE = (
    "spacecraft_gnc: compiling kernels for the first time (a minute or more); `gnc warmup` does it "
    "ahead\n"
)
# Two kernels, one of which calls the other; any compiling counts as long.
CODE = """
from spacecraft_gnc import _kernels
from spacecraft_gnc.lie import _mat3_kernels as kernels
_kernels._PATIENCE = -1.0
identity = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
print(kernels.mat_t_mat(identity, identity) == identity)
"""


def run(cache: Path, **changes: str) -> tuple[str, str]:
    """Call a kernel in a process whose compiled kernels lie in a folder of its own."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(cache)}
    done = subprocess.run(
        [sys.executable, "-c", CODE],
        env={**environment, SILENT_COMPILER: "", **changes},
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    return done.stdout, done.stderr


def test_a_cold_cache_is_told_once_and_a_warm_one_never(tmp_path: Path) -> None:
    assert run(tmp_path) == ("True\n", NOTICE)
    assert run(tmp_path) == ("True\n", "")


def test_nothing_is_said_where_it_is_not_wanted_or_nothing_is_compiled(tmp_path: Path) -> None:
    assert run(tmp_path, NUMBA_DISABLE_JIT="1") == ("True\n", "")
    assert run(tmp_path, **{SILENT_COMPILER: "1"}) == ("True\n", "")


def compiled(module: str) -> Any:
    """Return an event of Numba's about a kernel of a module."""
    function = SimpleNamespace(__module__=module)
    return SimpleNamespace(data={"dispatcher": SimpleNamespace(py_func=function)})


OURS, FOREIGN = compiled("spacecraft_gnc.ocp._solve_kernels"), compiled("somebody.else")


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    now = [100.0]
    monkeypatch.setattr(_kernels.time, "monotonic", lambda: now[0])
    monkeypatch.delenv(SILENT_COMPILER, raising=False)
    return now


def test_kernels_that_are_quick_are_not_worth_a_line(clock: list[float], capsys) -> None:
    notice = _kernels._Notice()
    for _ in range(50):
        notice.on_start(OURS)
        notice.on_start(OURS)
        clock[0] += 0.9
        notice.on_end(OURS)
        notice.on_end(OURS)
    assert capsys.readouterr() == ("", "")


def test_a_long_chain_of_kernels_is_told_while_it_lasts(clock: list[float], capsys) -> None:
    notice = _kernels._Notice()
    for _ in range(4):
        notice.on_start(OURS)
        clock[0] += 0.4
    assert capsys.readouterr() == ("", NOTICE)
    notice.on_start(OURS)
    assert capsys.readouterr() == ("", "")


def test_kernels_of_others_are_their_own_business(clock: list[float], capsys) -> None:
    notice = _kernels._Notice()
    for _ in range(9):
        notice.on_start(FOREIGN)
        clock[0] += 1.0
    assert capsys.readouterr() == ("", "")
