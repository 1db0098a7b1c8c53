"""Who publishes on a topic of a flight and is none of its nodes is named, whatever he does."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from lifecycle_msgs.srv import GetState
from node_messages import ends
from rclpy.node import Node

from spacecraft_gnc.launcher.launcher import Launcher
from spacecraft_gnc.signals.attitude import TARGET
from spacecraft_gnc.signals.graph import CLOCK
from spacecraft_gnc.vehicles.rigid_body.signals import TORQUE

pytestmark = pytest.mark.graph

EARLY = 60
FLIGHT = ("plant.duration=800.0", "plant.command_timeout=120.0")


@contextmanager
def stranger(name: str) -> Iterator[Callable[[Launcher, str, Any, Any], Node]]:
    """Yield what makes a publisher of a node in the domain of a launch."""
    made: list[tuple[Node, rclpy.Context]] = []

    def publish(launcher: Launcher, topic: str, kind: Any, qos: Any) -> Node:
        context = rclpy.Context()
        rclpy.init(args=[], context=context, domain_id=launcher._domain_id)
        made.append((Node(name, context=context), context))
        node = made[-1][0]
        node.create_publisher(kind, topic, qos)
        return node

    yield publish
    for node, context in made:
        node.destroy_node()
        rclpy.shutdown(context=context)


@pytest.mark.parametrize(
    ("name", "signal", "mode"),
    [
        ("stranger", TORQUE, "lockstep"),
        ("nmpc_controller", TORQUE, "lockstep"),  # the name is taken, and proves nothing
        pytest.param("stranger", TORQUE, "free_run", marks=pytest.mark.long),
        pytest.param("plant", CLOCK, "free_run", marks=pytest.mark.long),
    ],
)
def test_a_second_publisher_is_named_at_once(
    graph: Any, at: Any, name: str, signal: Any, mode: str
) -> None:
    kind, topic, qos = ends(signal)
    pace = (f"plant.mode={mode}", "plant.real_time_factor=100.0")
    with stranger(name) as publish:
        display = at(EARLY, lambda launcher: publish(launcher, topic, kind, qos))
        graph.fly(*FLIGHT, *pace, display=display)
    line = f"/{topic.strip('/')}: /{name}"
    assert graph.outcome.strangers == (line,)
    (text,) = (text for text in display.told if text.startswith("error: "))
    assert text.startswith(f"error: {line}: received what comes from none of this flight's nodes")
    assert graph.outcome.steps == 2000


@pytest.mark.long
def test_a_second_server_of_a_node_is_named(graph: Any, at: Any) -> None:
    """Its answers would pass for those of the node."""

    def serve(launcher: Launcher) -> None:
        node = publish(launcher, "/something_else", DiagnosticArray, 10)
        node.create_service(GetState, "/plant/get_state", lambda _, answer: answer)

    with stranger("stranger") as publish:
        display = at(EARLY, serve)
        graph.fly(*FLIGHT, display=display)
    assert graph.outcome.strangers == ("/plant/get_state: somebody without a name",)


def test_users_and_other_diagnostics_are_no_strangers(graph: Any, at: Any) -> None:
    def speak(launcher: Launcher) -> None:
        kind, topic, qos = ends(TARGET)
        publish(launcher, topic, kind, qos)
        publish(launcher, "/diagnostics", DiagnosticArray, 10)
        publish(launcher, "/something_else", DiagnosticArray, 10)

    with stranger("user") as publish:
        display = at(EARLY, speak)
        graph.fly(*FLIGHT, display=display)
    assert graph.outcome.strangers == ()
    assert display.told == []
