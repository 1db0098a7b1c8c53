"""Roll call: nobody starts before everybody hears everybody, so that no first message is lost."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Any

from rclpy.publisher import Publisher
from rclpy.subscription import Subscription

from spacecraft_gnc.ros.topics import Topic


class Readiness:
    """Whether every endpoint of a node has found its counterparts.

    A count seen on one side is not enough: the plant waits for this of every node.

    Parameters
    ----------
    present
        Names of the nodes that make up the graph.
    wanted
        Topics that the recorder takes; empty: all.
    """

    def __init__(self, present: Collection[str], wanted: Collection[str]) -> None:
        self._present = frozenset(present)
        self._wanted = tuple(wanted)
        self._missing: dict[str, Callable[[], bool]] = {}

    def expect_subscribers(self, topic: Topic, publisher: Publisher) -> None:
        """Wait for the subscribers of ``topic``."""
        count = topic.expected_subscribers(self._present, self._wanted)
        self._expect(topic, count, publisher.get_subscription_count)

    def expect_publishers(self, topic: Topic, subscription: Subscription) -> None:
        """Wait for the publishers of ``topic``."""
        count = topic.expected_publishers(self._present)
        self._expect(topic, count, subscription.get_publisher_count)

    def _expect(self, topic: Topic, count: int, current: Callable[[], Any]) -> None:
        if count:
            self._missing[topic.name] = lambda: current() >= count

    def missing(self) -> tuple[str, ...]:
        """Topics that still lack a counterpart; one that was complete once stays so."""
        for name, complete in list(self._missing.items()):
            if complete():
                del self._missing[name]
        return tuple(self._missing)
