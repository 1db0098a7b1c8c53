"""ROS 2 node of the launcher: drives life cycles and listens for progress."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from spacecraft_gnc.launcher.environment import prepare
from spacecraft_gnc.ros.endpoints import message_type
from spacecraft_gnc.ros.managed import SERVICES, Managed, Stage
from spacecraft_gnc.ros.qos import ros_qos
from spacecraft_gnc.ros.strangers import Stranger, StrangerWatch, speakers_of
from spacecraft_gnc.ros.told import Progress, Told
from spacecraft_gnc.scenario import Fleet
from spacecraft_gnc.signals import Refused, Signal
from spacecraft_gnc.signals.graph import (
    CONTROLLER,
    DIAGNOSTICS,
    PLANT,
    WALL_STATUS,
    WALL_TIMING,
)
from spacecraft_gnc.signals.guard import Guard, Window
from spacecraft_gnc.signals.members import Place, role_of, space_of
from spacecraft_gnc.signals.message import period_ns

if TYPE_CHECKING:
    from typing_extensions import Self

_RCLError = rclpy_implementation.RCLError  # have no public names
_RMWError = rclpy_implementation.RMWError


class Supervisor:
    """Brings nodes to life and knows how they fare. Use it as a context manager.

    Parameters
    ----------
    names
        Nodes to look after, relative to the root namespace.
    fleet
        What flies: it tells who may publish on which topic.
    domain_id
        ROS_DOMAIN_ID of the graph.
    key
        Of the flight: what its nodes tell is sealed with it.
    """

    def __init__(
        self, names: Sequence[str], fleet: Fleet, domain_id: int, key: bytes = b""
    ) -> None:
        prepare(os.environ)
        options = SignalHandlerOptions.NO
        rclpy.init(args=[], domain_id=domain_id, signal_handler_options=options)
        self._node = Node(f"launcher_{os.getpid()}", start_parameter_services=False)
        self._executor = EventsExecutor()
        self._executor.add_node(self._node)
        self._nodes = {name: Managed(self._node, name) for name in names}
        self._is_up = False
        self._key = key
        self._window = Window(period_ns(fleet.leading.period), fleet.leading.n_steps)
        self._told = Told()
        services = {f"/{name}/{service}": f"/{name}" for name in names for service in SERVICES}
        self._strangers = StrangerWatch(self._node, speakers_of(fleet), services)
        self._listen(WALL_TIMING, "", self._told.timing)
        for space in dict.fromkeys(space_of(n) for n in names if role_of(n) == CONTROLLER):
            self._listen(WALL_STATUS, space, partial(self._told.status, space))
        self._listen(DIAGNOSTICS, "", self._told.diagnostics)

    def _listen(self, signal: Signal, space: str, take: Callable[[bytes], None]) -> None:
        topic = Place("", space).topic(signal)
        guard = Guard(signal, topic, self._key, self._window)
        callback = self._told.guarded(guard, take)
        kind, qos = message_type(signal.type), ros_qos(signal.qos)
        self._node.create_subscription(kind, topic, callback, qos, raw=True)

    def __enter__(self) -> Self:
        """Return the supervisor."""
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the graph."""
        self._executor.remove_node(self._node)
        del self._executor  # it holds our callbacks, and we it: no garbage collector sees that
        self._node.destroy_node()
        rclpy.try_shutdown()

    def spin(self, wall_time: float) -> None:
        """Handle what arrives for about ``wall_time`` seconds, and push every node on."""
        deadline = time.monotonic() + wall_time
        self._push()
        self._strangers.look()
        while (remaining := deadline - time.monotonic()) > 0.0:
            try:
                self._executor.spin_once(timeout_sec=remaining)
            except (_RCLError, _RMWError) as error:  # an answer that cannot be taken
                self._told.refuse("ROS 2", Refused(str(error), "layout"))
            if not self._is_up:
                self._push()  # each answer is waited for by what is asked next
        self._push()

    @property
    def progress(self) -> Progress:
        """What the graph last told about itself."""
        return self._told.progress

    @property
    def refused(self) -> Mapping[str, Mapping[str, int]]:
        """Messages that each node, and the launcher, refused: by topic and kind."""
        return self._told.refused

    @property
    def strangers(self) -> tuple[Stranger, ...]:
        """Who has been seen on topics and services of the flight and is none of its nodes."""
        return self._strangers.found

    def strangers_now(self) -> tuple[Stranger, ...]:
        """Return all, after a look at every topic and service."""
        self._strangers.look_everywhere()
        return self.strangers

    def strangers_gone(self) -> tuple[Stranger, ...]:
        """Return those who were gone before they were seen, and left messages without a seal."""
        named = {stranger.topic.strip("/") for stranger in self.strangers}
        topics = (topic.strip("/") for topic in self._told.unsealed())
        return tuple(Stranger(f"/{topic}", "") for topic in topics if topic not in named)

    def admit(self, name: str) -> None:
        """Expect another life of a node that is started again."""
        self._strangers.admit(f"/{name}")

    def stages(self) -> dict[str, Stage]:
        """Return how far each node has come."""
        return {name: node.stage for name, node in self._nodes.items()}

    def _push(self) -> None:
        """Configure all together; activate when all are configured, the plant last."""
        stages = [node.stage for node in self._nodes.values()]
        all_configured = not {Stage.STARTING, Stage.CONFIGURING} & set(stages)
        for name, node in self._nodes.items():
            others = (n.stage for other, n in self._nodes.items() if other != name)
            allowed = name != PLANT or all(stage is Stage.ACTIVE for stage in others)
            node.push(may_activate=all_configured and allowed)
        self._is_up = all(stage is Stage.ACTIVE for stage in stages)
