"""A player process, a listener on its domain, and a bag to play."""

from __future__ import annotations

import gc
import os
import re
import struct
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

import rclpy
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions
from recording.bags import CODEC, announce, flight_messages, random_flight
from rosgraph_msgs.msg import Clock
from spacecraft_gnc_msgs.msg import (
    AttitudeReference,
    AttitudeState,
    GovernorStatus,
    PlantInvariants,
    SolverStatus,
    TorqueCommand,
)

from spacecraft_gnc.launcher import environment
from spacecraft_gnc.recording.qos import qos_yaml
from spacecraft_gnc.recording.stamps import step_of
from spacecraft_gnc.recording.writer import BagWriter
from spacecraft_gnc.ros.qos import ros_qos
from spacecraft_gnc.signals.qos import RECORD, QosProfile

ROOT = Path(__file__).resolve().parents[2]
PATIENCE = 60.0
STEPS = 40
STEP_NS = 400_000_000
TYPES = {
    "/attitude_state": AttitudeState,
    "/plant_invariants": PlantInvariants,
    "/clock": Clock,
    "/attitude_reference": AttitudeReference,
    "/governor_status": GovernorStatus,
    "/torque_command": TorqueCommand,
    "/solver_status": SolverStatus,
}
STRING = "std_msgs/msg/String"


def text(words: str) -> bytes:
    message = CODEC.make("std_msgs/String", data=words)
    return padded(bytes(CODEC.store.serialize_cdr(message, STRING)))


def recorded(
    folder: Path, steps: int = STEPS, *, unplayable: bool = False
) -> dict[str, list[bytes]]:
    """Write a bag of a flight and a latched note; ``unplayable``: and of types not installed so."""
    payloads: dict[str, list[bytes]] = defaultdict(list)
    note = QosProfile(depth=1, durability="transient_local")
    with BagWriter(folder) as writer:
        announce(writer)
        writer.add_topic("/note", STRING, CODEC.texts[STRING], qos_yaml=qos_yaml(note))
        writer.write("/note", 0, 0, text("remember"))
        if unplayable:
            writer.add_topic("/foreign", "absent_msgs/msg/Thing", "string data\n")
            writer.add_topic("/other", "std_msgs/msg/Int32", "int64 data\n")
            writer.write("/other", 0, 0, b"\0\1\0\0" + bytes(8))
            writer.write("/foreign", 0, 0, text("unknown"))
        for topic, step, data in flight_messages(random_flight(steps)):
            writer.write(f"/{topic}", step * STEP_NS, step * STEP_NS, data)
            payloads[f"/{topic}"].append(data)
    return dict(payloads)


def stamp(step: int) -> bytes:
    return struct.pack("<iI", *divmod(step * STEP_NS, 10**9))


def padded(data: bytes) -> bytes:
    """Return a message as RTPS carries it between two processes: whole words."""
    return data + b"\0" * (-len(data) % 4)


class Player:
    """A process of ``gnc replay BAG --publish``."""

    def __init__(self, bag: Path, *options: str, terminal: int | None = None) -> None:
        env = environment.for_node(os.environ, 0)
        for name in (environment.SUPERVISED, environment.DOMAIN_ID):
            del env[name]
        env["PYTHONPATH"] = str(ROOT)
        env["TERM"] = "xterm"
        command = [sys.executable, "-m", "spacecraft_gnc", "replay", str(bag), "--publish"]
        self.process = subprocess.Popen(
            [*command, "--patience", "50", *options],
            env=env,
            stdin=subprocess.DEVNULL if terminal is None else terminal,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE if terminal is None else terminal,
            text=True,
        )
        assert self.process.stdout is not None
        self.announced = self.process.stdout.readline()
        found = re.search(r"ROS_DOMAIN_ID=(\d+);", self.announced)
        assert found, self.announced
        self.domain_id = int(found[1])

    def end(self, code: int = 0) -> tuple[str, str]:
        """Wait for the end, a good one by default; return what was printed."""
        # not communicate(): it would leave out what was read ahead with the first line
        with self.process as process:
            assert process.stdout is not None
            out = process.stdout.read()
            err = process.stderr.read() if process.stderr else ""
        assert self.process.returncode == code, err
        return out, err


class Listener:
    """Subscriptions in this process, on the player's domain."""

    def __init__(self, domain_id: int) -> None:
        environment.prepare(os.environ)
        no_signals = SignalHandlerOptions.NO
        rclpy.init(args=[], domain_id=domain_id, signal_handler_options=no_signals)
        self.node = Node("listener")
        self.executor = EventsExecutor()
        self.executor.add_node(self.node)
        self.heard: dict[str, list[bytes]] = defaultdict(list)

    def listen(self, *topics: str, kind: Any = None, qos: QoSProfile | None = None) -> None:
        for topic in topics:
            message_type = kind or TYPES[topic]
            callback = self.heard[topic].append
            self.node.create_subscription(
                message_type, topic, callback, qos or ros_qos(RECORD), raw=True
            )

    def spin_until(self, done: Callable[[], bool]) -> None:
        deadline = time.monotonic() + PATIENCE
        while not done():
            assert time.monotonic() < deadline, "never came true"
            self.executor.spin_once(timeout_sec=0.05)

    def call(self, service: Any, name: str, request: Any) -> Any:
        client = self.node.create_client(service, f"/player/{name}")
        self.spin_until(client.service_is_ready)
        future = client.call_async(request)
        self.spin_until(future.done)
        return future.result()

    def set(self, name: str, value: float | bool) -> Any:
        kind = {"type": 1, "bool_value": value} if isinstance(value, bool) else {}
        kind = kind or {"type": 3, "double_value": value}
        parameter = Parameter(name=name, value=ParameterValue(**kind))
        request = SetParameters.Request(parameters=[parameter])
        return self.call(SetParameters, "set_parameters", request).results[0]

    def get(self, name: str) -> Any:
        request = GetParameters.Request(names=[name])
        (value,) = self.call(GetParameters, "get_parameters", request).values
        return value.bool_value if value.type == 1 else value.double_value

    def steps(self, topic: str) -> list[int | None]:
        return [step_of(data) for data in self.heard[topic]]

    def close(self) -> None:
        self.executor.remove_node(self.node)
        self.node.destroy_node()
        self.executor.shutdown()
        rclpy.try_shutdown()
        gc.collect()
