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
_LONGEST: Final = 16  # bytes read at once: a key, or a few of one that is held down


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
    try:
        yield lambda: _key(descriptor)
    finally:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)


def _key(descriptor: int) -> str | None:
    readable, _, _ = select.select([descriptor], [], [], 0.0)
    return meaning(os.read(descriptor, _LONGEST)) if readable else None


def meaning(typed: bytes) -> str | None:
    """Return what the first key in ``typed`` means: pause, quit, back, forward, faster, slower."""
    for sequence, word in _MEANINGS.items():
        if typed.startswith(sequence):
            return word
    return None
