"""Guard of a topic: what may be said on it and by whom, derived from its signal."""

from __future__ import annotations

from typing import Final, NamedTuple

from spacecraft_gnc.signals.message import NS_PER_S, Message, Refused
from spacecraft_gnc.signals.seal import opener, without_seal
from spacecraft_gnc.signals.signal import Signal

LARGEST: Final = 1 << 20
"""Bytes of a message that is looked at; those of the graph have a few kilobytes at most."""


class Window(NamedTuple):
    """Simulated time of a flight."""

    period_ns: int
    """Control period [ns]."""
    n_steps: int
    """Control steps; the last state is that of this step."""


class Guard:
    """Admits the messages of one topic, or raises `Refused`.

    The user's door, a signal without publishers of the graph, asks for no seal and for no time:
    whoever sends a target need not know them.

    Parameters
    ----------
    signal
        What is sent on the topic.
    topic
        Full name of the topic.
    key
        Of the flight (`seal`); empty: none.
    window
        When messages may be of.
    """

    def __init__(self, signal: Signal, topic: str, key: bytes, window: Window) -> None:
        self.signal = signal
        self.is_open = not signal.publishers
        """Whether it is the user's door."""
        is_sealed = signal.sealed and not self.is_open
        self._cut = opener(key, topic) if is_sealed else without_seal
        self._is_timed = signal.is_stepped and not self.is_open
        self._period_ns, self._n_steps = window
        self._end_ns = self._period_ns * self._n_steps

    def open(self, data: bytes) -> bytes:
        """Return a message without its seal.

        Raises
        ------
        Refused
            If it is too long, or nobody of this flight sealed it.
        """
        if len(data) > LARGEST:
            raise Refused(f"{len(data)} bytes; required at most {LARGEST}", "layout")
        message = self._cut(data)
        if message is None:
            raise Refused("no fresh seal of this flight: not from a node of its launch", "seal")
        return message

    def decode(self, data: bytes, last_step: int = 0) -> Message:
        """Return an opened message whose numbers, step and stamp keep their rules.

        Raises
        ------
        Refused
            If it is none of the signal, older than ``last_step``, of no step of the flight, not
            stamped with that step's time, or breaks a rule.
        """
        message = self.signal.decode(data, last_step)
        if self._is_timed:
            seconds, nanoseconds = message.stamp
            self.check_time(seconds * NS_PER_S + nanoseconds, message.step)
        return message

    def check_time(self, time_ns: int, step: int | None = None) -> None:
        """Check a message's time [ns], and its step if it has one.

        Raises
        ------
        Refused
            If they are none of the flight, or do not belong together.
        """
        if step is not None:
            if not 0 <= step <= self._n_steps:
                raise Refused(f"step {step}; required 0 to {self._n_steps}", "step")
            if time_ns != step * self._period_ns:
                raise Refused(
                    f"stamp of {time_ns} ns at step {step}; required {step * self._period_ns} ns",
                    "time",
                )
        elif not 0 <= time_ns <= self._end_ns:
            raise Refused(f"time of {time_ns} ns; required 0 to {self._end_ns} ns", "time")
