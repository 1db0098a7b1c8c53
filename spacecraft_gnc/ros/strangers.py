"""Strangers: who speaks on topics of a flight, or answers for its nodes, and is none of them."""

from __future__ import annotations

import math
import time
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Final, NamedTuple

from rclpy.node import Node

from spacecraft_gnc.ros.endpoints import Endpoint
from spacecraft_gnc.ros.graph_of import members_of, signals_of
from spacecraft_gnc.scenario import Fleet
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.signals.graph import DIAGNOSTICS, WALL_STATUS
from spacecraft_gnc.signals.members import Place

_ROUNDS: Final = 10  # looks in which every topic is looked at once, if there are few of them
_MOST_TOPICS: Final = 25  # of one look: each takes 0.1 ms
_UNKNOWN: Final = "_NODE_NAME_UNKNOWN_"  # how rmw calls an endpoint whose node it has not found yet
_PATIENCE: Final = 5.0  # [s] wall until it must have a name

Speakers = Mapping[str, frozenset[str]]
"""Full names of the nodes that may publish on a topic, by its full name."""


class Stranger(NamedTuple):
    """A publisher, or a server, that is none of the flight's nodes."""

    topic: str
    """Or service."""
    node: str
    """Full name; empty: not known."""

    def __str__(self) -> str:
        """Return the topic, and who it is."""
        return f"{self.topic}: {self.node or 'somebody without a name'}"


def speakers_of(fleet: Fleet) -> Speakers:
    """Return who may publish on the topics of a graph.

    Two kinds are left out: what users publish (nobody of the graph does), and ``/diagnostics``,
    which all ROS nodes share.
    """
    members = members_of(fleet)
    speakers = {}
    for place, signal in _topics(fleet):
        names = members.speakers(signal, place.agent)
        if signal.publishers and signal is not DIAGNOSTICS:
            speakers[place.topic(signal)] = frozenset(f"/{name}" for name in names)
    return speakers


def _topics(fleet: Fleet) -> Iterator[tuple[Place, Signal]]:
    """Yield each signal and where it stands; what each controller tells is there for each."""
    for space, signal in signals_of(fleet):
        if signal is not WALL_STATUS:
            yield Place("", space), signal
    for agent in fleet.agents:
        for space in fleet.craft_of(agent) or (agent,):
            yield Place("", space), WALL_STATUS


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
    services
        Full name of the node that has each service, by the full name of the service. Which node a
        server belongs to is not known: there may be one in each life of the node.
    """

    def __init__(
        self, node: Node, speakers: Speakers, services: Mapping[str, str] = MappingProxyType({})
    ) -> None:
        self._node = node
        self._speakers = speakers
        self._services = services
        self._topics = [*speakers, *services]
        self._next = 0
        self._lives = Counter(frozenset(services.values()).union(*speakers.values()))
        self._seen: defaultdict[tuple[str, str], set[bytes]] = defaultdict(set)
        self._nameless: dict[bytes, float] = {}
        self._names: dict[bytes, str] = {}  # rmw has none of who stood still
        self._found: dict[Stranger, None] = {}

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

    def _look_at(self, topic: str) -> None:
        if topic in self._services:
            if self._node.count_services(topic) > self._lives[self._services[topic]]:
                self._found[Stranger(topic, "")] = None
            return
        for info in self._node.get_publishers_info_by_topic(topic):
            gid = bytes(info.endpoint_gid)
            name = Endpoint.of(info).node
            if info.node_name == _UNKNOWN:
                name = self._names.get(gid, "")
                if not name and not self._is_overdue(gid):
                    continue
            self._names[gid] = name
            endpoints = self._seen[topic, name]
            endpoints.add(gid)
            if name not in self._speakers[topic] or len(endpoints) > self._lives[name]:
                self._found[Stranger(topic, name)] = None

    def _is_overdue(self, gid: bytes) -> bool:
        now = time.monotonic()
        return now - self._nameless.setdefault(gid, now) > _PATIENCE
