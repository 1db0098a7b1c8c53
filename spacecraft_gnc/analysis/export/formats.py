"""Lossless writers of the export formats: doubles are kept bit for bit, integers as integers."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import __version__
from spacecraft_gnc.analysis.export.topics import STEP, Column, Export
from spacecraft_gnc.drawing.whole_file import whole_file
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.extras import explained_imports

SUFFIXES: Final = ("csv", "parquet", "npz", "mat")
LONGEST_NAME: Final = 31
"""Letters of a MATLAB name that every version keeps."""
_BLOCK: Final = 2048  # rows of a CSV file that are formatted together
Progress: TypeAlias = "Callable[[int, int], None]"


def write_export(
    export: Export, target: Path, kind: str, progress: Progress | None = None
) -> list[Path]:
    """Write an export, whole or not at all.

    ``csv`` and ``parquet`` hold one table with a row for each control step and a column for each
    number, empty (null) where a topic has no message of a step. ``npz`` and ``mat`` hold one array
    for each field, (messages, width).

    Parameters
    ----------
    export
        What to write.
    target
        The file.
    kind
        Of `SUFFIXES`.
    progress
        Called with what is done and in all.

    Returns
    -------
    list of Path
        ``target``; of ``csv`` also the table of units beside it.

    Raises
    ------
    ParameterError
        If pyarrow is missing, or a name is too long for MATLAB.
    RecordingError
        If the file cannot be written.
    """
    progress = progress or _ignore
    if kind == "csv":
        return _write_csv(export, target, progress)
    writers = {"parquet": _write_parquet, "npz": _write_npz, "mat": _write_mat}
    with whole_file(target) as file:
        writers[kind](export, file, progress)
    return [target]


def units_path(target: Path) -> Path:
    """Return where the units of a CSV file are written."""
    return target.with_name(f"{target.stem}.columns.csv")


def _ignore(done: int, total: int) -> None:
    """Show nothing."""


# --- CSV -----------------------------------------------------------------------------------


def _write_csv(export: Export, target: Path, progress: Progress) -> list[Path]:
    columns, units = _table(export), units_path(target)
    # The table of units is renamed first: where the data are, it is too.
    with whole_file(target) as file, whole_file(units) as units_file:
        with units_file.open("w", encoding="utf-8", newline="") as stream:
            csv.writer(stream).writerows([("column", "unit", "description"), *_documented(export)])
        with file.open("w", encoding="utf-8", newline="") as stream:
            writer = csv.writer(stream)
            writer.writerow([STEP, *(column.name for column in columns)])
            for rows, done, total in _blocks(export, columns):
                writer.writerows(rows)
                progress(done, total)
    return [target, units]


def _blocks(
    export: Export, columns: list[Column]
) -> Iterator[tuple[Iterable[tuple[Any, ...]], int, int]]:
    """Yield the rows of the table in blocks, with how many are done of all."""
    steps = export.steps()
    for begin in range(0, len(steps), _BLOCK):
        end = min(begin + _BLOCK, len(steps))
        cells = [steps[begin:end].tolist(), *(_cells(column, begin, end) for column in columns)]
        yield zip(*cells, strict=True), end, len(steps)


def _cells(column: Column, begin: int, end: int) -> list[Any]:
    """Return Python values of some rows, None where there is none; csv writes doubles in full."""
    first, last = np.searchsorted(column.rows, (begin, end))
    values = column.values[first:last]
    numbers = (values.astype(np.int64) if values.dtype == bool else values).tolist()
    if last - first == end - begin:
        return list(numbers)
    cells: list[Any] = [None] * (end - begin)
    for row, number in zip(column.rows[first:last].tolist(), numbers, strict=True):
        cells[row - begin] = number
    return cells


# --- Parquet -------------------------------------------------------------------------------


def _write_parquet(export: Export, file: Path, progress: Progress) -> None:
    with explained_imports():
        import pyarrow as pa
        import pyarrow.parquet as pq
    columns, steps = _table(export), export.steps()
    arrays = [pa.array(steps)]
    fields = [pa.field(STEP, pa.int64(), metadata={"unit": "-", "description": "control step"})]
    for i, column in enumerate(columns):
        values, missing = _spread(column, len(steps))
        text = values.dtype == object
        array = pa.array(values, type=pa.string() if text else None, mask=missing)
        metadata = {"unit": column.text.unit, "description": column.text.description}
        arrays.append(array)
        fields.append(pa.field(column.name, array.type, metadata=metadata))
        progress(i, len(columns) + 1)
    origin = {"source": str(export.path), "written_by": f"spacecraft_gnc {__version__}"}
    pq.write_table(pa.Table.from_arrays(arrays, schema=pa.schema(fields, origin)), file)


def _spread(column: Column, n: int) -> tuple[NDArray[Any], NDArray[np.bool_]]:
    """Return (n,) values, and which rows have none."""
    missing = np.ones(n, dtype=bool)
    missing[column.rows] = False
    values = np.zeros(n, dtype=column.values.dtype)
    values[column.rows] = column.values
    return values, missing


# --- arrays --------------------------------------------------------------------------------


def _write_npz(export: Export, file: Path, progress: Progress) -> None:
    arrays: dict[str, NDArray[Any]] = {"columns": np.array(list(_fields(export)), dtype=np.str_)}
    for topic in export.topics:
        for field in topic.fields:
            text = field.values.dtype == object  # strings without pickle
            values = field.values.astype(np.str_) if text else field.values
            arrays[f"{topic.name}.{field.name}"] = values
    with file.open("wb") as stream:
        np.savez_compressed(stream, allow_pickle=False, **arrays)
    progress(1, 1)


def _write_mat(export: Export, file: Path, progress: Progress) -> None:
    from scipy.io import savemat

    structs: dict[str, dict[str, Any]] = {"units": {}, "descriptions": {}}
    for topic in export.topics:
        name = _matlab_name(topic.name)
        named = {_matlab_name(field.name): field for field in topic.fields}
        structs[name] = {key: field.values for key, field in named.items()}
        structs["units"][name] = {key: field.text.unit for key, field in named.items()}
        structs["descriptions"][name] = {k: field.text.description for k, field in named.items()}
    with file.open("wb") as stream:
        savemat(stream, structs, do_compression=True, oned_as="column")
    progress(1, 1)


def _matlab_name(name: str) -> str:
    """Return a name as MATLAB takes it."""
    plain = name.replace(".", "_").replace("/", "_")
    if len(plain) > LONGEST_NAME or not plain.isidentifier():
        raise ParameterError(
            f"--format: received mat, but {name!r} is no name for MATLAB; required at most "
            f"{LONGEST_NAME} letters, digits and underscores; choose csv, parquet or npz"
        )
    return plain


# --- documentation of the columns ----------------------------------------------------------


def _table(export: Export) -> list[Column]:
    """Return the columns behind the step, which all topics share."""
    return [column for column in export.columns() if not column.name.endswith(f".{STEP}")]


def _documented(export: Export) -> Iterator[tuple[str, str, str]]:
    yield STEP, "-", "control step"
    for column in _table(export):
        yield column.name, column.text.unit, column.text.description


def _fields(export: Export) -> Iterator[tuple[str, str, str]]:
    for topic in export.topics:
        for field in topic.fields:
            yield f"{topic.name}.{field.name}", field.text.unit, field.text.description
