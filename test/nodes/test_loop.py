"""What a process of nodes handles, in which order, and when it looks at ROS."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from spacecraft_gnc.nodes import _runner
from spacecraft_gnc.nodes._exchange import Exchange
from spacecraft_gnc.nodes._runner import Loop
from spacecraft_gnc.nodes.plant import PlantNode
from spacecraft_gnc.nodes.recorder import RecorderNode


class Executor:
    """Writes down how it is spun."""

    def __init__(self, told: list[Any]) -> None:
        self.told = told

    def spin_once(self, timeout_sec: float) -> None:
        self.told.append(("once", timeout_sec))

    def spin_until_future_complete(self, future: Any, timeout_sec: float) -> None:
        self.told.append(("all", timeout_sec))


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    told: list[Any] = []
    monkeypatch.setattr(_runner.time, "sleep", lambda time: told.append(("sleep", time)))
    return told


def node(kind: Any = PlantNode, *, active: bool = True) -> Any:
    return SimpleNamespace(GATHERS=kind.GATHERS, active=active, finished=False, progress=lambda: 0)


def test_a_recorder_alone_lets_messages_gather(told: list[Any]) -> None:
    Loop(Executor(told), [node(RecorderNode)], None).turn(0.1)
    assert told == [("once", 0.1), ("sleep", RecorderNode.GATHERS), ("all", 0.0)]


@pytest.mark.parametrize(
    ("kind", "active", "timeout"),
    [(RecorderNode, False, 0.1), (RecorderNode, True, 0.0), (PlantNode, True, 0.1)],
)
def test_who_waits_for_nothing(told: list[Any], kind: Any, active: bool, timeout: float) -> None:
    """A node that starts, one that is drained at its end, and one that others wait for."""
    Loop(Executor(told), [node(kind, active=active)], None).turn(timeout)
    assert told == [("once", timeout)]


def test_what_waits_in_the_process_goes_first(told: list[Any]) -> None:
    exchange = Exchange()
    send = exchange.outlet("/a", told.append, lambda: 1)
    with exchange.reading("/a", told.append):
        send(b"1")
        send(b"2")
        Loop(Executor(told), [node(RecorderNode), node()], exchange).turn(0.1)
    assert told == [b"1", b"2", ("once", 0.1)]


def test_ros_has_its_turn_in_a_process_that_never_rests(told: list[Any]) -> None:
    exchange = Exchange()
    send = exchange.outlet("/a", told.append, lambda: 1)
    with exchange.reading("/a", send):
        send(b"1")
        Loop(Executor(told), [node(), node()], exchange).turn(0.1)
    assert told == [("once", 0.0)]  # which does not wait, because a message does
    assert exchange


def test_nothing_is_handed_over_after_a_node_has_finished(told: list[Any]) -> None:
    exchange, plant = Exchange(), node()

    def finish(data: bytes) -> None:
        told.append(data)
        plant.finished = True

    send = exchange.outlet("/a", told.append, lambda: 1)
    with exchange.reading("/a", finish):
        send(b"1")
        send(b"2")
        Loop(Executor(told), [node(), plant], exchange).turn(0.1)
    assert told == [b"1", ("once", 0.0)]
