"""A composed graph hands messages over in memory, and publishes them for whoever listens."""

from __future__ import annotations

import time
from functools import partial
from typing import Any

import pytest
import rclpy
from node_messages import ends
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rosbags.highlevel import AnyReader

from spacecraft_gnc.launcher.launcher import Launcher
from spacecraft_gnc.launcher.outcome import Interrupted
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.signals.attitude import REFERENCE
from spacecraft_gnc.signals.seal import without_seal
from spacecraft_gnc.vehicles.rigid_body.signals import STATE, TORQUE

pytestmark = pytest.mark.graph

PATIENCE = 60.0  # [s] wall: after this a test has failed
LONG = ("plant.duration=100000.0", "launcher.composed=true")
ENOUGH = 30  # messages


class Listener:
    """Listens to a graph in mid-flight, and then ends the flight."""

    def __init__(self, *signals: Signal) -> None:
        self.heard: dict[Signal, list[int]] = {signal: [] for signal in signals}

    def __call__(self, launcher: Launcher) -> None:
        context = rclpy.Context()
        rclpy.init(args=[], context=context, domain_id=launcher._domain_id)
        # One that reads bytes keeps up: what overflows its queue would be no fault of the graph.
        executor, node = EventsExecutor(context=context), Node("guest", context=context)
        executor.add_node(node)
        for signal, steps in self.heard.items():
            kind, name, qos = ends(signal)
            hear = partial(self._hear, signal, steps)
            node.create_subscription(kind, name, hear, qos, raw=True)
        patience = time.monotonic() + PATIENCE
        try:
            while min(map(len, self.heard.values())) < ENOUGH:
                assert time.monotonic() < patience, self.heard
                executor.spin_once(timeout_sec=0.05)
        finally:
            node.destroy_node()
            executor.shutdown()
            rclpy.shutdown(context=context)
            launcher._signal = 2

    def _hear(self, signal: Signal, steps: list[int], data: bytes) -> None:
        step = signal.read(without_seal(data)).step
        if steps[-1:] != [step]:  # else repeated after a stall, as on a busy machine
            steps.append(step)


def test_who_listens_from_outside_hears_everything_and_nothing_is_lost(graph: Any, at: Any) -> None:
    listener, out = Listener(STATE, REFERENCE, TORQUE), graph.folder / "run"
    with pytest.raises(Interrupted):
        graph.fly(*LONG, display=at(20, listener), out=out)
    for signal, steps in listener.heard.items():
        assert steps[0] > 0, f"{signal}: joined too early to tell"
        assert steps == list(range(steps[0], steps[0] + len(steps)))
    with AnyReader([out / "bag"]) as reader:
        recorded: dict[str, list[int]] = {signal.name: [] for signal in listener.heard}
        for connection, _, data in reader.messages():
            steps_of = recorded.get(connection.topic.strip("/"))
            if steps_of is not None:
                steps_of.append(reader.deserialize(data, connection.msgtype).step)
    for signal, steps in listener.heard.items():
        told = recorded[signal.name]
        assert told == list(range(len(told)))
        assert told[-1] >= steps[-1]
    log = (out / "logs" / "graph.log").read_text()
    assert "rejected" not in log
    assert "LOST" not in log
