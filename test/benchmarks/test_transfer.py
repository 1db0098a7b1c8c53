"""A short form of the benchmark of transfers, which goes on where it was ended."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

pytest.importorskip("casadi")


def run(file: Path, count: int) -> str:
    done = subprocess.run(
        [sys.executable, str(ROOT / "benchmarks" / "transfer.py"), str(count), str(file)],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_same_costs_as_ipopt_and_what_was_solved_is_kept(tmp_path: Path) -> None:
    file = tmp_path / "kept" / "transfer.jsonl"
    printed = run(file, 2)
    assert "solved by both, the same cost: 2" in printed
    assert "N = 2000: " in printed
    kept = file.read_text(encoding="utf-8")
    rows = [json.loads(line) for line in kept.splitlines()]
    assert [row["index"] for row in rows] == [0, 1]
    assert all(abs(row["difference"]) < 1e-6 and row["ipopts"] > 0.0 for row in rows)
    assert "the same cost: 3" in run(file, 3)
    assert file.read_text(encoding="utf-8").startswith(kept)
