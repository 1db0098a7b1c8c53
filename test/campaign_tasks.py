"""Tasks that workers of the tests import."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

from spacecraft_gnc.campaign.spec import Spec
from spacecraft_gnc.campaign.tasks import Rows, fly_rows
from spacecraft_gnc.errors import ParameterError


def runs_and_process(_: Spec, first: int, count: int) -> tuple[list[int], int]:
    return list(range(first, first + count)), os.getpid()


def deadly_for_run_5(_: Spec, first: int, count: int) -> list[int]:
    if 5 in range(first, first + count):
        os.kill(os.getpid(), signal.SIGKILL)
    return list(range(first, first + count))


def refused(_spec: Spec, _first: int, _count: int) -> None:
    raise ParameterError("worker: received another version; required this one; install it")


def defective(_spec: Spec, _first: int, _count: int) -> None:
    raise ZeroDivisionError("ours")


def rows_of_a_worker_that_is_killed_once(spec: Spec, first: int, count: int) -> Rows:
    """Fly; the first worker that is half-way is killed, and its rows are lost with it."""
    mark = Path(spec.variations_path).with_name("killed")
    rows = fly_rows(spec, first, count)
    if first > spec.runs // 2 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(60.0)  # until it is carried out
    return rows


def periodic_callbacks(dask_worker) -> list[str]:
    """Return what a worker does every now and then beside its tasks."""
    return list(dask_worker.periodic_callbacks)
