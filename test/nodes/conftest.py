"""Nodes of the graph in this process, on a domain of their own."""

from __future__ import annotations

import gc
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import rclpy
from rclpy.experimental import EventsExecutor
from rclpy.signals import SignalHandlerOptions

from spacecraft_gnc.launcher import domain
from spacecraft_gnc.nodes._node import GncNode

PATIENCE = 30.0  # [s] wall: after this a test has failed
REST = 20  # tests for which a domain rests: nodes that Python has yet to collect still speak there
CASE1 = Path(__file__).resolve().parents[2] / "config" / "gupta2015_case1.yaml"


class Ros:
    """An executor with nodes in it, driven until something holds."""

    def __init__(self) -> None:
        self.executor = EventsExecutor()
        self.nodes: list[GncNode] = []

    def nodes_domain(self) -> int:
        return int(rclpy.get_default_context().get_domain_id())

    def add(self, node: GncNode) -> GncNode:
        self.nodes.append(node)
        self.executor.add_node(node)
        return node

    def spin_until(self, done: Callable[[], bool]) -> None:
        patience = time.monotonic() + PATIENCE
        while not done():
            if time.monotonic() > patience:
                raise AssertionError("never came true")
            self.executor.spin_once(timeout_sec=0.05)


@pytest.fixture(scope="session")
def resting() -> Iterator[deque[domain.DomainLock]]:
    """Domains of the last tests, the oldest first."""
    locks: deque[domain.DomainLock] = deque()
    yield locks
    for lock in locks:
        lock.release()


@pytest.fixture
def ros(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, resting: deque[domain.DomainLock]
) -> Iterator[Ros]:
    arguments = ["test", "--ros-args", "--params-file", str(CASE1)]
    arguments += ["-p", f"recorder:storage_folder:={tmp_path / 'bag'}"]
    monkeypatch.setattr(sys, "argv", arguments)
    lock = domain.claim_free({"test": "nodes"})
    rclpy.init(
        args=arguments,
        domain_id=lock.domain_id,
        signal_handler_options=SignalHandlerOptions.NO,
    )
    ros = Ros()
    try:
        yield ros
    finally:
        for node in ros.nodes:
            ros.executor.remove_node(node)
            node.destroy_node()
        ros.executor.shutdown()
        rclpy.try_shutdown()
        gc.collect()
        resting.append(lock)
        if len(resting) > REST:
            resting.popleft().release()
