"""Folder of a campaign: its specification, its rows, its kept flights and its summary."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from spacecraft_gnc import __version__
from spacecraft_gnc.campaign.spec import Spec
from spacecraft_gnc.campaign.tables import common_schema, conformed
from spacecraft_gnc.drawing.whole_file import whole_file
from spacecraft_gnc.errors import RecordingError

_SPEC: Final = "campaign.json"
_SUMMARY: Final = "summary.json"
_RESULTS: Final = "results"
_FLIGHTS: Final = "flights"
_PART: Final = re.compile(r"part-(\d+)-(\d+)\.parquet")


@dataclass(frozen=True)
class Part:
    """A file with the rows of consecutive runs."""

    path: Path
    runs: range

    @classmethod
    def of(cls, folder: Path, runs: range) -> Part:
        """Return the part of a folder that holds the rows of ``runs``."""
        return cls(folder / f"part-{runs.start}-{len(runs)}.parquet", runs)


class Campaign:
    """The folder of a campaign; `open` it to read.

    Attributes
    ----------
    folder : Path
        The folder.
    spec : Spec
        What was flown.
    """

    def __init__(self, folder: Path, spec: Spec) -> None:
        self.folder = folder
        self.spec = spec

    def __repr__(self) -> str:
        """Return where it is, and how far it has come."""
        done = sum(map(len, self.done))
        return f"Campaign({str(self.folder)!r}: {done} of {self.spec.runs} runs)"

    @classmethod
    def open(cls, folder: str | Path) -> Campaign:
        """Return the campaign of a folder.

        Raises
        ------
        RecordingError
            If it is not the folder of a campaign.
        """
        folder = Path(folder)
        try:
            values = json.loads((folder / _SPEC).read_text(encoding="utf-8"))
            return cls(folder, Spec.from_dict(values))
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise RecordingError(
                f"{folder}: cannot be read as a campaign ({error}); required a folder that "
                "`gnc campaign` wrote; check the path"
            ) from error

    @staticmethod
    def exists(folder: Path) -> bool:
        """Tell whether a folder is that of a campaign."""
        return (folder / _SPEC).is_file()

    @classmethod
    def create(cls, folder: Path, spec: Spec) -> Campaign:
        """Return the campaign of a folder, begun before or begun now.

        Raises
        ------
        RecordingError
            If the folder holds another campaign or something else, or cannot be written.
        """
        if cls.exists(folder):
            found = cls.open(folder)
            found.require(spec)
            return found
        if folder.is_dir() and any(folder.iterdir()):
            raise RecordingError(
                f"--out: received {str(folder)!r}, which holds other files; required a new folder, "
                "or that of this campaign; choose another one"
            )
        made = cls(folder, spec)
        for each in (made.results, made.flights):
            _make_folder(each)
        about = {"pass": spec.variations.criterion.text, "worst": spec.variations.worst}
        made.write_json(
            _SPEC, {"written_by": f"spacecraft_gnc {__version__}", **spec.to_dict(), **about}
        )
        return made

    def discard(self) -> None:
        """Remove the folder of a campaign that did not come to fly: nothing else is in it."""
        (self.folder / _SPEC).unlink()
        for each in (self.results, self.flights, self.folder):
            with suppress(OSError):  # somebody else's, or not empty
                each.rmdir()

    def require(self, spec: Spec) -> None:
        """Refuse a folder that holds another campaign.

        Raises
        ------
        RecordingError
            With what differs.
        """
        if self.spec.identity != spec.identity:
            found = ", ".join(spec.differences(self.spec))
            raise RecordingError(
                f"--out: received {str(self.folder)!r}, the folder of another campaign ({found}); "
                "required a new folder, or that of this campaign; choose another one"
            )

    @property
    def results(self) -> Path:
        """The folder of the rows."""
        return self.folder / _RESULTS

    @property
    def flights(self) -> Path:
        """The folder of the kept flights."""
        return self.folder / _FLIGHTS

    def flight_of(self, run: int) -> Path:
        """Return the file in which the flight of a run is kept, if it is."""
        return self.flights / f"run-{run}.npz"

    @property
    def parts(self) -> tuple[Part, ...]:
        """The parts of the results in the order of their runs.

        A part that begins inside another one was left by a driver that was ended while it joined
        parts; it is passed over.
        """
        return tuple(_disjoint(sorted(self.all_parts(), key=_first_and_longest)))

    def all_parts(self) -> Iterator[Part]:
        """Yield every part that there is as a file."""
        for path in self.results.glob("*.parquet"):
            match = _PART.fullmatch(path.name)
            if match:
                first, count = map(int, match.groups())
                yield Part(path, range(first, first + count))

    @property
    def done(self) -> tuple[range, ...]:
        """Runs whose rows are there, ascending."""
        return tuple(part.runs for part in self.parts)

    @property
    def missing(self) -> tuple[range, ...]:
        """Runs whose rows are not there, ascending."""
        ends = [0, *(runs.stop for runs in self.done)]
        starts = [*(runs.start for runs in self.done), self.spec.runs]
        return tuple(range(a, b) for a, b in zip(ends, starts, strict=True) if a < b)

    @property
    def is_complete(self) -> bool:
        """Whether there is a row of every run."""
        return not self.missing

    @property
    def schema(self) -> Any:
        """Schema of the rows of all parts."""
        import pyarrow.parquet as pq

        return common_schema(pq.read_schema(part.path) for part in self.parts)

    def tables(self, columns: Sequence[str] | None = None) -> Iterator[Any]:
        """Yield the rows part by part, in the order of the runs, each with the same columns."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        schema = self.schema
        if columns is not None:
            schema = pa.schema([schema.field(name) for name in columns])
        for part in self.parts:
            there = [name for name in schema.names if name in pq.read_schema(part.path).names]
            yield conformed(pq.read_table(part.path, columns=there), schema)

    def table(self, columns: Sequence[str] | None = None) -> Any:
        """Return all rows as a `pyarrow.Table`, sorted by run.

        Parameters
        ----------
        columns
            Names of the columns; all by default.
        """
        import pyarrow as pa

        tables = list(self.tables(columns))
        return pa.concat_tables(tables) if tables else self.schema.empty_table()

    def counts(self) -> Counter[str]:
        """Return how many runs have which status."""
        found: Counter[str] = Counter()
        for table in self.tables(["status"]) if self.done else ():
            for each in table["status"].value_counts().to_pylist():
                found[each["values"]] += each["counts"]
        return found

    def row(self, run: int) -> dict[str, Any]:
        """Return the row of a run.

        Raises
        ------
        RecordingError
            If there is none.
        """
        import pyarrow.parquet as pq

        for part in self.parts:
            if run in part.runs:
                table = pq.read_table(part.path).slice(run - part.runs.start, 1)
                return dict(table.to_pylist()[0])
        raise RecordingError(
            f"{self.folder}: received run {run}; required a run whose row is there, of 0 to "
            f"{self.spec.runs - 1}; choose another one, or go on with the campaign"
        )

    @property
    def summary(self) -> dict[str, Any]:
        """What the last run of the campaign said of itself; empty before it was complete."""
        path = self.folder / _SUMMARY
        return dict(json.loads(path.read_text(encoding="utf-8"))) if path.is_file() else {}

    def write_summary(self, summary: dict[str, Any]) -> None:
        """Write the summary of the campaign."""
        self.write_json(_SUMMARY, summary)

    def write_json(self, name: str, values: dict[str, Any]) -> None:
        """Write a JSON file of the folder, whole or not at all."""
        with whole_file(self.folder / name) as file:
            file.write_text(json.dumps(values, indent=2) + "\n", encoding="utf-8")


def _first_and_longest(part: Part) -> tuple[int, int]:
    return part.runs.start, -len(part.runs)


def _disjoint(parts: Sequence[Part]) -> Iterator[Part]:
    end = 0
    for part in parts:
        if part.runs.start >= end:
            end = part.runs.stop
            yield part


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RecordingError(
            f"--out: received {str(folder.parent)!r}, which cannot be made ({error.strerror}); "
            "required a folder that can be written; choose another one"
        ) from error
