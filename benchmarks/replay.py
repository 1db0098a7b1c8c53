"""How exactly `gnc replay --publish` keeps its rate, and how fast it goes without one.

`.venv/bin/python benchmarks/replay.py` flies Case I (150 s, 3,010 messages), replays its bag at
several rates, rate 1 last, and prints how far each wall time is off. Nobody listens.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path

from spacecraft_gnc.scenario.shipped import shipped

RATES = ("max", "100", "10", "1")
GNC = [sys.executable, "-m", "spacecraft_gnc"]


def main() -> int:
    """Fly, replay, print a table."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run"
        scenario = str(shipped("gupta2015_case1"))
        subprocess.run([*GNC, "launch", scenario, "--out", str(out), "--quiet"], check=True)
        print(f"{'rate':>6} {'wall time [s]':>14} {'off the rate':>13} {'messages/s':>11}")
        for rate in RATES:
            print(row(out / "bag", rate), flush=True)
    return 0


def row(bag: Path, rate: str) -> str:
    """Return a line of the table."""
    command = [*GNC, "replay", str(bag), "--publish", "--rate", rate, "--json", "--patience", "0"]
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    played = json.loads(done.stdout)
    wall = played["wall_time"]
    due = None if rate == "max" else played["duration"] / float(rate)
    off = "-" if due is None else f"{100.0 * (wall / due - 1.0):+.4f} %"
    return f"{rate:>6} {wall:>14.4f} {off:>13} {sum(played['messages'].values()) / wall:>11.0f}"


if __name__ == "__main__":
    raise SystemExit(main())
