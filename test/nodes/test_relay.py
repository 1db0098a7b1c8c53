"""``gnc view --foxglove`` beside a live graph: the app gets the bytes that were published."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import pytest
from geometry_msgs.msg import PoseStamped
from live.test_foxglove import HEADER, MESSAGE, App
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

from spacecraft_gnc.nodes._cdr import encode
from spacecraft_gnc.nodes._topics import latched

pytest.importorskip("foxglove")
ROOT = Path(__file__).resolve().parents[2]
TIME = 7_250_000_000  # [ns] simulated


class Listener(threading.Thread):
    """Collects what the app receives until it has what it waits for."""

    def __init__(self, port: int, wanted: set[str]) -> None:
        super().__init__(daemon=True)
        self.app = App(port)
        self.wanted = wanted
        self.found: dict[str, tuple[int, bytes]] = {}

    def run(self) -> None:
        while not self.wanted <= set(self.found):
            opcode, data = self.app.read()
            if opcode is None:
                self.app.subscribe()
            elif opcode == MESSAGE:
                _, channel, log_time = HEADER.unpack_from(data)
                names = {c["id"]: topic for topic, c in self.app.channels.items()}
                self.found[names[channel]] = (log_time, data[HEADER.size :])
        self.app.socket.close()


def test_topics_of_any_package_reach_the_app(ros: Any) -> None:
    node = ros.add(Node("talker"))
    pose = PoseStamped()
    pose.header.frame_id = "inertial"
    pose.pose.orientation.w = 0.5
    clock = Clock()
    clock.clock.sec, clock.clock.nanosec = divmod(TIME, 10**9)
    node.create_publisher(PoseStamped, "once", latched(1)).publish(encode(pose))
    often = node.create_publisher(PoseStamped, "often", 10)
    ticks = node.create_publisher(Clock, "/clock", 10)

    def talk() -> None:
        ticks.publish(encode(clock))
        often.publish(encode(pose))

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
        listener = Listener(about["port"], {"/once", "/often", "/clock"})
        listener.start()
        ros.spin_until(lambda: not listener.is_alive())
        view.terminate()
        ros.spin_until(lambda: view.poll() is not None)
    node.destroy_timer(timer)
    assert view.returncode == 0
    assert listener.found["/often"] == (TIME, encode(pose))
    assert listener.found["/once"][1] == encode(pose)
    assert listener.found["/clock"][1] == encode(clock)
    channel = listener.app.channels["/often"]
    assert (channel["schemaName"], channel["encoding"]) == ("geometry_msgs/msg/PoseStamped", "cdr")
    assert "MSG: geometry_msgs/Quaternion" in channel["schema"]
