"""Resident memory of every node over a long flight in lockstep, recorded.

`.venv/bin/python benchmarks/memory.py [STEPS]` flies STEPS control steps of Case I (100,000 unless
given) and prints each node's memory at a tenth, half and the end of the flight.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from pathlib import Path

import psutil

from spacecraft_gnc.scenario.shipped import shipped

PERIOD = 0.4  # [s] simulated, control period of Case I
SAMPLE_EVERY = 1.0  # [s] wall


def main() -> int:
    """Fly, sample, print a table."""
    steps = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    scenario = shipped("gupta2015_case1")
    samples: dict[str, list[float]] = defaultdict(list)
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "spacecraft_gnc", "launch", str(scenario), "--quiet"]
        command += ["--out", str(Path(folder) / "run"), "--duration", str(steps * PERIOD)]
        begun = time.monotonic()
        with subprocess.Popen(command) as launcher:
            while launcher.poll() is None:
                time.sleep(SAMPLE_EVERY)
                for name, resident in sizes(launcher.pid).items():
                    samples[name].append(resident)
    print(f"{steps} steps in {time.monotonic() - begun:.0f} s, exit code {launcher.returncode}")
    print(f"{'node':<20} {'at 10 %':>9} {'at 50 %':>9} {'at 99 %':>9} {'largest':>9}   [MB]")
    for name, values in samples.items():
        picked = [values[int(share * (len(values) - 1))] for share in (0.1, 0.5, 0.99)]
        cells = "".join(f" {value:>9.1f}" for value in (*picked, max(values)))
        print(f"{name:<20}{cells}")
    return launcher.returncode


def sizes(pid: int) -> dict[str, float]:
    """Return the resident memory [MB] of each node below the launcher."""
    found = {}
    try:
        for child in psutil.Process(pid).children():
            words = child.cmdline()
            names = [word.rpartition(".")[2] for word in words if "spacecraft_gnc.nodes." in word]
            if names:
                found[names[0]] = child.memory_info().rss / 1e6
    except psutil.NoSuchProcess:  # it has just ended
        pass
    return found


if __name__ == "__main__":
    sys.exit(main())
