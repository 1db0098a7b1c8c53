"""What a worker does for a campaign: it flies blocks of runs, one flight at a time."""

from __future__ import annotations

import tempfile
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

from spacecraft_gnc.campaign.flyer import WALL_TIME, Flyer
from spacecraft_gnc.campaign.spec import Spec, require_installed
from spacecraft_gnc.campaign.tables import table_of
from spacecraft_gnc.loop.flight import save_flights

_LOCK = threading.Lock()  # the flights of a process share its compiled code and its GIL


class Rows(NamedTuple):
    """The rows of a block."""

    table: Any
    """`pyarrow.Table`"""
    seconds: float
    """Median wall time of its runs [s]."""


class Kept(NamedTuple):
    """A flight to keep."""

    row: dict[str, Any]
    file: bytes
    """`loop.flight.save_flights`; empty where there is no flight."""


def fly_rows(spec: Spec, first: int, count: int) -> Rows:
    """Fly runs and return their rows; each flight is dropped at once.

    Raises
    ------
    ParameterError
        If this worker would fly with other versions.
    """
    with _one_at_a_time():
        flyer = _flyer(spec)
        points = flyer.spec.design.points(first, count)
        rows = [flyer.fly(first + i, point).row for i, point in enumerate(points)]
    return Rows(table_of(rows), median(row[WALL_TIME] for row in rows))


def fly_kept(spec: Spec, first: int, count: int) -> list[Kept]:
    """Fly runs once more and return them whole.

    Raises
    ------
    ParameterError
        If this worker would fly with other versions.
    """
    with _one_at_a_time():
        return [_kept(_flyer(spec), run) for run in range(first, first + count)]


def _kept(flyer: Flyer, run: int) -> Kept:
    row, flight, scenario = flyer.fly(run)
    if flight is None or scenario is None:
        return Kept(row, b"")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "flight.npz")
        save_flights(path, {"": flight}, scenario.to_yaml(), scenario.stated_defaults())
        return Kept(row, path.read_bytes())


@contextmanager
def _one_at_a_time() -> Iterator[None]:
    """Have the threads of a worker take turns, and keep NumPy's warnings off its terminal."""
    with _LOCK, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


@lru_cache(maxsize=1)
def _flyer(spec: Spec) -> Flyer:
    require_installed(spec, "worker")
    flyer = Flyer(spec)
    flyer.warm_up()
    return flyer
