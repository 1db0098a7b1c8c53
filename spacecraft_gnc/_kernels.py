"""Compilation of the kernels, and the one-line notice shown when it takes long.

Cached (`_cached_kernels`): compiled once, at set-up. ``error_model="numpy"``: a division by zero
gives infinity or NaN, which the solvers report as a status, instead of an exception in the loop. No
fast-math: the same numbers interpreted (NUMBA_DISABLE_JIT=1) and on every machine with the same
libraries. ``no_cfunc_wrapper``: no C callbacks, which are unused and take a fifteenth of the set-up
time.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from typing import Any, Final

from numba import config as numba_config
from numba import njit, types
from numba.core import cgutils, event
from numba.extending import intrinsic, overload

from spacecraft_gnc import SILENT_COMPILER
from spacecraft_gnc._cached_kernels import keep

_PACKAGE: Final = __name__.partition(".")[0]
_PATIENCE: Final = 1.0  # [s] of compiling; a single kernel for a new type takes less

# 3x3 matrices at twice the speed, by the same operations, so with the same bits.
numba_config.SLP_VECTORIZE = 1


def _cached(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles kernels with these options and caches them."""

    def decorate(function: Callable[..., Any]) -> Any:
        compiled = njit(error_model="numpy", no_cfunc_wrapper=True, **options)(function)
        if compiled is not function:  # else it runs interpreted
            keep(compiled)
        return compiled

    return decorate


kernel = _cached()
inlined_kernel = _cached(forceinline=True)
"""For few operations on tuples, which a call would pass through memory: put into every caller."""
unlocked_kernel = _cached(nogil=True)
"""For kernels that take milliseconds, called from Python: other threads run meanwhile."""


def unowned(array: Any) -> Any:
    """Return an array as it is; compiled, a view that counts no references.

    Counting them, at each call and for each part cut out of the array, takes a fifth of a solve.
    For the arguments of a kernel only: its caller holds them.
    """
    return array


def given(array: Any) -> Any:
    """Return an array as it is; compiled, an `unowned` view of the type `GIVEN`, to read only."""
    return array


GIVEN: Final = tuple(types.Array(types.float64, n, "A", readonly=True) for n in (1, 2))
"""Types of inputs, vectors and matrices, of any layout: all callers share one compiled kernel."""
OWN: Final = types.Array(types.float64, 1, "C"), types.Array(types.int64, 1, "C")
"""Types of flat arrays, numbers and integers, that a kernel reads and writes."""


def _view_as(make_type: Callable[[Any], Any]) -> Any:
    """Return an intrinsic that views an array without an owner as another type."""

    def view(_context: Any, array: Any) -> Any:
        made = make_type(array)

        def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            old = context.make_array(signature.args[0])(context, builder, arguments[0])
            new = context.make_array(made)(context, builder)
            for name in ("nitems", "itemsize", "data", "shape", "strides"):
                setattr(new, name, getattr(old, name))
            new.meminfo = cgutils.get_null_value(new.meminfo.type)
            new.parent = cgutils.get_null_value(new.parent.type)
            return new._getvalue()  # noqa: SLF001 - numba has no other name for it

        return made(array), build

    return intrinsic(view)


_unowned: Final = _view_as(lambda array: array)
_given: Final = _view_as(lambda array: GIVEN[array.ndim - 1])


@overload(unowned)  # type: ignore[untyped-decorator]
def _compiled_unowned(array: Any) -> Any:
    def view(array: Any) -> Any:
        return _unowned(array)

    return view if isinstance(array, types.Array) else None


@overload(given)  # type: ignore[untyped-decorator]
def _compiled_given(array: Any) -> Any:
    def view(array: Any) -> Any:
        return _given(array)

    return view if isinstance(array, types.Array) else None


def entry(function: Any, *arguments: Any) -> Callable[..., Any]:
    """Return a kernel for calls from Python, compiled or loaded for these types and no others.

    It raises TypeError for arguments of other types instead of compiling for them in flight.
    """
    if hasattr(function, "disable_compile"):
        function.compile(arguments)
        function.disable_compile()
        return function  # type: ignore[no-any-return]

    def checked(*values: Any) -> Any:
        for value, needed in zip(values, arguments, strict=True):
            if getattr(value, "dtype", None) != str(needed.dtype) or value.ndim != needed.ndim:
                raise TypeError
        return function(*values)

    return checked


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
