"""Clock of a player: wall time to position, with pauses, seeks and rate changes.

No clock is read here: wall time is handed in, so that it is tested without waiting.
"""

from __future__ import annotations

import math


class PlayClock:
    """Position [s] that advances with wall time [s].

    Parameters
    ----------
    rate
        Of the position to wall time; 0: as fast as it goes.
    paused
        Whether it stands.
    position
        Where it begins [s].
    now
        Wall time [s].
    """

    def __init__(self, rate: float, paused: bool, position: float, now: float) -> None:
        self._rate = rate
        self._paused = paused
        self._position = position
        self._since = now

    @property
    def paused(self) -> bool:
        """Whether it stands."""
        return self._paused

    @property
    def rate(self) -> float:
        """Of the position to wall time; 0: as fast as it goes."""
        return self._rate

    def position(self, now: float) -> float:
        """Return where it is at wall time ``now`` [s]; unpaced, where the last message was."""
        if self._paused or not self._rate:
            return self._position
        return self._position + (now - self._since) * self._rate

    def wait(self, due: float, now: float) -> float:
        """Return the wall time [s] from ``now`` until a position is reached; infinite: never."""
        if self._paused:
            return math.inf
        if not self._rate:
            return 0.0
        return max(0.0, (due - self.position(now)) / self._rate)

    def passed(self, position: float) -> None:
        """Take note of a message played: without a rate it is what moves the position."""
        if not self._rate:
            self._position = position

    def seek(self, position: float, now: float) -> None:
        """Go to a position [s]."""
        self._position, self._since = position, now

    def pause(self, paused: bool, now: float) -> None:
        """Stand, or go on."""
        self.seek(self.position(now), now)
        self._paused = paused

    def set_rate(self, rate: float, now: float) -> None:
        """Change the rate from here on."""
        self.seek(self.position(now), now)
        self._rate = rate
