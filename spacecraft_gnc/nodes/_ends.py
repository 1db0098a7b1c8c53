"""What a node publishes and hears, until it is cleaned up, and whether its peers are there."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any, ClassVar, NamedTuple

from rclpy.clock import Clock, ClockType
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.lifecycle import LifecycleNode
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.subscription import Subscription
from rclpy.timer import Timer

from spacecraft_gnc.nodes._clock import SimulatedClock
from spacecraft_gnc.nodes._exchange import HANDED_OVER, Exchange
from spacecraft_gnc.nodes._losses import SequenceWatch, with_info
from spacecraft_gnc.nodes._readiness import Readiness
from spacecraft_gnc.ros.endpoints import message_type
from spacecraft_gnc.ros.qos import ros_qos
from spacecraft_gnc.scenario import Scenario
from spacecraft_gnc.signals import Refused, Signal
from spacecraft_gnc.signals.guard import Guard, Window
from spacecraft_gnc.signals.members import Members, Place
from spacecraft_gnc.signals.message import Stamp
from spacecraft_gnc.signals.qos import QosProfile
from spacecraft_gnc.signals.seal import key_in, sealer

_ACKNOWLEDGED_WITHIN = 1.0  # [s] wall time granted to slow readers


class Outlet(NamedTuple):
    """A topic that a node publishes on."""

    publish: Callable[[bytes], None]
    """Sends a serialized message, sealed."""
    publisher: Publisher


class NodeWithEnds(LifecycleNode):
    """A lifecycle node whose endpoints are those of signals.

    What it publishes it seals, and what it hears passes a guard, if a launcher gave it a key.

    Parameters
    ----------
    name
        Of the node.
    namespace
        Of the node; None: that of its process.
    """

    members: Members
    """Nodes of the graph."""
    place: Place
    """Where this one stands in it."""
    window: Window
    """Simulated time of the flight."""
    ROLE: ClassVar[str]
    """Section of the scenario, and the node's default name."""
    scenario: Scenario
    """That of this node's agent; of the first one where the node serves all."""

    def __init__(self, name: str, namespace: str | None) -> None:
        simulated = [Parameter("use_sim_time", value=True)]
        super().__init__(name, namespace=namespace, parameter_overrides=simulated)
        self.steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.key = key_in(os.environ) or b""
        """Of the flight; empty: no launcher gave one, and nothing is sealed."""
        self.exchange: Exchange | None = None
        """With the other nodes of this process; None: there are none."""
        self._simulated = SimulatedClock(self)
        self._resources = ExitStack()
        self._open_publishers: list[Publisher] = []
        self._readiness: Readiness | None = None

    def on_match(self) -> None:
        """Notice that an endpoint was matched."""

    def refuse(self, topic: object, reason: str, kind: str = "values") -> None:
        """Notice that a message or a request was rejected."""

    def fail(self, error: Exception) -> None:
        """End the node because of ``error``."""

    def keep_time(self, stamp: Stamp, step: int) -> None:
        """Take simulated time from a state; after the last one there is no step to make."""
        if step < self.window.n_steps:
            self._simulated.set(stamp)

    def expect_peers(self) -> None:
        """Wait for the counterparts of the endpoints that are opened from here on."""
        self._readiness = Readiness()

    def missing(self) -> tuple[str, ...]:
        """Topics that still lack a counterpart."""
        return () if self._readiness is None else self._readiness.missing()

    def advertise(self, signal: Signal, space: str | None = None) -> Outlet:
        """Publish a signal, where this node stands or in the namespace of another agent or craft.

        The endpoint lives until clean-up.
        """
        place = self.place if space is None else self.place.of_space(space)
        topic = place.topic(signal)
        publisher = self.create_publisher(
            message_type(signal.type),
            topic,
            ros_qos(signal.qos),
            event_callbacks=PublisherEventCallbacks(matched=self._on_match),
        )
        self.on_close(self.destroy_publisher, publisher)
        self._open_publishers.append(publisher)
        count = self.members.subscribers(signal, place.space(signal))
        self._expect(place, signal, count, publisher.get_subscription_count)
        publish: Callable[[bytes], None] = publisher.publish
        if self.key and signal.sealed:
            seal = sealer(self.key, topic, self.get_fully_qualified_name())

            def publish(data: bytes) -> None:
                publisher.publish(seal(data))

        if self.exchange is not None and not signal.is_latched:
            # That of the handle, because it is asked for each message: a third of the time.
            publish = self.exchange.outlet(topic, publish, publisher.handle.get_subscription_count)
        return Outlet(publish, publisher)

    def listen(
        self,
        signal: Signal,
        callback: Callable[..., None],
        space: str | None = None,
        *,
        qos: QosProfile | None = None,
        watch: SequenceWatch | None = None,
    ) -> Guard:
        """Receive the serialized messages of a signal: ``callback(data)``; where, as `advertise`.

        With a ``watch`` for losses the callback gets the info too: ``callback(data, info)``. What
        the guard does not open, or the callback refuses by `Refused`, is counted and reported.
        """
        place = self.place if space is None else self.place.of_space(space)
        topic, name = place.topic(signal), place.within_graph(signal)
        guard = Guard(signal, topic, self.key, self.window)

        def on_message(data: bytes, *info: Any) -> None:
            try:
                callback(guard.open(data), *info)
            except Refused as refusal:
                self.refuse(name, str(refusal), refusal.kind)

        told = () if watch is None else (HANDED_OVER,)

        def on_handed_over(data: bytes) -> None:
            try:
                callback(data, *told)
            except Refused as refusal:
                self.refuse(name, str(refusal), refusal.kind)

        if self.exchange is not None and not signal.is_latched:
            self._resources.enter_context(self.exchange.reading(topic, on_handed_over))
        kind, profile = message_type(signal.type), ros_qos(qos or signal.qos)
        subscription = self.subscribe(topic, kind, profile, on_message, watch)
        count = self.members.publishers(signal, place.space(signal))
        self._expect(place, signal, count, subscription.get_publisher_count)
        return guard

    def subscribe(
        self,
        topic: str,
        kind: Any,
        qos: Any,
        callback: Callable[..., None],
        watch: SequenceWatch | None = None,
    ) -> Subscription:
        """Receive the serialized messages of any topic, as `listen` does."""
        callbacks = SubscriptionEventCallbacks(matched=self._on_match)
        if watch is not None:
            callback = with_info(callback)
            callbacks.matched = watch.before(self._on_match)
        subscription = self.create_subscription(
            kind, topic, callback, qos, event_callbacks=callbacks, raw=True
        )
        self.on_close(self.destroy_subscription, subscription)
        return subscription

    def _expect(self, place: Place, signal: Signal, count: int, current: Callable[[], int]) -> None:
        if self._readiness is not None:
            self._readiness.expect(place.within_graph(signal), count, current)

    def every(self, wall_period: float, callback: Callable[[], None]) -> Timer:
        """Call back every ``wall_period`` seconds of wall time."""
        return self.own(self.create_timer(wall_period, callback, clock=self.steady))

    def own(self, timer: Timer) -> Timer:
        """Destroy ``timer`` on clean-up."""
        self.on_close(self.destroy_timer, timer)
        return timer

    def on_close(self, give_back: Callable[..., Any], *arguments: Any) -> None:
        """Call ``give_back(*arguments)`` on clean-up, the latest first."""
        self._resources.callback(give_back, *arguments)

    def await_readers(self) -> None:
        """Wait a little until what was published is acknowledged, of all publishers together."""
        deadline = time.monotonic() + _ACKNOWLEDGED_WITHIN
        for publisher in self._open_publishers:
            left = max(deadline - time.monotonic(), 0.0)
            publisher.wait_for_all_acked(Duration(seconds=left))

    def close(self) -> None:
        """Give everything back."""
        self._open_publishers.clear()
        self._readiness = None
        self._resources.close()

    def _on_match(self, _: Any) -> None:
        self.on_match()
