"""Atomic writing of an output file."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from spacecraft_gnc.errors import RecordingError


@contextmanager
def whole_file(target: Path) -> Iterator[Path]:
    """Yield the path of a temporary file beside ``target``, which takes its place at the end.

    Raises
    ------
    RecordingError
        If it cannot be written; nothing is left then.
    """
    temporary = target.with_name(f".{target.name}.part")
    try:
        yield temporary
        temporary.replace(target)
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno else str(error)
        raise RecordingError(
            f"{target}: cannot be written ({reason}); required a writable folder with free space; "
            "choose another output file"
        ) from error
    finally:
        if temporary.is_file():
            temporary.unlink()
