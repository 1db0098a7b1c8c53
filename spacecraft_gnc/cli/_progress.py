"""Progress of a command: a bar on a terminal, occasional lines in a log."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final, Protocol

_PATIENCE: Final = 2.0  # wall time [s] before anything is shown
_REFRESH: Final = 0.1  # wall time [s] between two pictures of the bar
_LINE_PERIOD: Final = 10.0  # wall time [s] between two lines


class Progress(Protocol):
    """Called by what works, as often as it likes."""

    def __call__(self, done: int, total: int, what: str = "") -> None:
        """Tell that ``done`` of ``total`` are done; ``what`` names the work from now on."""


@contextmanager
def show_progress(what: str, *, silent: bool = False) -> Iterator[Progress]:
    """Yield a callback that shows on stderr how far a command has come, once it lasts.

    Stdout stays free for results, so a bar is seen where they go into a file or a pipe.

    Parameters
    ----------
    what
        What is done, e.g. ``flying``.
    silent
        Show nothing (``--quiet``).
    """
    if silent:
        yield _ignore
    elif sys.stderr.isatty():
        with _bar(what) as update:
            yield update
    else:
        yield _Lines(what)


def _ignore(done: int, total: int, what: str = "") -> None:
    """Show nothing."""


class _Lines:
    """One line every ten seconds, for logs."""

    def __init__(self, what: str) -> None:
        self._what = what
        self._due = time.perf_counter() + _PATIENCE

    def __call__(self, done: int, total: int, what: str = "") -> None:
        self._what = what or self._what
        now = time.perf_counter()
        if now >= self._due and done < total:
            self._due = now + _LINE_PERIOD
            print(f"{self._what}: {done} of {total}", file=sys.stderr, flush=True)


@contextmanager
def _bar(what: str) -> Iterator[Progress]:
    from rich.console import Console
    from rich.progress import Progress as Bar

    started = time.perf_counter()
    with Bar(console=Console(stderr=True), transient=True, auto_refresh=False) as bar:
        task = bar.add_task(what, visible=False)
        refreshed = started

        def update(done: int, total: int, what: str = "") -> None:
            nonlocal refreshed
            now = time.perf_counter()
            if now - started > _PATIENCE and now - refreshed >= _REFRESH:
                refreshed = now
                if what:
                    bar.update(task, description=what)
                bar.update(task, completed=done, total=total, visible=True, refresh=True)

        yield update
