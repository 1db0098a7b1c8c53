"""Writer of the rows of a campaign: whole parts of consecutive runs, in one form at the end."""

from __future__ import annotations

import fcntl
import os
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, Final

from spacecraft_gnc.campaign.results import Campaign, Part
from spacecraft_gnc.campaign.tables import conformed, joined, without_null_types, write_table
from spacecraft_gnc.errors import RecordingError

_ROWS: Final = 50_000
"""Rows of a part at the end; none goes beyond a multiple of it."""
_HELD: Final = 10_000  # rows
_PERIOD: Final = 10.0  # wall time between two parts [s]


@contextmanager
def exclusive(campaign: Campaign) -> Iterator[None]:
    """Have a campaign to oneself while its folder is written.

    Raises
    ------
    RecordingError
        If another process has it.
    """
    folder = os.open(campaign.folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise RecordingError(
                f"--out: received {str(campaign.folder)!r}, which another process is writing; "
                "required a campaign that nobody is flying; wait for it, or choose another folder"
            ) from error
        yield
    finally:
        os.close(folder)


class Writer:
    """Writes the rows of a campaign; one process at a time does.

    Parameters
    ----------
    campaign
        Whose rows. Parts that a crash left torn, or beside the longer ones that were made of them,
        are removed: their runs are flown again.
    """

    def __init__(self, campaign: Campaign) -> None:
        self._campaign = campaign
        self._held: dict[int, Any] = {}
        self._rows = 0
        self._due = time.monotonic() + _PERIOD
        _remove_torn(campaign)

    def add(self, runs: range, table: Any) -> None:
        """Take the rows of consecutive runs; they are written soon."""
        self._held[runs.start] = table
        self._rows += len(runs)
        if self._rows >= _HELD or time.monotonic() >= self._due:
            self.flush()

    def flush(self) -> None:
        """Write what has been taken."""
        for runs, tables in _runs_of(sorted(self._held.items())):
            write_table(joined(tables), Part.of(self._campaign.results, runs).path)
        self._held.clear()
        self._rows = 0
        self._due = time.monotonic() + _PERIOD

    def finish(self) -> None:
        """Write what is left and bring the parts of a complete campaign to one form.

        They then hold the same rows in the same files, however the campaign came there.
        """
        self.flush()
        schema = without_null_types(self._campaign.schema)
        for first in range(0, self._campaign.spec.runs, _ROWS):
            runs = range(first, min(first + _ROWS, self._campaign.spec.runs))
            self._bring_to_one_form(runs, schema)

    def _bring_to_one_form(self, runs: range, schema: Any) -> None:
        import pyarrow.parquet as pq

        found = [part for part in self._campaign.parts if part.runs.start in runs]
        target = Part.of(self._campaign.results, runs)
        if found != [target] or not pq.read_schema(target.path).equals(schema):
            tables = [conformed(pq.read_table(part.path), schema) for part in found]
            write_table(joined(tables), target.path)
            for part in found:
                if part != target:
                    part.path.unlink()


def _runs_of(blocks: Iterable[tuple[int, Any]]) -> Iterator[tuple[range, list[Any]]]:
    """Yield the tables of consecutive runs together, cut where parts end."""
    runs, tables = range(0), list[Any]()
    for first, table in _cut(blocks):
        if tables and (first != runs.stop or first % _ROWS == 0):
            yield runs, tables
            tables = []
        runs = range(runs.start if tables else first, first + table.num_rows)
        tables.append(table)
    if tables:
        yield runs, tables


def _cut(blocks: Iterable[tuple[int, Any]]) -> Iterator[tuple[int, Any]]:
    for first, table in blocks:
        begin = 0
        while begin < table.num_rows:
            count = min(table.num_rows - begin, _ROWS - (first + begin) % _ROWS)
            yield first + begin, table.slice(begin, count)
            begin += count


def _remove_torn(campaign: Campaign) -> None:
    for torn in [part for part in campaign.all_parts() if not _is_whole(part)]:
        torn.path.unlink()
    kept = set(campaign.parts)
    for double in [part for part in campaign.all_parts() if part not in kept]:
        double.path.unlink()
    for left in campaign.results.glob(".*.part"):
        left.unlink()


def _is_whole(part: Part) -> bool:
    import pyarrow as pa
    import pyarrow.parquet as pq

    with suppress(OSError, pa.ArrowInvalid):
        return bool(pq.read_metadata(part.path).num_rows == len(part.runs))
    return False
