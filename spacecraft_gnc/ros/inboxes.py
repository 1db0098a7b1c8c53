"""Latest messages of some topics, and their rates."""

from __future__ import annotations

import math
from typing import Final

_RATE_WINDOW: Final = 1.0  # [s] wall
_MOST_STEPS: Final = 20000  # of a topic that wait to be sampled


class Inbox:
    """The last messages of one topic, by control step."""

    def __init__(self) -> None:
        self.messages: dict[int, bytes] = {}
        self.last = b""
        self.count = 0

    def put(self, step: int, data: bytes) -> None:
        """Take in the message of a step."""
        self.last = data
        self.count += 1
        if len(self.messages) < _MOST_STEPS:
            self.messages[step] = data

    def forget_before(self, step: int) -> None:
        """Drop the messages of earlier steps."""
        for old in [known for known in self.messages if known < step]:
            del self.messages[old]


class Rates:
    """Messages per wall second of each topic, over a window of its own."""

    def __init__(self, inboxes: dict[str, Inbox]) -> None:
        self._inboxes = inboxes
        self._since = -math.inf
        self._counts = dict.fromkeys(inboxes, 0)
        self._rates: dict[str, float] = {}

    def at(self, now: float) -> dict[str, float]:
        """Return the rates of the last whole window."""
        duration = now - self._since
        if duration >= _RATE_WINDOW:
            counts = {topic: inbox.count for topic, inbox in self._inboxes.items()}
            if math.isfinite(duration):
                new = {topic: counts[topic] - self._counts.get(topic, 0) for topic in counts}
                self._rates = {topic: n / duration for topic, n in new.items()}
            self._since, self._counts = now, counts
        return self._rates
