"""The comparison with other solvers: what can be run without installing any of them."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
RUN = ROOT / "benchmarks" / "peers" / "run.py"
WITHIN_REFERENCE = 1e-10  # [N m]: two independent solvers agree on the reference to 8e-13


def compare(path: Path, *names: str) -> tuple[dict[str, Any], str]:
    command = [sys.executable, str(RUN), "--no-sweep", "--seconds", "0", "--json", str(path)]
    done = subprocess.run(
        [*command, "--only", *names],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=240,
        check=True,
    )
    return json.loads(path.read_text(encoding="utf-8"))["case1"], done.stdout


@pytest.mark.parametrize("name", ["ours", "ours in C++ (floor)", "scipy fsolve"])
def test_solvers_of_the_conditions_reach_the_reference(tmp_path: Path, name: str) -> None:
    if name != "ours" and shutil.which("g++") is None:
        pytest.skip("g++ is absent")
    figures, _ = compare(tmp_path / "figures.json", name)
    row = figures[name]
    assert row["solved"] == row["states"] == 375
    assert row["error"] < WITHIN_REFERENCE
    assert 0.0 < row["median"] <= row["p99"] <= row["max"]


def test_an_absent_solver_is_skipped_with_one_line(tmp_path: Path) -> None:
    if (ROOT / ".venv-peers").exists():
        pytest.skip("the other solvers are installed")
    figures, said = compare(tmp_path / "figures.json", "IPOPT")
    assert figures == {}
    assert "CasADi + IPOPT: skipped, .venv-peers is absent (make bench installs it)" in said
