"""``gnc warmup`` while it compiles: in two processes, which end with it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from spacecraft_gnc.cli.warmup import _tasks


def test_what_takes_longest_stands_at_an_end_and_every_vehicle_is_there() -> None:
    tasks = _tasks()
    assert tasks[0] == ("rigid_body", 0)
    assert {name for name, _ in tasks} == {"rigid_body", "docking", "formation", "two_wheel"}
    assert len(set(tasks)) == len(tasks)


def test_an_interrupt_ends_it_and_what_compiles_for_it(tmp_path: Path) -> None:
    with subprocess.Popen(
        [sys.executable, "-m", "spacecraft_gnc", "warmup"],
        env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        while not any(tmp_path.rglob("*.nbi")):  # the first kernel
            assert process.poll() is None
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)  # to it alone
        out, err = process.communicate(timeout=60.0)  # once all of them have closed their end
    assert (process.returncode, out) == (130, "")
    assert "Traceback" not in err
