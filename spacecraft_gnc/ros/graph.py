"""Observer of a live ROS 2 graph: nodes, topics, messages."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from spacecraft_gnc.errors import LaunchError
from spacecraft_gnc.launcher.environment import prepare
from spacecraft_gnc.ros.endpoints import (
    Endpoint,
    TopicInfo,
    full_topic_name,
    matching,
    message_type,
)
from spacecraft_gnc.signals.seal import without_seal

if TYPE_CHECKING:
    from typing_extensions import Self

_SPIN = 0.05  # [s] wall
_SETTLE = 1.0  # [s] wall without a change after which discovery counts as complete
_DISCOVERY = 8.0  # [s] wall at most


class GraphError(LaunchError):
    """The graph has not what was asked for."""


class GraphView:
    """An observer in a graph. Use it as a context manager.

    Parameters
    ----------
    domain_id
        ROS_DOMAIN_ID of the graph.
    take_interrupts
        Whether Ctrl-C ends what is awaited here; otherwise the owner deals with it.
    """

    def __init__(self, domain_id: int, *, take_interrupts: bool = True) -> None:
        self.domain_id = domain_id
        prepare(os.environ)
        options = SignalHandlerOptions.NO
        rclpy.init(args=[], domain_id=domain_id, signal_handler_options=options)
        self.node = Node(f"inspect_{os.getpid()}", start_parameter_services=False)
        self._executor = EventsExecutor()
        self._executor.add_node(self.node)
        self._interrupted = False
        if take_interrupts:
            signal.signal(signal.SIGINT, self._interrupt)

    def __enter__(self) -> Self:
        """Return the view."""
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the graph."""
        self._executor.remove_node(self.node)
        del self._executor  # it holds our callbacks, and we it: no garbage collector sees that
        self.node.destroy_node()
        rclpy.try_shutdown()

    def _interrupt(self, *_: Any) -> None:
        self._interrupted = True

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C was pressed."""
        return self._interrupted

    def forgive_interrupt(self) -> None:
        """Let Ctrl-C be noticed anew."""
        self._interrupted = False

    def spin_until(self, done: Callable[[], bool], patience: float = np.inf) -> bool:
        """Handle what arrives until ``done``; return False on Ctrl-C or out of patience [s]."""
        deadline = time.monotonic() + patience
        while not done():
            if self._interrupted or time.monotonic() > deadline:
                return False
            self._executor.spin_once(timeout_sec=_SPIN)
        return True

    def discover(self) -> None:
        """Wait until the graph has shown itself: nothing new for a second."""
        seen: Any = None
        changed = time.monotonic()

        def settled() -> bool:
            nonlocal seen, changed
            now = (self.nodes(), self.topics())
            if now != seen:
                seen, changed = now, time.monotonic()
            return bool(now[0]) and time.monotonic() - changed > _SETTLE

        self.spin_until(settled, _DISCOVERY)
        self.raise_interrupt()

    def raise_interrupt(self) -> None:
        """Raise KeyboardInterrupt after Ctrl-C: what was awaited is not there, nor missing."""
        if self._interrupted:
            raise KeyboardInterrupt

    def nodes(self) -> list[str]:
        """Full names of all nodes but this observer."""
        own = self.node.get_fully_qualified_name()
        pairs = self.node.get_node_names_and_namespaces()
        names = (f"{space.rstrip('/')}/{name}" for name, space in pairs)
        return sorted(name for name in names if name != own)

    def topics(self) -> list[TopicInfo]:
        """Topics that anybody but this observer has."""
        found = []
        for name, types in self.node.get_topic_names_and_types():
            counts = len(self.publishers(name)), len(self.subscribers(name))
            info = TopicInfo(name, tuple(types), *counts)
            if info.publishers or info.subscribers:
                found.append(info)
        return sorted(found)

    def subscribe(self, topic: str, callback: Callable[[Any], None], *, raw: bool = False) -> str:
        """Listen to a topic that is published now; return its full name.

        Raises
        ------
        GraphError
            There is no such topic, or nobody publishes on it.
        """
        info = self.find_topic(topic)
        qos = matching([end.qos for end in self.publishers(info.name)])
        try:
            kind = message_type(info.types[0])
            if raw:
                hear(self.node, kind, info.name, callback, qos)
            else:
                self.node.create_subscription(kind, info.name, callback, qos)
        except ImportError as error:  # of the type, or of one that it nests
            package = (error.name or info.types[0]).partition("/")[0].partition(".")[0]
            raise GraphError(
                f"{info.name}: received messages of type {info.types[0]}; required a type that is "
                f"installed; install the package {package}"
            ) from error
        return info.name

    def publishers(self, full_name: str) -> list[Endpoint]:
        """Who publishes on a topic, with the profiles they offer."""
        return self._ends(self.node.get_publishers_info_by_topic(full_name))

    def subscribers(self, full_name: str) -> list[Endpoint]:
        """Who but this observer listens to a topic, with the profiles they ask for."""
        return self._ends(self.node.get_subscriptions_info_by_topic(full_name))

    def _ends(self, found: Sequence[Any]) -> list[Endpoint]:
        own = self.node.get_name()
        return sorted(Endpoint.of(info) for info in found if info.node_name != own)

    def find_topic(self, topic: str) -> TopicInfo:
        """Return a topic that somebody publishes on, and wait a little for it.

        Raises
        ------
        TopicNameRefused
            No topic can have that name.
        GraphError
            There is no such topic, or nobody publishes on it.
        """
        full_name = full_topic_name(self.node, topic)
        if not self.spin_until(lambda: bool(self.publishers(full_name)), _SETTLE):
            self.discover()
        return self._find(full_name)

    def find_node(self, name: str) -> str:
        """Return the full name of a node, given by it or by its last part alone.

        Raises
        ------
        GraphError
            There is no such node, or there are several.
        """
        found: list[str] = []

        def is_there() -> bool:
            found[:] = [n for n in self.nodes() if n in (name, f"/{name}")]
            return bool(found)

        if not self.spin_until(is_there, _SETTLE):
            self.discover()
            if not is_there() and not name.startswith("/"):
                found[:] = [n for n in self.nodes() if n.endswith(f"/{name}")]
        if len(found) == 1:
            return found[0]
        known = ", ".join(found or self.nodes()) or "none at all"
        problem = "several nodes of that name" if found else "no such node"
        raise GraphError(
            f"{name}: {problem} on ROS_DOMAIN_ID={self.domain_id}; required one of {known}; "
            "check name and --domain-id"
        )

    def _find(self, full_name: str) -> TopicInfo:
        topics = {info.name: info for info in self.topics()}
        info = topics.get(full_name)
        where = f"ROS_DOMAIN_ID={self.domain_id}"
        if info is None:
            known = ", ".join(topics) or "none at all"
            raise GraphError(
                f"{full_name}: no such topic on {where}; required one of the live graph ({known}); "
                "check name and --domain-id"
            )
        if not info.publishers:
            raise GraphError(
                f"{full_name}: nobody publishes on it on {where}; required a publisher; start the "
                "node that has one"
            )
        return info


def hear(node: Node, kind: Any, topic: str, take: Callable[[bytes], None], qos: Any) -> Any:
    """Listen to the serialized messages of a topic, whoever sends them; seals are left out."""
    return node.create_subscription(
        kind, topic, lambda data: take(without_seal(data)), qos, raw=True
    )
