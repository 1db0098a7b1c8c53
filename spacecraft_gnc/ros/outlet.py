"""Publisher of raw messages with flow control."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Final

from rclpy.duration import Duration
from rclpy.publisher import Publisher

_BEAT: Final = 0.05  # [s] wall: how late an end may be noticed
_MOST_UNACKNOWLEDGED: Final = 500  # messages; or half the depth, if that is less


class Outlet:
    """A publisher that does not overrun its reliable readers.

    Parameters
    ----------
    publisher
        Of serialized messages.
    depth
        Of its history: more than that must never be unacknowledged.
    """

    def __init__(self, publisher: Publisher, depth: int) -> None:
        self.count = 0
        self._publisher = publisher
        self._most = max(1, min(depth // 2, _MOST_UNACKNOWLEDGED))
        self._unacknowledged = 0

    @property
    def subscribers(self) -> int:
        """Subscriptions matched."""
        return self._publisher.get_subscription_count()

    @property
    def is_full(self) -> bool:
        """Whether another message could displace one that is not acknowledged."""
        return self._unacknowledged >= self._most

    def publish(self, data: bytes) -> None:
        """Send a serialized message."""
        self._publisher.publish(data)
        self.count += 1
        self._unacknowledged += 1

    def drain(self, patience: float, stopped: Callable[[], bool]) -> bool:
        """Wait for the acknowledgments; return whether they came within ``patience`` [s]."""
        self._unacknowledged = 0
        deadline = time.monotonic() + patience
        while not self._publisher.wait_for_all_acked(Duration(seconds=_BEAT)):
            if stopped() or time.monotonic() >= deadline:
                return False
        return True
