"""Strangers: publishers on topics of a flight that are none of its nodes."""

from __future__ import annotations

import math
import time
from collections import Counter, defaultdict
from collections.abc import Mapping
from typing import Final, NamedTuple

from rclpy.node import Node

from spacecraft_gnc.ros.endpoints import Endpoint
from spacecraft_gnc.ros.graph_of import members_of, signals_of
from spacecraft_gnc.scenario import Fleet
from spacecraft_gnc.signals.graph import DIAGNOSTICS
from spacecraft_gnc.signals.members import Place

_ROUNDS: Final = 10  # looks in which every topic is looked at once, if there are few of them
_MOST_TOPICS: Final = 25  # of one look: each takes 0.1 ms
_UNKNOWN: Final = "_NODE_NAME_UNKNOWN_"  # how rmw calls an endpoint whose node it has not found yet
_PATIENCE: Final = 5.0  # [s] wall until it must have a name

Speakers = Mapping[str, frozenset[str]]
"""Full names of the nodes that may publish on a topic, by its full name."""


class Stranger(NamedTuple):
    """A publisher that is none of the flight's nodes."""

    topic: str
    node: str
    """Full name; empty: not known."""

    def __str__(self) -> str:
        """Return the topic, and who publishes on it."""
        return f"{self.topic}: {self.node or 'somebody without a name'}"


def speakers_of(fleet: Fleet) -> Speakers:
    """Return who may publish on the topics of a graph.

    Two kinds are left out: what users publish (nobody of the graph does), and ``/diagnostics``,
    which all ROS nodes share.
    """
    members = members_of(fleet)
    return {
        Place("", space).topic(signal): frozenset(
            f"/{name}" for name in members.speakers(signal, space)
        )
        for space, signal in signals_of(fleet)
        if signal.publishers and signal is not DIAGNOSTICS
    }


class StrangerWatch:
    """Looks for strangers, at a few topics at a time.

    A name proves nothing: who takes that of a node of the flight is found by its endpoint, which is
    one more than the lives of that node.

    Parameters
    ----------
    node
        Sees the graph.
    speakers
        Who may publish.
    """

    def __init__(self, node: Node, speakers: Speakers) -> None:
        self._node = node
        self._speakers = speakers
        self._topics = list(speakers)
        self._next = 0
        self._lives = Counter(frozenset().union(*speakers.values()))
        self._seen: defaultdict[tuple[str, str], set[bytes]] = defaultdict(set)
        self._nameless: dict[bytes, float] = {}
        self._found: dict[Stranger, None] = {}
        self._news: list[Stranger] = []

    @property
    def found(self) -> tuple[Stranger, ...]:
        """All strangers so far."""
        return tuple(self._found)

    def admit(self, name: str) -> None:
        """Expect another life of a node of the flight, of which the full name is given."""
        self._lives[name] += 1

    def look(self) -> None:
        """Look at the next few topics."""
        count = min(math.ceil(len(self._topics) / _ROUNDS), _MOST_TOPICS)
        for _ in range(count):
            self._look_at(self._topics[self._next])
            self._next = (self._next + 1) % len(self._topics)

    def look_everywhere(self) -> None:
        """Look at all topics."""
        for topic in self._topics:
            self._look_at(topic)

    def take_news(self) -> list[Stranger]:
        """Return the strangers found since it was last asked."""
        news, self._news = self._news, []
        return news

    def _look_at(self, topic: str) -> None:
        for info in self._node.get_publishers_info_by_topic(topic):
            gid = bytes(info.endpoint_gid)
            name = Endpoint.of(info).node
            if info.node_name == _UNKNOWN:
                if not self._is_overdue(gid):
                    continue
                name = ""
            endpoints = self._seen[topic, name]
            endpoints.add(gid)
            if name not in self._speakers[topic] or len(endpoints) > self._lives[name]:
                self._report(Stranger(topic, name))

    def _is_overdue(self, gid: bytes) -> bool:
        now = time.monotonic()
        return now - self._nameless.setdefault(gid, now) > _PATIENCE

    def _report(self, stranger: Stranger) -> None:
        if stranger not in self._found:
            self._found[stranger] = None
            self._news.append(stranger)
