"""Relay of every topic of a graph, bytes unchanged, to a client outside ROS."""

from __future__ import annotations

import math
import struct
import time
from collections.abc import Callable
from typing import Final, Protocol

from rclpy.qos import DurabilityPolicy

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording.schema_text import InstalledInterfaces, schema_text
from spacecraft_gnc.ros.bag_topics import prefixes
from spacecraft_gnc.ros.endpoints import TopicInfo
from spacecraft_gnc.ros.graph import GraphError, GraphView

_LOOK: Final = 1.0  # [s] wall between two looks for new topics
_SPIN: Final = 0.02  # [s] wall
_PATIENCE: Final = 1.0  # [s] wall, for the first tick of a clock
_CLOCK: Final = "/clock"
_STAMP: Final = struct.Struct("<iI")
_STAMP_AT: Final = 4  # after the encapsulation header
_NS_PER_S: Final = 1_000_000_000


class Announce(Protocol):
    """Called once for each topic, before its messages."""

    def __call__(self, topic: str, type_name: str, definition: str, *, latched: bool) -> None:
        """Offer a topic."""


class Relay:
    """Listens to everything that is published in a graph, now or later.

    Parameters
    ----------
    view
        The graph.
    announce, send
        Called for each new topic, and with topic, time [ns] and bytes of each message. The time is
        that of /clock where a node publishes it, else wall time. Messages that come before the
        first tick wait for it, a second at most: two kinds of time would be decades apart.
    """

    def __init__(
        self, view: GraphView, announce: Announce, send: Callable[[str, int, bytes], None]
    ) -> None:
        self._view = view
        self._announce = announce
        self._send = send
        self._interfaces = InstalledInterfaces(prefixes())
        self._known: set[str] = set()
        self._looked = -_LOOK
        self._simulated: int | None = None
        self._clock_due = -math.inf  # [s] wall; no clock is waited for after it
        self._held: list[tuple[str, bytes]] = []

    def look(self) -> None:
        """Take in topics that are new, once a second."""
        now = time.monotonic()
        if now - self._looked < _LOOK:
            return
        self._looked = now
        published = (info for info in self._view.topics() if info.publishers)
        new = [info for info in published if info.name not in self._known]
        if any(info.name == _CLOCK for info in new):
            self._clock_due = now + _PATIENCE
        for info in new:
            self._known.add(info.name)
            self._take_in(info)

    def wait(self) -> None:
        """Handle what arrives for a moment."""
        deadline = time.monotonic() + _SPIN
        self._view.spin_until(lambda: time.monotonic() >= deadline)
        self._let_go()

    def _take_in(self, info: TopicInfo) -> None:
        kind, name = info.types[0], info.name
        try:
            definition = schema_text(kind, self._interfaces.definition)
            profiles = [end.qos for end in self._view.publishers(name)]
            latched = any(p.durability == DurabilityPolicy.TRANSIENT_LOCAL for p in profiles)
            self._announce(name, kind, definition, latched=latched)
            self._view.subscribe(name, lambda data: self._take(name, data), raw=True)
        except (RecordingError, GraphError):
            return  # not installed, or an action's own: others are shown all the same

    def _take(self, topic: str, data: bytes) -> None:
        if topic == _CLOCK:
            seconds, nanoseconds = _STAMP.unpack_from(data, _STAMP_AT)
            self._simulated = seconds * _NS_PER_S + nanoseconds
        self._held.append((topic, data))
        self._let_go()

    def _let_go(self) -> None:
        if self._simulated is None and time.monotonic() < self._clock_due:
            return
        held, self._held = self._held, []
        for topic, data in held:
            self._send(topic, time.time_ns() if self._simulated is None else self._simulated, data)
