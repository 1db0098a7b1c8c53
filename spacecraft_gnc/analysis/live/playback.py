"""The clock of a recording that is played: pause, seek, rate."""

from __future__ import annotations

import math
import threading
from typing import Final

from spacecraft_gnc.errors import ParameterError

FASTEST: Final = 1000.0
"""Simulated seconds per wall second."""


class Playback:
    """Simulated time of a recording against wall time, which is handed in.

    Any thread may call it.

    Parameters
    ----------
    start, end
        Simulated time of the recording [s].
    rate
        Simulated seconds per wall second.
    """

    def __init__(self, start: float, end: float, rate: float = 1.0) -> None:
        self.start, self.end = start, end
        self._lock = threading.Lock()
        self._rate = _checked(rate)
        self._at = start
        self._since: float | None = None  # wall time at which it was `_at`; None: paused

    def time(self, wall: float) -> float:
        """Return the simulated time [s] at a wall time [s]."""
        with self._lock:
            return self._time(wall)

    @property
    def rate(self) -> float:
        """Simulated seconds per wall second while it plays."""
        return self._rate

    @property
    def paused(self) -> bool:
        """Whether it was paused."""
        return self._since is None

    def over(self, wall: float) -> bool:
        """Whether the end was reached."""
        return self.time(wall) >= self.end

    def play(self, wall: float) -> None:
        """Go on; from the start where the end was reached."""
        with self._lock:
            at = self._time(wall)
            self._at, self._since = self.start if at >= self.end else at, wall

    def pause(self, wall: float) -> None:
        """Stand still."""
        with self._lock:
            self._at, self._since = self._time(wall), None

    def seek(self, time: float, wall: float) -> None:
        """Go to a simulated time [s]; one outside the recording becomes its nearest end.

        Raises
        ------
        ParameterError
            It is not finite.
        """
        if not math.isfinite(time):
            raise ParameterError(f"seek: received {time}; required a time in seconds; send one")
        with self._lock:
            self._at = min(max(time, self.start), self.end)
            self._since = None if self._since is None else wall

    def set_rate(self, rate: float, wall: float) -> None:
        """Change the rate, and stay where it is.

        Raises
        ------
        ParameterError
            It is no rate.
        """
        checked = _checked(rate)
        with self._lock:
            self._at = self._time(wall)
            self._since = None if self._since is None else wall
            self._rate = checked

    def _time(self, wall: float) -> float:
        if self._since is None:
            return self._at
        return min(self._at + (wall - self._since) * self._rate, self.end)


def _checked(rate: float) -> float:
    if not 0.0 < rate <= FASTEST:
        raise ParameterError(
            f"rate: received {rate}; required more than 0, at most {FASTEST:g}; choose one"
        )
    return rate
