"""Sets of `sets.py` on disk, in the user's cache folder, under the hash of what they follow from.

A file is read only if its name, shapes and checksum are right; any other is computed again and
replaced. Files are written whole or not at all, so that several processes can share the folder.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import sys
import tempfile
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.governors.periodic.problem import PeriodicConstraints, PeriodicLoop
from spacecraft_gnc.governors.periodic.sets import (
    AdmissibleSet,
    AdmissibleSets,
    Progress,
    SetOptions,
    admissible_sets,
)
from spacecraft_gnc.types import read_only

_VERSION: Final = "periodic sets 1"  # raise it when the same data give other rows
_ROW_ARRAYS: Final = ("state_rows", "reference_rows", "bounds", "constraint", "ahead")
_KINDS: Final = {
    "state_rows": "f8", "reference_rows": "f8", "bounds": "f8", "constraint": "i8", "ahead": "i8",
    "inside": "f8", "counts": "i8", "closing": "f8",
}  # fmt: skip
_UNREADABLE: Final = (
    OSError, ValueError, TypeError, KeyError, EOFError, zipfile.BadZipFile,
)  # fmt: skip


def cached_sets(
    loop: PeriodicLoop,
    constraints: PeriodicConstraints,
    options: SetOptions | None = None,
    progress: Progress | None = None,
    *,
    folder: Path | None = None,
    notice: Callable[[str], None] | None = None,
) -> AdmissibleSets:
    """Return `admissible_sets`, read from the cache if they are there.

    Parameters
    ----------
    loop, constraints, options, progress
        As of `admissible_sets`.
    folder : Path, optional
        In place of `cache_folder`.
    notice : callable, optional
        Called with one line if a file is damaged, or the folder cannot be written.

    Raises
    ------
    EmptySetError, ShapeError
        As `admissible_sets`.
    """
    constraints.require_fit(loop)
    options = SetOptions() if options is None else options
    tell = notice if notice is not None else _silent
    key = data_key(loop, constraints, options)
    path = (cache_folder() if folder is None else folder) / f"{key}.npz"
    if path.exists():
        try:
            return _read(path, key, loop, constraints)
        except _UNREADABLE as error:
            tell(f"{path}: not the sets it should hold ({error}); they are computed again")
    sets = admissible_sets(loop, constraints, options, progress)
    try:
        _write(path, key, sets)
    except OSError as error:
        tell(f"{path}: cannot be written ({error.strerror}); the sets are computed again next time")
    return sets


def cache_folder() -> Path:
    """Return the folder for sets in the user's cache folder, as the platform has it."""
    if sys.platform == "darwin":
        base = Path("~/Library/Caches").expanduser()
    elif sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA") or Path("~/AppData/Local").expanduser())
    else:
        given = Path(os.environ.get("XDG_CACHE_HOME", ""))
        base = given if given.is_absolute() else Path("~/.cache").expanduser()
    return base / "spacecraft_gnc" / "periodic_sets"


def data_key(loop: PeriodicLoop, constraints: PeriodicConstraints, options: SetOptions) -> str:
    """Return the SHA-256, in hexadecimal digits, of all that the sets follow from."""
    numbers = (options.steady_share, float(options.most_steps), options.tolerance)
    return _digest(
        [_VERSION, *constraints.names],
        [
            np.array(numbers), loop.state_map, loop.reference_map, constraints.state_rows,
            constraints.reference_rows, constraints.bounds,
        ],
    )  # fmt: skip


def _digest(texts: list[str], arrays: list[NDArray[Any]]) -> str:
    found = hashlib.sha256()
    for text in texts:
        encoded = text.encode()
        found.update(len(encoded).to_bytes(8, "little") + encoded)
    for array in arrays:
        found.update(f"{array.shape}".encode())
        found.update(np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<")).data)
    return found.hexdigest()


def _write(path: Path, key: str, sets: AdmissibleSets) -> None:
    arrays = {name: np.concatenate([getattr(o, name) for o in sets.sets]) for name in _ROW_ARRAYS}
    arrays["inside"] = sets.inside
    arrays["counts"] = np.array([len(o.bounds) for o in sets.sets])
    arrays["closing"] = np.array([sets.determined, sets.steps, sets.excess], dtype=np.float64)
    check = np.array(_digest([key], [arrays[name] for name in _KINDS]))
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=".", suffix=".tmp")
    try:
        with os.fdopen(handle, "wb") as file:
            np.savez(file, check=check, **arrays)  # type: ignore[arg-type]
            file.flush()
            os.fsync(file.fileno())
        Path(name).replace(path)
    except BaseException:
        with contextlib.suppress(OSError):
            Path(name).unlink()
        raise


def _read(
    path: Path, key: str, loop: PeriodicLoop, constraints: PeriodicConstraints
) -> AdmissibleSets:
    with np.load(path, allow_pickle=False) as file:
        arrays = {name: file[name] for name in _KINDS}
        check = str(file["check"])
    for name, kind in _KINDS.items():
        if arrays[name].dtype != np.dtype(kind):
            raise ValueError(f"array {name!r} is of another type")
    if check != _digest([key], [arrays[name] for name in _KINDS]):
        raise ValueError("its checksum is wrong")
    counts, (determined, steps, excess) = arrays["counts"], arrays["closing"]
    if counts.shape != (loop.period,) or arrays["bounds"].shape != (counts.sum(),):
        raise ValueError("its arrays do not fit")
    ends = np.cumsum(counts)
    columns = [read_only(arrays[name]) for name in _ROW_ARRAYS]
    sets = tuple(
        AdmissibleSet(*(column[end - count : end] for column in columns))
        for end, count in zip(ends, counts, strict=True)
    )
    inside = read_only(arrays["inside"])
    return AdmissibleSets(
        sets, constraints.names, inside, bool(determined), int(steps), float(excess)
    )


def _silent(_: str) -> None:
    """Ignore a notice."""
