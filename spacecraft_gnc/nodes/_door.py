"""The user's door: how often a governor takes targets, whoever sends them."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from spacecraft_gnc.nodes._node import GncNode

# An operator or a planner sends one to ten targets a second. A governor that looks whether it can
# take a target needs up to a millisecond for that: at this rate 2 % of its time.
_RATE: Final = 20.0  # [1/s] wall
_BURST: Final = 10


class TokenBucket:
    """Bounds a rate: ``burst`` at once, then ``rate`` per second.

    Parameters
    ----------
    rate
        Tokens that come per second [1/s].
    burst
        Tokens that it holds at most; it begins full.
    clock
        Returns the time [s], which never runs backward.
    """

    def __init__(
        self, rate: float, burst: int, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._rate = rate
        self._burst = float(burst)
        self._clock = clock
        self._tokens = self._burst
        self._looked = clock()

    def take(self) -> bool:
        """Take a token, if there is one; return whether there was."""
        now = self._clock()
        self._tokens = min(self._burst, self._tokens + self._rate * (now - self._looked))
        self._looked = now
        if self._tokens < 1.0:
            return False
        self._tokens -= 1.0
        return True


class UsersDoor:
    """Lets targets in, by topic and by action together, at a bounded rate.

    Targets are not sealed: anybody in the domain may send them. What comes too often is refused.

    Parameters
    ----------
    node
        Refuses.
    """

    def __init__(self, node: GncNode) -> None:
        self._node = node
        self._bucket = TokenBucket(_RATE, _BURST)

    def admits(self, name: object) -> bool:
        """Return whether a target may be looked at that came by the topic or action ``name``."""
        if self._bucket.take():
            return True
        self._node.refuse(
            name,
            f"received more than {_RATE:g} targets per second; required {_BURST} at once and "
            f"{_RATE:g} per second at most; send fewer",
            "rate",
        )
        return False
