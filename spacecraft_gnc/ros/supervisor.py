"""ROS 2 node of the launcher: drives life cycles and listens for progress."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from spacecraft_gnc.launcher.environment import prepare
from spacecraft_gnc.ros.endpoints import message_type
from spacecraft_gnc.ros.managed import Managed, Stage
from spacecraft_gnc.ros.qos import ros_qos
from spacecraft_gnc.ros.told import Progress, Told
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.signals.graph import CONTROLLER, PLANT, WALL_STATUS, WALL_TIMING
from spacecraft_gnc.signals.members import Place, role_of, space_of
from spacecraft_gnc.signals.seal import opener

if TYPE_CHECKING:
    from typing_extensions import Self


class Supervisor:
    """Brings nodes to life and knows how they fare. Use it as a context manager.

    Parameters
    ----------
    names
        Nodes to look after, relative to the root namespace.
    domain_id
        ROS_DOMAIN_ID of the graph.
    key
        Of the flight: what its nodes tell is sealed with it.
    """

    def __init__(self, names: Sequence[str], domain_id: int, key: bytes = b"") -> None:
        prepare(os.environ)
        options = SignalHandlerOptions.NO
        rclpy.init(args=[], domain_id=domain_id, signal_handler_options=options)
        self._node = Node(f"launcher_{os.getpid()}", start_parameter_services=False)
        self._executor = EventsExecutor()
        self._executor.add_node(self._node)
        self._nodes = {name: Managed(self._node, name) for name in names}
        self._key = key
        self._told = Told()
        self._listen(WALL_TIMING, "", self._told.timing)
        for space in dict.fromkeys(space_of(n) for n in names if role_of(n) == CONTROLLER):
            self._listen(WALL_STATUS, space, partial(self._told.status, space))

    def _listen(self, signal: Signal, space: str, take: Callable[[bytes], None]) -> None:
        kind, topic, qos = (
            message_type(signal.type),
            Place("", space).topic(signal),
            ros_qos(signal.qos),
        )
        callback = self._told.guarded(topic, opener(self._key, topic), take)
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
        while (remaining := deadline - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=remaining)
        self._push()

    @property
    def progress(self) -> Progress:
        """What the graph last told about itself."""
        return self._told.progress

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
