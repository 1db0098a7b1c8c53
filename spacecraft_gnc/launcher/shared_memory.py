"""Shared memory that DDS leaves behind when a process is killed."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Final

_FOLDER: Final = Path("/dev/shm")  # noqa: S108 - where Fast DDS puts its segments
_PREFIX: Final = "fastrtps_"
_LOCK_SUFFIX: Final = "_el"


def remove_orphans() -> int:
    """Remove this user's segments whose owner is dead; return how many.

    A living owner holds a lock on the file ``<segment>_el``. Source: Fast DDS,
    ``RobustExclusiveLock``, which its own ``fastdds shm clean`` relies on.
    """
    removed = 0
    for lock in _lock_files():
        with suppress(OSError), lock.open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)  # raises while the owner lives
            segment = lock.with_name(lock.name.removesuffix(_LOCK_SUFFIX))
            segment.unlink(missing_ok=True)
            lock.unlink(missing_ok=True)
            removed += 1
    return removed


def _lock_files() -> Iterator[Path]:
    try:
        entries = [*_FOLDER.glob(f"{_PREFIX}*{_LOCK_SUFFIX}")]
    except OSError:
        return
    for entry in entries:
        with suppress(OSError):
            if entry.stat().st_uid == os.getuid():
                yield entry
