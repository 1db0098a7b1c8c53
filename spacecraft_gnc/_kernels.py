"""Compilation of the kernels, and the one-line notice shown when it takes long.

``cache``: compiled once, at set-up. ``error_model="numpy"``: a division by zero gives infinity or
NaN, which the solvers report as a status, instead of an exception in the loop. No fast-math: the
same numbers interpreted (NUMBA_DISABLE_JIT=1) and on every machine with the same libraries.
``no_cfunc_wrapper``: no C callbacks, which are unused and take a fifteenth of the set-up time.
"""

from __future__ import annotations

import os
import sys
import time
from typing import Any, Final

from numba import njit
from numba.core import event

from spacecraft_gnc import SILENT_COMPILER

_PACKAGE: Final = __name__.partition(".")[0]
_PATIENCE: Final = 1.0  # [s] of compiling; a single kernel for a new type takes less

kernel = njit(cache=True, error_model="numpy", no_cfunc_wrapper=True)
unlocked_kernel = njit(cache=True, error_model="numpy", no_cfunc_wrapper=True, nogil=True)
"""For kernels that take milliseconds, called from Python: other threads run meanwhile."""


class _Notice(event.Listener):  # type: ignore[misc]  # numba has no types
    """Report once, on stderr, that kernels of this package are being compiled, if it takes long.

    Numba emits an event for every kernel that it compiles, but not for one from the cache. Kernels
    call kernels, so a cold cache causes a long chain of such events.
    """

    def __init__(self) -> None:
        self._depth = 0
        self._begun = 0.0
        self._told = False

    def on_start(self, event: Any) -> None:
        """Note the start of a compilation; print the notice if compiling already takes long."""
        if not _is_ours(event):
            return
        if self._depth == 0:
            self._begun = time.monotonic()
        self._depth += 1
        if not self._told and time.monotonic() - self._begun > _PATIENCE:
            self._told = True
            if os.environ.get(SILENT_COMPILER) != "1" and sys.stderr is not None:
                print(
                    f"{_PACKAGE}: compiling kernels for the first time (a minute or more); "
                    "`gnc warmup` does it ahead",
                    file=sys.stderr,
                    flush=True,
                )

    def on_end(self, event: Any) -> None:
        """Note the end of a compilation."""
        self._depth -= _is_ours(event)


def _is_ours(event: Any) -> bool:
    return bool(event.data["dispatcher"].py_func.__module__.startswith(f"{_PACKAGE}."))


event.register("numba:compile", _Notice())
