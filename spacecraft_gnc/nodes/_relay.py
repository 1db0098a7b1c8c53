"""Every topic of a graph, its bytes unchanged, to somebody outside ROS."""

from __future__ import annotations

import struct
import time
from collections.abc import Callable
from typing import Final, Protocol

from rclpy.qos import DurabilityPolicy

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.nodes._bag_topics import prefixes
from spacecraft_gnc.nodes._endpoints import TopicInfo
from spacecraft_gnc.nodes._graph import GraphError, GraphView
from spacecraft_gnc.recording.schema_text import InstalledInterfaces, schema_text

_LOOK: Final = 1.0  # [s] wall between two looks for new topics
_SPIN: Final = 0.02  # [s] wall
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
        that of /clock where a node publishes it, else wall time.
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

    def look(self) -> None:
        """Take in topics that are new, once a second."""
        now = time.monotonic()
        if now - self._looked < _LOOK:
            return
        self._looked = now
        for info in self._view.topics():
            if info.publishers and info.name not in self._known:
                self._known.add(info.name)
                self._take_in(info)

    def wait(self) -> None:
        """Handle what arrives for a moment."""
        deadline = time.monotonic() + _SPIN
        self._view.spin_until(lambda: time.monotonic() >= deadline)

    def _take_in(self, info: TopicInfo) -> None:
        kind, name = info.types[0], info.name
        try:
            definition = schema_text(kind, self._interfaces.definition)
            profiles = [end.qos for end in self._view.publishers(name)]
            latched = any(p.durability == DurabilityPolicy.TRANSIENT_LOCAL for p in profiles)
            self._announce(name, kind, definition, latched=latched)
            self._view.subscribe(name, lambda data: self._pass_on(name, data), raw=True)
        except (RecordingError, GraphError):
            return  # not installed, or an action's own: others are shown all the same

    def _pass_on(self, topic: str, data: bytes) -> None:
        if topic == _CLOCK:
            seconds, nanoseconds = _STAMP.unpack_from(data, _STAMP_AT)
            self._simulated = seconds * _NS_PER_S + nanoseconds
        self._send(topic, time.time_ns() if self._simulated is None else self._simulated, data)
