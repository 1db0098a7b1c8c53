"""Output of a node: drained from a pipe, its end kept in memory, all of it written to a log."""

from __future__ import annotations

import os
import re
import threading
import time
from pathlib import Path
from typing import IO, Final

_TAIL: Final = 20  # lines
_TAIL_BYTES: Final = 8192
_CHUNK: Final = 65536  # [bytes]
_QUIET: Final = 0.1  # [s] wall without a word after which somebody has said all
_REPORTED: Final = "error: "  # how a node says why it ends
_RAISED: Final = re.compile(r"(\[(ERROR|FATAL)\]|Fatal Python error:|[\w.]+(Error|Exception)\b)")


class Output:
    """What a process writes into a pipe.

    The log may lie on a disk that fills up, or in a folder that somebody deletes; why a process
    ended is known all the same, and the process is not held up.

    Parameters
    ----------
    pipe
        Read end of the pipe; closed at its end.
    log
        File that is appended to.
    """

    def __init__(self, pipe: IO[bytes], log: Path) -> None:
        self.log = log
        self.trouble = ""
        """Why the log is not complete; empty: it is."""
        self._tail = b""
        self._size = 0
        self._lock = threading.Lock()
        self._append(b"")
        self._thread = threading.Thread(target=self._drain, args=(pipe,), daemon=True)
        self._thread.start()

    def write(self, data: bytes) -> None:
        """Add to the output what the process itself did not write."""
        with self._lock:
            self._size += len(data)
            self._tail = (self._tail + data)[-_TAIL_BYTES:]
            self._append(data)

    def await_more(self, patience: float) -> bool:
        """Wait until more has come and then no more; return whether any has.

        Parameters
        ----------
        patience
            Wall time at most [s].
        """
        begun, size, deadline = self._size, self._size, time.monotonic() + patience
        while time.monotonic() < deadline and self._thread.is_alive():
            time.sleep(_QUIET)
            if self._size == size > begun:
                break
            size = self._size
        return self._size > begun

    def wait(self, patience: float) -> None:
        """Wait for the end of the output, ``patience`` [s] of wall time at most."""
        self._thread.join(patience)

    def last_lines(self) -> list[str]:
        """Return the last lines."""
        return self._tail.decode(errors="replace").splitlines()[-_TAIL:]

    def errors(self) -> list[str]:
        """Return the ``error:`` lines among the last lines, without the prefix."""
        lines = self.last_lines()
        return [line.removeprefix(_REPORTED) for line in lines if line.startswith(_REPORTED)]

    def last_error(self) -> str:
        """Return the last line that tells of an error; empty: there is none."""
        raised = [line.strip() for line in self.last_lines() if _RAISED.match(line)]
        return (self.errors() or raised or [""])[-1]

    def _append(self, data: bytes) -> None:
        try:
            with self.log.open("ab", buffering=0) as log:
                while data:
                    data = data[log.write(data) :]
        except OSError as error:
            self.trouble = self.trouble or os.strerror(error.errno or 0)

    def _drain(self, pipe: IO[bytes]) -> None:
        with pipe:
            while data := os.read(pipe.fileno(), _CHUNK):
                self.write(data)
