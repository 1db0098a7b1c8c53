"""A short form of the benchmark of neighboring extremals: no error exceeds its tolerance."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RUN = ROOT / "benchmarks" / "neighboring.py"


def test_no_step_exceeds_the_tolerance() -> None:
    done = subprocess.run(
        [sys.executable, str(RUN), "--flights", "1", "--steps", "80"],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    line = next(line for line in done.stdout.splitlines() if line.startswith("all  "))
    steps, _, _, over, worst, over_bound, ratio, *_ = line.split()[1:]
    assert int(steps) > 8000
    assert int(over) == int(over_bound) == 0
    assert 0.1 < float(worst) < 1.0  # the bound is not far from what it bounds
    assert float(ratio) < 1.0
