"""Sets on disk, in the user's cache folder, under the hash of what they follow from.

A file holds which rows belong to which set; the rows themselves follow from the loop, and come out
with the same bits as when the sets were computed. A file is read only if its name, shapes and
checksum are right; any other is computed again and replaced. Files are written whole or not at all.
Of several processes that ask for the same sets, one computes; the others wait for its file.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import sys
import tempfile
import zipfile
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from spacecraft_gnc.governors.periodic.problem import PeriodicConstraints, PeriodicLoop
from spacecraft_gnc.governors.periodic.recursion import (
    FoundMembers,
    Progress,
    SetOptions,
    found_members,
)
from spacecraft_gnc.governors.periodic.sets import AdmissibleSets, Members
from spacecraft_gnc.governors.periodic.steady import SteadyReferences, steady_references

if sys.platform != "win32":
    import fcntl

FOLDER_VARIABLE: Final = "SPACECRAFT_GNC_CACHE"
"""Environment variable with the folder in place of the user's cache folder."""

_VERSION: Final = "periodic sets 3"  # raise it when the same data give other rows
_KINDS: Final = {
    "counts": "i8", "source": "i4", "ahead": "i4", "closing": "f8",
    "rows": "f8", "bounds": "f8", "constraint": "i8", "inside": "f8",
}  # fmt: skip
_STEADY: Final = ("rows", "bounds", "constraint", "inside")
_UNREADABLE: Final = (
    OSError, ValueError, TypeError, KeyError, IndexError, EOFError, zipfile.BadZipFile, zlib.error,
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
        Called with one line if a file is damaged, the folder cannot be written, or another process
        computes the same sets and is waited for.

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
    stored = _stored(path, key, loop, tell)
    if stored is None:
        with _one_at_a_time(path, tell):
            stored = _stored(path, key, loop, _silent)  # another process may have been quicker
            if stored is None:
                stored = _computed(loop, constraints, options, progress)
                try:
                    _write(path, key, *stored)
                except OSError as error:
                    tell(f"{path}: cannot be written ({error.strerror}); computed again next time")
    steady, found = stored
    return found.sets(loop, constraints, steady)


def _computed(
    loop: PeriodicLoop,
    constraints: PeriodicConstraints,
    options: SetOptions,
    progress: Progress | None,
) -> tuple[SteadyReferences, FoundMembers]:
    with threadpool_limits(1):  # threads cost small matrices more than they gain: 58 s for 29 s
        steady = steady_references(loop, constraints, options.steady_share, options.tolerance)
        return steady, found_members(loop, constraints, steady, options, progress)


def _stored(
    path: Path, key: str, loop: PeriodicLoop, tell: Callable[[str], None]
) -> tuple[SteadyReferences, FoundMembers] | None:
    if not path.exists():
        return None
    try:
        return _read(path, key, loop)
    except _UNREADABLE as error:
        tell(f"{path}: not the sets it should hold ({error}); they are computed again")
        return None


@contextlib.contextmanager
def _one_at_a_time(path: Path, tell: Callable[[str], None]) -> Iterator[None]:
    """Hold the lock of a file; where there is no lock to be had, every process computes."""
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError):
            path.parent.mkdir(parents=True, exist_ok=True)
            if sys.platform != "win32":
                lock = stack.enter_context(path.with_suffix(".lock").open("ab"))
                try:
                    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except BlockingIOError:
                    tell(f"{path}: another process computes these sets; waiting for it")
                    fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def cache_folder() -> Path:
    """Return the folder for sets: of the environment variable, or the user's on the platform."""
    if os.environ.get(FOLDER_VARIABLE):
        return Path(os.environ[FOLDER_VARIABLE])
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


def _write(path: Path, key: str, steady: SteadyReferences, found: FoundMembers) -> None:
    arrays = {
        "counts": np.array([len(m.ahead) for m in found.members]),
        "source": np.concatenate([m.source for m in found.members]).astype(np.int32),
        "ahead": np.concatenate([m.ahead for m in found.members]).astype(np.int32),
        "closing": np.array([found.determined, found.steps, found.excess], dtype=np.float64),
    } | steady._asdict()
    check = np.array(_digest([key], [arrays[name] for name in _KINDS]))
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=".", suffix=".tmp")
    try:
        with os.fdopen(handle, "wb") as file:
            np.savez_compressed(file, check=check, **arrays)  # type: ignore[arg-type]
            file.flush()
            os.fsync(file.fileno())
        Path(name).replace(path)
    except BaseException:
        with contextlib.suppress(OSError):
            Path(name).unlink()
        raise


def _read(path: Path, key: str, loop: PeriodicLoop) -> tuple[SteadyReferences, FoundMembers]:
    with path.open("rb") as opened:
        file = np.load(opened, allow_pickle=False)
        if not isinstance(file, np.lib.npyio.NpzFile):
            raise ValueError("it is a single array")
        arrays = {name: file[name] for name in _KINDS}
        check = str(file["check"])
    for name, kind in _KINDS.items():
        if arrays[name].dtype != np.dtype(kind):
            raise ValueError(f"array {name!r} is of another type")
    if check != _digest([key], [arrays[name] for name in _KINDS]):
        raise ValueError("its checksum is wrong")
    counts, (determined, steps, excess) = arrays["counts"], arrays["closing"]
    source, ahead = (arrays[name].astype(np.int64) for name in ("source", "ahead"))
    if counts.shape != (loop.period,) or source.shape != (counts.sum(),):
        raise ValueError("its arrays do not fit")
    ends = np.cumsum(counts)
    members = tuple(
        Members(source[end - count : end], ahead[end - count : end])
        for end, count in zip(ends, counts, strict=True)
    )
    steady = SteadyReferences(*(arrays[name] for name in _STEADY))
    return steady, FoundMembers(members, bool(determined), int(steps), float(excess))


def _silent(_: str) -> None:
    """Ignore a notice."""
