"""Times of the messages of a graph in its bag, and refusal of those that are of no time of it."""

from __future__ import annotations

import struct
from typing import Final

from spacecraft_gnc.recording.stamps import step_of, time_in
from spacecraft_gnc.signals import Refused
from spacecraft_gnc.signals.graph import CLOCK
from spacecraft_gnc.signals.guard import Guard, Window
from spacecraft_gnc.signals.message import NS_PER_S

NOT_YET: Final = -1  # [ns] simulated time before the first state


class BagTimes:
    """Simulated times of recorded messages.

    Parameters
    ----------
    window
        That of the flight.
    is_sealed
        Whether the guards check seals, so that what they open need not be examined again.
    """

    def __init__(self, window: Window, *, is_sealed: bool) -> None:
        self._period, self._end = window.period_ns, window.period_ns * window.n_steps
        self._is_sealed = is_sealed
        self.now = NOT_YET
        """Time of the last state [ns]."""

    def of(self, guard: Guard, data: bytes, latest: int) -> int:
        """Return the time [ns] of an opened message; of one without, that of the last state.

        Parameters
        ----------
        guard
            Of its topic.
        data
            The message.
        latest
            Time of the one before on the topic [ns].

        Raises
        ------
        Refused
            If it is broken, or of a time that cannot be.
        """
        signal, now = guard.signal, max(self.now, 0)
        if signal.is_flat and not (self._is_sealed and signal.sealed):
            signal.read(data)
        if not signal.is_stamped:
            return now
        try:
            stamp = time_in(data)
        except struct.error as error:
            raise Refused(f"{len(data)} bytes without a time stamp", "layout") from error
        if guard.is_open:  # any time will do for the governor
            return stamp if 0 <= stamp <= self._end else now
        guard.check_time(stamp, step_of(data) if signal.is_stepped else None)
        if signal.is_stepped and stamp < latest:
            raise Refused(f"time of {stamp} ns after {latest} ns; required a later one", "step")
        if signal is CLOCK:
            self._check_tick(data, stamp, latest)
        return stamp

    def _check_tick(self, data: bytes, stamp: int, latest: int) -> None:
        """Refuse a tick that is not the next one: who has no key can send it, too."""
        following = latest + self._period if latest >= 0 else 0
        is_skip = following < stamp <= self.now + self._period and stamp % self._period == 0
        if stamp != following and not is_skip:
            raise Refused(f"tick of {stamp} ns after {latest} ns; required the next one", "step")
        instant = divmod(stamp, NS_PER_S)
        if data != CLOCK.encode(instant, 0, [instant]):
            raise Refused(f"{len(data)} bytes; required a tick as the plant sends it", "layout")
