"""Standard streams of ``gnc``: any text can be written, and failed writes are reported."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, ClassVar, TextIO

from spacecraft_gnc.errors import GncError


class OutputFailed(GncError):
    """Standard output cannot be written."""

    exit_code: ClassVar[int] = 1

    def __init__(self, reason: str | None) -> None:
        super().__init__(
            f"standard output: received {reason!r} while writing; required an open output with "
            "room for it; redirect it elsewhere"
        )


class PipeClosed(OutputFailed):
    """The reader of standard output has closed it."""

    exit_code: ClassVar[int] = 141  # as a shell reports SIGPIPE


@contextmanager
def checked_streams() -> Iterator[None]:
    """Write standard output and error so that nothing is lost in silence and no text fails.

    Characters that the encoding lacks are written as escapes. A failing write of standard error is
    dropped: there is no other place to tell it.

    Raises
    ------
    OutputFailed
        Standard output cannot be written.
    """
    out, err = sys.stdout, sys.stderr
    if err is None:  # closed: else print(file=None) would write to stdout
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123, SIM115
    if out is None:
        raise OutputFailed(os.strerror(9))
    if out is sys.__stdout__:  # not the one of a test or of a notebook
        sys.stdout = _wrapped(out, _Output)
    if err is not None and err is sys.__stderr__:
        sys.stderr = _wrapped(err, _Error)
    try:
        yield
    except SystemExit:
        sys.stdout.flush()
        raise
    except BaseException:
        with suppress(OutputFailed):  # what went wrong first is told
            sys.stdout.flush()
        raise
    else:
        sys.stdout.flush()
    finally:
        sys.stdout, sys.stderr = out, err or sys.stderr


class _Output(io.FileIO):
    """A file descriptor whose first failure is an `OutputFailed`; the rest is dropped."""

    _failed = False

    def write(self, data: Any) -> int:
        """Write ``data``; return the number of bytes written."""
        # An empty write is a question of what a stream takes; after a failure it is the rest of a
        # buffer that is being closed.
        if self._failed or not len(data):
            return len(data)
        try:
            return super().write(data)
        except BrokenPipeError as error:
            self._failed = True
            raise PipeClosed(error.strerror) from None
        except OSError as error:
            self._failed = True
            raise OutputFailed(error.strerror) from None


class _Error(io.FileIO):
    """A file descriptor whose failures are dropped."""

    def write(self, data: Any) -> int:
        """Write ``data`` as far as it goes; return its length."""
        with suppress(OSError):
            return super().write(data)
        return len(data)


def _wrapped(stream: Any, kind: type[io.FileIO]) -> TextIO:
    """Return a stream on the same descriptor, with the same encoding and buffering."""
    stream.flush()
    raw = kind(stream.fileno(), "w", closefd=False)
    return io.TextIOWrapper(
        raw if stream.write_through else io.BufferedWriter(raw),
        encoding=stream.encoding,
        errors="backslashreplace" if stream.errors == "strict" else stream.errors,
        line_buffering=stream.line_buffering,
        write_through=stream.write_through,
    )
