"""Single keys of a terminal, without waiting for them."""

from __future__ import annotations

import os
import select
import sys
import termios
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

_MEANINGS: Final = {
    b" ": "pause",
    b"q": "quit",
    b"\x1b[D": "back",
    b"\x1b[C": "forward",
    b"\x1b[A": "faster",
    b"\x1b[B": "slower",
    b"\x1bOD": "back",  # in the application mode of some terminals
    b"\x1bOC": "forward",
    b"\x1bOA": "faster",
    b"\x1bOB": "slower",
}
_LONGEST: Final = 1024  # bytes read at once


@contextmanager
def pressed_keys() -> Iterator[Callable[[], str | None] | None]:
    """Yield a function that returns the meaning of a key, or None; without a terminal, None.

    The terminal is given back as it was.
    """
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        yield None
        return
    descriptor = sys.stdin.fileno()
    before = termios.tcgetattr(descriptor)
    tty.setcbreak(descriptor)
    keys = Keys(descriptor)
    try:
        yield keys.next
    finally:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)


class Keys:
    """What was typed, one meaning at a time.

    Parameters
    ----------
    descriptor
        File descriptor that is read, and never waited for.
    """

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._typed = b""

    def next(self) -> str | None:
        """Return what the next key means (pause, quit, back, forward, faster, slower), or None."""
        readable, _, _ = select.select([self._descriptor], [], [], 0.0)
        if readable:
            self._typed += os.read(self._descriptor, _LONGEST)
        while self._typed:
            for sequence, word in _MEANINGS.items():
                if self._typed.startswith(sequence):
                    self._typed = self._typed[len(sequence) :]
                    return word
            self._typed = self._typed[1:]
        return None
