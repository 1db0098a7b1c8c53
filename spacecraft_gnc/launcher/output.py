"""Output of a node: drained from a pipe, its end kept in memory, all of it written to a log."""

from __future__ import annotations

import os
import re
import threading
from contextlib import ExitStack
from pathlib import Path
from typing import IO, Final

_TAIL: Final = 20  # lines
_TAIL_BYTES: Final = 8192
_CHUNK: Final = 65536  # [bytes]
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
        self._lock = threading.Lock()
        self._files = ExitStack()
        self._log: IO[bytes] | None = None
        try:
            self._log = self._files.enter_context(log.open("ab", buffering=0))
        except OSError as error:
            self.trouble = os.strerror(error.errno or 0)
        self._thread = threading.Thread(target=self._drain, args=(pipe,), daemon=True)
        self._thread.start()

    def write(self, data: bytes) -> None:
        """Add to the output what the process itself did not write."""
        with self._lock:
            self._tail = (self._tail + data)[-_TAIL_BYTES:]
            if self._log is None:
                return
            try:
                while data:
                    data = data[self._log.write(data) :]
            except OSError as error:
                self.trouble = self.trouble or os.strerror(error.errno or 0)

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

    def _drain(self, pipe: IO[bytes]) -> None:
        with pipe, self._files:
            while data := os.read(pipe.fileno(), _CHUNK):
                self.write(data)
