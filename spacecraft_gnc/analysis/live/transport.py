"""Playback controls (play, pause, seek, rate), safe to use from any thread."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from typing import Final

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.recording.play_clock import PlayClock

FASTEST: Final = 1000.0
"""Simulated seconds per wall second."""


class Transport:
    """Simulated time of a recording, which stands at its start until `begin`.

    Parameters
    ----------
    start, end
        Simulated time of the recording [s].
    rate
        Simulated seconds per wall second.
    clock
        Wall time [s].

    Attributes
    ----------
    jumps
        How often the time jumped: seeks, and returns to the start.
    """

    def __init__(self, start: float, end: float, rate: float, clock: Callable[[], float]) -> None:
        self.start, self.end = start, end
        self.jumps = 0
        self._wall = clock
        self._lock = threading.Lock()
        self._begun = False
        self._clock = PlayClock(_checked(rate), True, start, clock())

    def begin(self) -> None:
        """Start to play, for somebody has come to watch; nothing at a later call."""
        with self._lock:
            if not self._begun:
                self._begun = True
                self._clock.pause(False, self._wall())

    def time(self) -> float:
        """Return the simulated time now [s]."""
        with self._lock:
            return self._time()

    @property
    def rate(self) -> float:
        """Simulated seconds per wall second while it plays."""
        return self._clock.rate

    @property
    def paused(self) -> bool:
        """Whether it was paused."""
        return self._clock.paused

    @property
    def over(self) -> bool:
        """Whether the end was reached."""
        return self.time() >= self.end

    def play(self) -> None:
        """Go on; from the start where the end was reached."""
        with self._lock:
            self._begun = True
            at = self._time()
            if at >= self.end:
                at = self.start
                self.jumps += 1
            self._clock.seek(at, self._wall())
            self._clock.pause(False, self._wall())

    def pause(self) -> None:
        """Stand still."""
        with self._lock:
            self._begun = True
            self._clock.seek(self._time(), self._wall())
            self._clock.pause(True, self._wall())

    def seek(self, time: float) -> None:
        """Go to a simulated time [s]; one outside the recording becomes its nearest end.

        Raises
        ------
        ParameterError
            It is not finite.
        """
        if not math.isfinite(time):
            raise ParameterError(f"seek: received {time}; required a time in seconds; send one")
        with self._lock:
            self._clock.seek(min(max(time, self.start), self.end), self._wall())
            self.jumps += 1

    def set_rate(self, rate: float) -> None:
        """Change the rate, and stay where it is.

        Raises
        ------
        ParameterError
            It is no rate.
        """
        checked = _checked(rate)
        with self._lock:
            self._clock.seek(self._time(), self._wall())
            self._clock.set_rate(checked, self._wall())

    def control(self, action: str, value: float | None) -> None:
        """Do what the page asks for: ``play``, ``pause``, ``seek`` or ``rate``.

        Raises
        ------
        ParameterError
            The action or its value makes no sense.
        """
        if action == "play":
            self.play()
        elif action == "pause":
            self.pause()
        elif action == "seek" and value is not None:
            self.seek(value)
        elif action == "rate" and value is not None:
            self.set_rate(value)
        else:
            raise ParameterError(
                f"action: received {action!r} with value {value}; required play, pause, seek or "
                "rate, the last two with a number; correct it"
            )

    def _time(self) -> float:
        return min(self._clock.position(self._wall()), self.end)


def _checked(rate: float) -> float:
    if not 0.0 < rate <= FASTEST:
        raise ParameterError(
            f"rate: received {rate}; required more than 0, at most {FASTEST:g}; choose one"
        )
    return rate
