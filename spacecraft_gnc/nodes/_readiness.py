"""Readiness: the flight starts once all endpoints are matched, so that no first message is lost."""

from __future__ import annotations

from collections.abc import Callable


class Readiness:
    """Whether every endpoint of a node has found its counterparts.

    A count seen on one side is not enough: the plant waits for this of every node.
    """

    def __init__(self) -> None:
        self._missing: dict[str, Callable[[], bool]] = {}

    def expect(self, topic: str, count: int, current: Callable[[], int]) -> None:
        """Wait until ``current`` counterparts of a topic are ``count``."""
        if count:
            self._missing[topic] = lambda: current() >= count

    def missing(self) -> tuple[str, ...]:
        """Topics that still lack a counterpart; one that was complete once stays so."""
        for name, complete in list(self._missing.items()):
            if complete():
                del self._missing[name]
        return tuple(self._missing)
