"""A shortened form of ``benchmarks/hostile.py``: nothing on the wire ends a flight or steers it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.graph

RUN = Path(__file__).resolve().parents[2] / "benchmarks" / "hostile.py"


@pytest.mark.parametrize(
    "name", ["messages", "steering", pytest.param("kills", marks=pytest.mark.long)]
)
def test_an_attacked_flight(name: str) -> None:
    done = subprocess.run(
        [sys.executable, str(RUN), "--short", "--only", name],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "passed" in done.stdout
    assert "FAILED" not in done.stdout
