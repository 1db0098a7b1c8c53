"""A deadline for the end of a process, kept by the C library, whatever holds Python."""

from __future__ import annotations

import ctypes
import time
from typing import Any, ClassVar

_SIGEV_THREAD = 2  # bits/sigevent-consts.h


class _Event(ctypes.Structure):
    """``struct sigevent`` of a 64-bit Linux: 64 bytes."""

    _fields_: ClassVar[Any] = [
        ("value", ctypes.c_void_p),
        ("signal", ctypes.c_int),
        ("notify", ctypes.c_int),
        ("function", ctypes.c_void_p),
        ("attributes", ctypes.c_void_p),
        ("rest", ctypes.c_byte * 32),
    ]


class _Period(ctypes.Structure):
    """``struct itimerspec``: what comes after, and when it comes."""

    _fields_: ClassVar[Any] = [
        ("interval_s", ctypes.c_long),
        ("interval_ns", ctypes.c_long),
        ("value_s", ctypes.c_long),
        ("value_ns", ctypes.c_long),
    ]


def end_within(seconds: float, code: int) -> None:
    """End this process with an exit code after ``seconds`` of wall time, if it still runs then.

    A thread of the C library calls ``_exit``: neither the interpreter's lock nor a signal handler
    is asked, and the exit code is that of the caller.

    Parameters
    ----------
    seconds
        Time that is granted [s].
    code
        Exit code.

    Raises
    ------
    OSError
        If the system grants no timer.
    """
    libc: Any = ctypes.CDLL(None, use_errno=True)
    leave = ctypes.cast(libc["_exit"], ctypes.c_void_p)
    event = _Event(code, 0, _SIGEV_THREAD, leave, None)
    timer = ctypes.c_void_p()
    period = _Period(0, 0, int(seconds), int(seconds % 1.0 * 1e9))
    if libc.timer_create(time.CLOCK_MONOTONIC, ctypes.byref(event), ctypes.byref(timer)):
        raise OSError(ctypes.get_errno(), "timer_create failed")
    if libc.timer_settime(timer, 0, ctypes.byref(period), None):
        raise OSError(ctypes.get_errno(), "timer_settime failed")
