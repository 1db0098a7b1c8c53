"""A look at any live ROS 2 graph: nodes, topics, messages, rates."""

from __future__ import annotations

import importlib
import os
import signal
import time
from collections import deque
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions

from spacecraft_gnc.errors import LaunchError
from spacecraft_gnc.launcher.environment import prepare

if TYPE_CHECKING:
    from typing_extensions import Self

_SPIN = 0.05  # [s] wall
_SETTLE = 1.0  # [s] wall without a change after which discovery counts as complete
_DISCOVERY = 8.0  # [s] wall at most
_DEPTH = 1000


class TopicInfo(NamedTuple):
    """A topic as the graph shows it."""

    name: str
    types: tuple[str, ...]
    publishers: int
    subscribers: int


class Rate(NamedTuple):
    """Arrivals of a topic over a window of wall time."""

    messages: int
    hz: float
    period_min: float
    """[s]"""
    period_max: float
    """[s]"""


class GraphError(LaunchError):
    """The graph has not what was asked for."""


class GraphView:
    """An observer in a graph. Use it as a context manager.

    Parameters
    ----------
    domain_id
        ROS_DOMAIN_ID of the graph.
    """

    def __init__(self, domain_id: int) -> None:
        self.domain_id = domain_id
        prepare(os.environ)
        options = SignalHandlerOptions.NO
        rclpy.init(args=[], domain_id=domain_id, signal_handler_options=options)
        self.node = Node(f"inspect_{os.getpid()}", start_parameter_services=False)
        self._executor = EventsExecutor()
        self._executor.add_node(self.node)
        self._interrupted = False
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
            info = TopicInfo(name, tuple(types), *self._counts(name))
            if info.publishers or info.subscribers:
                found.append(info)
        return sorted(found)

    def _counts(self, name: str) -> tuple[int, int]:
        own = self.node.get_name()
        publishers = self.node.get_publishers_info_by_topic(name)
        subscribers = self.node.get_subscriptions_info_by_topic(name)
        return (
            sum(info.node_name != own for info in publishers),
            sum(info.node_name != own for info in subscribers),
        )

    def subscribe(self, topic: str, callback: Callable[[Any], None], *, raw: bool = False) -> str:
        """Listen to a topic that is published now; return its full name.

        Raises
        ------
        GraphError
            There is no such topic, or nobody publishes on it.
        """
        full_name = self.node.resolve_topic_name(topic)
        if not self.spin_until(lambda: self._counts(full_name)[0] > 0, _SETTLE):
            self.discover()
        info = self._find(topic)
        module, _, leaf = info.types[0].partition("/msg/")
        try:
            message_type = getattr(importlib.import_module(f"{module}.msg"), leaf)
        except (ImportError, AttributeError) as error:
            raise GraphError(
                f"{info.name}: received messages of type {info.types[0]}; required a type that is "
                f"installed; install the package {module}"
            ) from error
        qos = _matching(self.node.get_publishers_info_by_topic(info.name))
        self.node.create_subscription(message_type, info.name, callback, qos, raw=raw)
        return info.name

    def _find(self, topic: str) -> TopicInfo:
        full_name = self.node.resolve_topic_name(topic)
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

    def measure(self, topic: str, window: float) -> Iterator[Rate]:
        """Yield the rate of a topic once per ``window`` seconds of wall time, until Ctrl-C."""
        arrivals: deque[float] = deque()
        self.subscribe(topic, lambda _: arrivals.append(time.monotonic()), raw=True)
        while True:
            begun = time.monotonic()
            arrivals.clear()
            self.spin_until(_elapsed(begun + window))
            if self._interrupted:
                return
            yield _rate(np.array(arrivals), time.monotonic() - begun)


def _elapsed(deadline: float) -> Callable[[], bool]:
    return lambda: time.monotonic() >= deadline


def _rate(arrivals: np.ndarray, duration: float) -> Rate:
    periods = np.diff(arrivals)
    if not periods.size:
        return Rate(len(arrivals), len(arrivals) / duration, np.nan, np.nan)
    hz = 1.0 / float(periods.mean())
    return Rate(len(arrivals), hz, float(periods.min()), float(periods.max()))


def _matching(publishers: list[Any]) -> QoSProfile:
    """Return the most demanding profile that every publisher can serve."""
    qos = QoSProfile(depth=_DEPTH)
    profiles = [info.qos_profile for info in publishers]
    if any(p.reliability != ReliabilityPolicy.RELIABLE for p in profiles):
        qos.reliability = ReliabilityPolicy.BEST_EFFORT
    if all(p.durability == DurabilityPolicy.TRANSIENT_LOCAL for p in profiles):
        qos.durability = DurabilityPolicy.TRANSIENT_LOCAL
    return qos
