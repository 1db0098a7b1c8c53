"""Wall clock for compiled kernels, so that each of many solves in one call has a time."""

from __future__ import annotations

import time
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, overload


def now() -> float:
    """Return the time of the monotonic clock [s]; compiled, without a call of Python."""
    return time.perf_counter()


@intrinsic  # type: ignore[untyped-decorator]
def _now(_context: Any) -> Any:
    def build(_context: Any, builder: Any, _signature: Any, _arguments: Any) -> Any:
        word, number = ir.IntType(64), ir.DoubleType()
        kind = ir.FunctionType(ir.IntType(32), [ir.IntType(32), word.as_pointer()])
        read = cgutils.get_or_insert_function(builder.module, kind, "clock_gettime")
        pair = cgutils.alloca_once(builder, word, 2)  # a timespec: seconds, nanoseconds
        builder.call(read, [ir.Constant(ir.IntType(32), time.CLOCK_MONOTONIC), pair])
        seconds, rest = (
            builder.sitofp(builder.load(builder.gep(pair, [ir.Constant(word, i)])), number)
            for i in range(2)
        )
        return builder.fadd(seconds, builder.fmul(rest, ir.Constant(number, 1e-9)))

    return types.float64(), build


@overload(now)  # type: ignore[untyped-decorator]
def _compiled_now() -> Any:
    def read() -> Any:
        return _now()

    return read
