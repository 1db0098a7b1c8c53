"""Folder and file of a bag being recorded."""

from __future__ import annotations

import os
from collections.abc import Callable
from io import FileIO
from pathlib import Path

from spacecraft_gnc.errors import RecordingError


def open_exclusive(path: Path) -> FileIO:
    """Create ``path`` for unbuffered writing; it must not exist."""
    return FileIO(path, "xb")


class RecordFile:
    """Output of the MCAP writer: every byte goes to the operating system at once.

    Nothing is held in this process, so a SIGKILL loses none of what was written. Where a write
    fails half-way (full disk), `rollback` cuts the file back to the last `commit`, and what is
    left ends with a whole record.

    Parameters
    ----------
    path
        File to create; it must not exist.
    opener
        Opens the raw file; tests inject failures here.
    """

    def __init__(self, path: Path, opener: Callable[[Path], FileIO] = open_exclusive) -> None:
        self._file = opener(path)
        self._position = 0
        self._committed = 0

    def write(self, data: bytes) -> int:
        """Write all of ``data``; a raw file may take only a part of it at a time."""
        rest = memoryview(data)
        while rest:
            written = self._file.write(rest)
            self._position += written
            rest = rest[written:]
        return len(data)

    def tell(self) -> int:
        """Bytes written so far."""
        return self._position

    def flush(self) -> None:
        """Nothing is buffered here."""

    def commit(self) -> None:
        """Mark the end of a whole record."""
        self._committed = self._position

    def rollback(self) -> None:
        """Cut the file back to the last `commit`."""
        self._file.truncate(self._committed)
        self._file.seek(self._committed)
        self._position = self._committed

    def sync(self) -> None:
        """Wait until the disk holds the file, so that a power cut spares it."""
        os.fsync(self._file.fileno())

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def prepare_folder(folder: Path) -> bool:
    """Make ``folder`` ready for a new bag; return whether it had to be created.

    Raises
    ------
    RecordingError
        If it holds something or cannot be made.
    """
    try:
        folder.mkdir(parents=True)
    except FileExistsError:
        occupied = not folder.is_dir() or any(folder.iterdir())
        if occupied:
            raise RecordingError(
                f"{folder}: exists and is not an empty folder; required a new or empty folder for "
                "the bag; choose another output folder or remove it"
            ) from None
        return False
    except OSError as error:
        raise RecordingError(
            f"{folder}: cannot be created ({os.strerror(error.errno or 0)}); required a folder "
            "that can be written; choose another output folder"
        ) from error
    return True


def stopped(path: Path, saved: int, error: OSError) -> RecordingError:
    """Return what to say of a recording that ``error`` ended after ``saved`` messages."""
    left = f"; {saved} messages are saved" if saved else ""
    return RecordingError(
        f"{path}: recording stopped ({os.strerror(error.errno or 0)}){left}; required a "
        "writable folder with free space; free some or choose another output folder"
    )


def refused_message(
    path: Path, topic: str, is_announced: bool, log_time_ns: int, publish_time_ns: int
) -> RecordingError:
    """Return what to say of a message that cannot be written."""
    if not is_announced:
        return RecordingError(
            f"{topic}: not announced to {path}, or the bag is closed; call add_topic first"
        )
    return RecordingError(
        f"{topic}: received log time {log_time_ns} ns and publish time {publish_time_ns} ns; "
        "required not negative; give nanoseconds of one clock"
    )
