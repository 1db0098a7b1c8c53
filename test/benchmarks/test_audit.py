"""The benchmark of the audit still writes a bag that the audit reads."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
RUN = ROOT / "benchmarks" / "audit.py"


def test_a_short_flight_is_measured(tmp_path: Path) -> None:
    pytest.importorskip("spacecraft_gnc_msgs", reason="the messages are not built")
    done = subprocess.run(
        [sys.executable, str(RUN), "--steps", "5", "--runs", "1", "--folder", str(tmp_path)],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("      5 steps, ")
