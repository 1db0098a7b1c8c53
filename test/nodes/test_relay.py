"""``gnc view --foxglove`` beside a live graph: the app gets the bytes that were published."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from geometry_msgs.msg import PoseStamped
from live.test_foxglove import HEADER, MESSAGE, App
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock

from spacecraft_gnc.ros import relay as _relay
from spacecraft_gnc.ros.endpoints import Endpoint, TopicInfo
from spacecraft_gnc.ros.qos import ros_qos
from spacecraft_gnc.ros.relay import Relay
from spacecraft_gnc.signals.attitude import POSE
from spacecraft_gnc.signals.graph import CLOCK
from spacecraft_gnc.signals.qos import latched

pytest.importorskip("foxglove")
ROOT = Path(__file__).resolve().parents[2]
TIME = 7_250_000_000  # [ns] simulated


class Listener(threading.Thread):
    """Collects what the app receives until each topic has come, one of them at its time [ns]."""

    def __init__(self, port: int, wanted: dict[str, int | None]) -> None:
        super().__init__(daemon=True)
        self.app = App(port)
        self.wanted = wanted
        self.found: dict[str, tuple[int, bytes]] = {}

    def _has_all(self) -> bool:
        return all(
            topic in self.found and stamp in (None, self.found[topic][0])
            for topic, stamp in self.wanted.items()
        )

    def run(self) -> None:
        while not self._has_all():
            opcode, data = self.app.read()
            if opcode is None:
                self.app.subscribe()
            elif opcode == MESSAGE:
                _, channel, log_time = HEADER.unpack_from(data)
                names = {c["id"]: topic for topic, c in self.app.channels.items()}
                self.found[names[channel]] = (log_time, data[HEADER.size :])
        self.app.socket.close()


class Graph:
    """A graph of two topics, one of them the clock, whose messages the test says."""

    def __init__(self) -> None:
        self.say: dict[str, Callable[[bytes], None]] = {}

    def topics(self) -> list[TopicInfo]:
        return [
            TopicInfo("/a_pose", ("geometry_msgs/msg/PoseStamped",), 1, 0),
            TopicInfo("/clock", ("rosgraph_msgs/msg/Clock",), 1, 0),
        ]

    def publishers(self, name: str) -> list[Endpoint]:
        return [Endpoint("/talker", name, QoSProfile(depth=1))]

    def subscribe(self, name: str, callback: Callable[[bytes], None], *, raw: bool) -> None:
        assert raw
        self.say[name] = callback

    def spin_until(self, done: Callable[[], bool]) -> None:
        while not done():
            pass


@pytest.fixture
def relayed() -> tuple[Graph, Relay, list[tuple[str, int, bytes]]]:
    graph, sent = Graph(), []
    relay = Relay(graph, lambda *_, **__: None, lambda *message: sent.append(message))
    return graph, relay, sent


def test_nothing_is_shown_at_wall_time_where_a_clock_is_about_to_tick(relayed: Any) -> None:
    graph, relay, sent = relayed
    relay.look()
    graph.say["/a_pose"](b"before")
    assert sent == []
    tick = CLOCK.encode((0, 0), 0, [(7, 250_000_000)])
    graph.say["/clock"](tick)
    graph.say["/a_pose"](b"after")
    assert sent == [
        ("/a_pose", TIME, b"before"),
        ("/clock", TIME, tick),
        ("/a_pose", TIME, b"after"),
    ]


def test_a_clock_that_is_silent_holds_nobody_up(relayed: Any, monkeypatch: Any) -> None:
    graph, relay, sent = relayed
    monkeypatch.setattr(_relay, "_PATIENCE", 0.0)
    before = time.time_ns()
    relay.look()
    graph.say["/a_pose"](b"")
    relay.wait()
    ((topic, stamp, data),) = sent
    assert (topic, data) == ("/a_pose", b"")
    assert before <= stamp <= time.time_ns()


def test_topics_of_any_package_reach_the_app(ros: Any) -> None:
    node = ros.add(Node("talker"))
    pose = POSE.encode((0, 0), 0, [(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5)])
    clock = CLOCK.encode((0, 0), 0, [divmod(TIME, 10**9)])
    node.create_publisher(PoseStamped, "once", ros_qos(latched(1))).publish(pose)
    often = node.create_publisher(PoseStamped, "often", 10)
    ticks = node.create_publisher(Clock, "/clock", 10)

    def talk() -> None:
        ticks.publish(clock)
        often.publish(pose)

    timer = node.create_timer(0.05, talk)
    command = [sys.executable, "-m", "spacecraft_gnc", "view", "--foxglove", "--json"]
    command += ["--domain-id", str(ros.nodes_domain())]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(
        command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, text=True
    ) as view:
        about: dict[str, Any] = {}

        def read() -> None:
            about.update(json.loads("".join(iter(view.stdout.readline, "}\n")) + "}"))

        reader = threading.Thread(target=read, daemon=True)
        reader.start()
        ros.spin_until(lambda: not reader.is_alive())
        # A clock found a look later than the others leaves the first of them at wall time.
        wanted = {"/once": None, "/often": TIME, "/clock": TIME}
        listener = Listener(about["port"], wanted)
        listener.start()
        ros.spin_until(lambda: not listener.is_alive())
        view.terminate()
        ros.spin_until(lambda: view.poll() is not None)
    node.destroy_timer(timer)
    assert view.returncode == 0
    assert listener.found["/often"][1] == pose
    assert listener.found["/once"][1] == pose
    assert listener.found["/clock"][1] == clock
    channel = listener.app.channels["/often"]
    assert (channel["schemaName"], channel["encoding"]) == ("geometry_msgs/msg/PoseStamped", "cdr")
    assert "MSG: geometry_msgs/Quaternion" in channel["schema"]
