"""A stranger in the flight's ROS domain: listens to it, or sends what it should not.

`hostile.py` starts it with a job in JSON; it prints one JSON object a line: ``progress`` and
``diagnostic`` as the nodes tell them, ``sent`` at the end of an attack. What it says of the flight
it takes from sealed messages alone, if it was given the key, so that it does not fall for itself.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from typing import Any, Final

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from hostile_messages import Attack, Genuine, step_at
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from rclpy.signals import SignalHandlerOptions

from spacecraft_gnc.launcher.environment import prepare
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.ros.endpoints import message_type
from spacecraft_gnc.ros.graph_of import signals_of
from spacecraft_gnc.ros.qos import ros_qos
from spacecraft_gnc.scenario import load_fleet
from spacecraft_gnc.signals import Refused, Signal
from spacecraft_gnc.signals.attitude import REFERENCE
from spacecraft_gnc.signals.graph import CLOCK, DIAGNOSTICS, WALL_TIMING
from spacecraft_gnc.signals.members import Place
from spacecraft_gnc.signals.message import period_ns, stamp_of
from spacecraft_gnc.signals.qos import RECORD
from spacecraft_gnc.signals.seal import opener
from spacecraft_gnc.vehicles.rigid_body.signals import STATE, TORQUE, Torque

_SHOW_PERIOD: Final = 0.02  # [s] wall between two lines about the progress
_LEARNING: Final = 1.5  # [s] wall of listening before an attack
_PATIENCE: Final = 60.0  # [s] wall
_AHEAD: Final = 5  # steps: the one that is due, and those to come
_TICK: Final = 1e-3  # [s] wall
_TRIES: Final = 100


class Stranger:
    """A node beside the graph.

    Parameters
    ----------
    domain_id
        ROS domain of the flight.
    key
        Of the flight, in hexadecimal; empty: what is heard is not checked.
    """

    def __init__(self, domain_id: int, key: str) -> None:
        prepare(os.environ)
        quietly = SignalHandlerOptions.NO  # a signal ends it at once
        rclpy.init(args=[], domain_id=domain_id, signal_handler_options=quietly)
        self.node = Node("stranger", enable_rosout=False, start_parameter_services=False)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self._key = bytes.fromhex(key)
        self._shown = 0.0
        self._step = -1
        self.hear(WALL_TIMING, self._on_timing)
        self.hear(DIAGNOSTICS, self._on_diagnostic)

    def hear(self, signal: Signal, callback: Callable[[bytes], None]) -> Any:
        """Listen to a topic, raw."""
        qos = ros_qos(signal.qos if signal.is_latched else RECORD)
        kind = message_type(signal.type)
        return self.node.create_subscription(kind, topic_of(signal), callback, qos, raw=True)

    def publisher(self, signal: Signal) -> Any:
        """Return a publisher as the nodes have."""
        kind, qos = message_type(signal.type), ros_qos(signal.qos)
        return self.node.create_publisher(kind, topic_of(signal), qos)

    def spin(self, until: Callable[[], bool], patience: float) -> bool:
        """Handle what comes until something holds; return whether it does in time."""
        deadline = time.monotonic() + patience
        while not until():
            if time.monotonic() > deadline:
                return False
            self._executor.spin_once(timeout_sec=_TICK)
        return True

    def opened(self, signal: Signal, data: bytes) -> bytes | None:
        """Return a message of the nodes without its seal; None: it is of somebody else."""
        return opener(self._key, topic_of(signal))(data)

    def _on_timing(self, data: bytes) -> None:
        message = self.opened(WALL_TIMING, data)
        now = time.monotonic()
        if message is None:
            return
        with suppress(Refused):
            told = WALL_TIMING.decode(message)
            self._step = told.step
            if now - self._shown >= _SHOW_PERIOD:
                self._shown = now
                missed, rejected = told["missed_deadlines"], told["rejected_messages"]
                elapsed = told["wall_elapsed"]
                say(
                    "progress",
                    at=now,
                    step=told.step,
                    elapsed=elapsed,
                    missed=missed,
                    rejected=rejected,
                )

    def _on_diagnostic(self, data: bytes) -> None:
        message = self.opened(DIAGNOSTICS, data)
        if message is None:
            return
        with suppress(Exception):  # without a key it hears itself
            for status in deserialize_message(message, DiagnosticArray).status:
                values = {entry.key: entry.value for entry in status.values}
                level = ord(status.level)
                say(
                    "diagnostic",
                    node=status.name,
                    level=level,
                    text=status.message[:500],
                    values=values,
                )

    @property
    def is_flying(self) -> bool:
        """Whether a step was told."""
        return self._step >= 0


def say(kind: str, **values: Any) -> None:
    """Print a line."""
    print(json.dumps({"kind": kind, **values}), flush=True)


def topic_of(signal: Signal) -> str:
    """Return the full name of a topic of a graph of one craft."""
    return Place("").topic(signal)


def watch(stranger: Stranger, job: dict[str, Any]) -> None:
    """Only listen, until it is killed or left alone."""
    while os.getppid() == job["parent"]:
        stranger.spin(lambda: False, 1.0)


def send(stranger: Stranger, job: dict[str, Any]) -> None:
    """Send hostile messages on all topics in turn at a rate; or, as ``echo``, what was heard."""
    signals = [signal for _, signal in signals_of(load_fleet(job["scenario"]))]
    genuine, last = Genuine(), {}

    def keep(signal: Signal, data: bytes) -> None:
        genuine.hear(signal, topic_of(signal), data)
        last[signal] = data

    heard = [stranger.hear(signal, partial(keep, signal)) for signal in signals]
    publishers = {signal: stranger.publisher(signal) for signal in signals}
    flying = stranger.spin(lambda: stranger.is_flying, _PATIENCE)
    stranger.spin(lambda: False, _LEARNING)
    if not job["listen"]:  # a fast flight leaves no time for both
        for subscription in heard:
            stranger.node.destroy_subscription(subscription)
    attack = Attack(job["seed"], genuine)
    sent: Counter[str] = Counter()
    kinds: Counter[str] = Counter()
    targets = [signal for signal in signals if signal in last or not job["echo"]]
    for signal in _paced(stranger, targets, job["count"], job["rate"]):
        topic = topic_of(signal)
        if job["echo"]:
            kind = "echo"
            publishers[signal].publish(last[signal])
        else:
            kind = _published(publishers[signal], partial(attack.message, signal, topic))
        sent[topic] += 1
        kinds[kind] += 1
    deadline = time.monotonic() + _PATIENCE
    for publisher in publishers.values():  # what DDS lost it sends again within seconds
        left = max(deadline - time.monotonic(), 0.0)
        publisher.wait_for_all_acked(Duration(seconds=left))
    say("sent", flying=flying, topics=sent, kinds=kinds, total=sum(sent.values()))
    watch(stranger, job)


def _published(publisher: Any, make: Callable[[], tuple[str, bytes]]) -> str:
    """Publish the first message that DDS does not refuse on this side; return its kind.

    It refuses what is longer than any message of a type without strings and sequences.
    """
    for _ in range(_TRIES):
        kind, data = make()
        try:
            publisher.publish(data)
        except RuntimeError:
            continue
        return kind
    raise SystemExit("error: DDS refuses everything")


def _paced(stranger: Stranger, signals: list[Signal], count: int, rate: float) -> Iterator[Signal]:
    begun = time.monotonic()
    for number in range(count):
        while time.monotonic() - begun < number / rate:
            stranger.spin(lambda: True, 0.0)
            time.sleep(_TICK)
        yield signals[number % len(signals)]
        if number % 50 == 0:
            stranger.spin(lambda: True, 0.0)


def steer(stranger: Stranger, job: dict[str, Any]) -> None:
    """Answer each state at once, and those to come in advance, by a torque of its own and more."""
    scenario = load_fleet(job["scenario"]).leading
    period = period_ns(scenario.period)
    signals = (TORQUE, REFERENCE, STATE, CLOCK)
    publishers = {signal: stranger.publisher(signal) for signal in signals}
    heard: list[int] = []
    genuine: dict[Signal, bytes] = {}

    def keep(signal: Signal, data: bytes) -> None:
        genuine[signal] = data
        if signal is STATE:
            with suppress(Refused):
                message = stranger.opened(STATE, data)
                if message is not None:
                    heard.append(STATE.decode(message).step)

    for signal in signals[:3]:
        stranger.hear(signal, partial(keep, signal))
    sent: Counter[str] = Counter()

    def is_done() -> bool:
        if heard:
            step = heard[-1]
            heard.clear()
            for k in range(step, step + _AHEAD):
                for signal, publisher in publishers.items():
                    if sent[signal.name] < job["count"] and signal in (*genuine, CLOCK):
                        publisher.publish(_forged(signal, k, stamp_of(k, period), genuine))
                        sent[signal.name] += 1
        return sum(sent.values()) >= job["count"] * len(signals)

    stranger.spin(is_done, _PATIENCE)
    say("sent", topics=sent, total=sum(sent.values()))
    watch(stranger, job)


def _forged(
    signal: Signal, step: int, stamp: tuple[int, int], genuine: dict[Signal, bytes]
) -> bytes:
    """Return a well-formed message of a step that steers elsewhere."""
    if signal is CLOCK:
        return CLOCK.encode(stamp, step, [stamp])
    if signal is TORQUE:
        return TORQUE.encode(stamp, step, Torque(np.array(_TORQUE), Source.METHOD))
    data = bytearray(genuine[signal])
    at = step_at(signal) or 0
    data[at : at + 8] = step.to_bytes(8, "little")
    data[4:12] = stamp[0].to_bytes(4, "little") + stamp[1].to_bytes(4, "little")
    data[at + 8 : at + 80] = _TURNED
    return bytes(data)


_TURNED: Final = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]).tobytes()
"""An attitude a quarter turn away."""
_TORQUE: Final = (0.01, -0.01, 0.01)  # [N m]
_ACTS: Final = {"watch": watch, "send": send, "steer": steer}


def main() -> int:
    """Do the job given as JSON."""
    job = json.loads(sys.argv[1])
    _ACTS[job["act"]](Stranger(job["domain_id"], job["key"]), job)
    return 0


if __name__ == "__main__":
    sys.exit(main())
