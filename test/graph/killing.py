"""A node killed on purpose, where it has told everything of its step."""

from __future__ import annotations

import os
import signal
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import rclpy
from node_messages import ends
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from spacecraft_gnc.launcher.launcher import Launcher
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.signals.attitude import REFERENCE
from spacecraft_gnc.signals.graph import CONTROLLER, GOVERNOR
from spacecraft_gnc.vehicles.rigid_body.signals import STATE

PATIENCE = 60.0  # [s] wall: after this a test has failed


@contextmanager
def standing_still(launcher: Launcher, name: str) -> Iterator[None]:
    """Stop a node that the flight needs, and with it simulated time."""
    stopped = launcher._processes[name].pid
    os.kill(stopped, signal.SIGSTOP)
    try:
        yield
    finally:
        os.kill(stopped, signal.SIGCONT)


def kill_governor_between_steps(launcher: Launcher) -> None:
    """Kill it while the graph stands still.

    At any other time SIGKILL may fall between the reference of a step and the status, which then is
    in no bag. Without a controller the plant repeats the state, and the governor its reference; by
    then it has published the status.
    """
    _kill_between_steps(launcher, GOVERNOR, CONTROLLER, REFERENCE)


def kill_controller_between_steps(launcher: Launcher) -> None:
    """Kill it while it waits for a reference: it has told everything of the step before."""
    _kill_between_steps(launcher, CONTROLLER, GOVERNOR, STATE)


def _kill_between_steps(launcher: Launcher, name: str, other: str, signal_: Signal) -> None:
    """Kill a node while the ``other`` one stands still, once a message of a step is repeated."""
    with standing_still(launcher, other):
        _await_repeat(launcher._domain_id, signal_)
        os.kill(launcher._processes[name].pid, signal.SIGKILL)


def _await_repeat(domain_id: int, signal_: Signal) -> None:
    """Wait for a message of a step that was published before."""
    steps: Counter[int] = Counter()

    def hear(message: Any) -> None:
        steps[message.step] += 1

    context = rclpy.Context()
    rclpy.init(args=[], context=context, domain_id=domain_id)
    executor, node = SingleThreadedExecutor(context=context), Node("witness", context=context)
    executor.add_node(node)
    kind, name, qos = ends(signal_)
    node.create_subscription(kind, name, hear, qos)
    patience = time.monotonic() + PATIENCE
    try:
        while max(steps.values(), default=0) < 2:
            assert time.monotonic() < patience, f"{signal_} was never repeated"
            executor.spin_once(timeout_sec=0.05)
    finally:
        node.destroy_node()
        executor.shutdown()
        rclpy.shutdown(context=context)
