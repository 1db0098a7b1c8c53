"""Processes beside a flight, and what processes print and when."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import threading
import time
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any, Final, NamedTuple

PATIENCE: Final = 240.0  # [s] wall for anything to happen


class Line(NamedTuple):
    """A line of output, and the wall time at which it came (`time.monotonic`) [s]."""

    at: float
    text: str


class Lines:
    """The output of a process, read by a thread."""

    def __init__(self, stream: IO[str] | None) -> None:
        if stream is None:
            raise ValueError("a stream is needed")
        self.lines: list[Line] = []
        self._stream = stream
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self) -> None:
        for text in self._stream:
            self.lines.append(Line(time.monotonic(), text.rstrip("\n")))

    def join(self) -> None:
        """Wait for the end of the stream, but not for ever."""
        self._thread.join(PATIENCE)

    @property
    def text(self) -> str:
        """All of it so far."""
        return "\n".join(line.text for line in list(self.lines))

    def first(self, pattern: str, after: float = 0.0) -> Line | None:
        """Return the first line after a time that a pattern is found in."""
        found = re.compile(pattern)
        lines = list(self.lines)
        return next((n for n in lines if n.at >= after and found.search(n.text)), None)


class Side:
    """A process beside the flight, which prints one JSON object a line: see `hostile_stranger`."""

    def __init__(self, job: Mapping[str, Any], environment: Mapping[str, str]) -> None:
        command = [sys.executable, str(Path(__file__).with_name("hostile_stranger.py"))]
        self._process = subprocess.Popen(
            [*command, json.dumps({**job, "parent": os.getpid()})],
            env=dict(environment),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self._output = Lines(self._process.stdout)
        self._read = 0
        self._said: dict[str, list[dict[str, Any]]] = defaultdict(list)

    def said(self, kind: str) -> list[dict[str, Any]]:
        """Return what it printed of a kind so far."""
        lines = self._output.lines
        while self._read < len(lines):
            line = json.loads(lines[self._read].text)
            self._said[line["kind"]].append(line)
            self._read += 1
        return self._said[kind]

    @property
    def ended(self) -> bool:
        """Whether it has ended by itself."""
        return self._process.poll() is not None

    def close(self) -> None:
        """End it; what it said stays."""
        self._process.kill()
        self._process.wait()
        self._output.join()
