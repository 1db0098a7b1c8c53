"""Docking in the graph: the numbers of `gnc simulate`, a target and a lost thruster in flight."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rclpy
from graph.comparison import CASE1, assert_equals_simulation
from node_messages import ends
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.analysis.reader import read_flight
from spacecraft_gnc.launcher.launcher import Launcher
from spacecraft_gnc.launcher.outcome import Interrupted
from spacecraft_gnc.vehicles.docking.decision import Phase
from spacecraft_gnc.vehicles.docking.signals import ACCEPTED_TARGET, TARGET
from spacecraft_gnc.vehicles.docking.state import DIRECTIONS, RelativeReference

pytestmark = pytest.mark.graph

DOCKING = CASE1.with_name("afrl_docking.yaml")
FAILED = CASE1.with_name("afrl_docking_thruster_failed.yaml")
COMPOSED = "launcher.composed=true"
ENDLESS = "plant.duration=100000.0"  # [s]: the launch is ended before
WISH = (2.0, 0.3, -0.2, 0.1, 0.0, -0.1)  # [m], [rad]
PATIENCE = 60.0  # [s] wall: after this a test has failed


def test_a_flight_is_that_of_simulate_and_its_audit_passes(graph: Any) -> None:
    out = graph.fly(scenario=DOCKING)
    assert graph.exit_codes == dict.fromkeys(
        ("plant", "nmpc_controller", "reference_governor", "recorder"), 0
    )
    assert_equals_simulation(out / "bag", scenario=DOCKING)
    audit = audit_bag(out)
    assert audit.passed, audit.first


@pytest.mark.long
def test_a_lost_thruster_is_noticed_in_the_graph_as_in_simulate(graph: Any) -> None:
    out = graph.fly(COMPOSED, scenario=FAILED)
    assert_equals_simulation(out / "bag", scenario=FAILED)
    audit = audit_bag(out)
    assert audit.passed, audit.first
    flight: Any = read_flight(out / "bag").trajectory
    lost = np.flatnonzero(~flight.thrusters.all(axis=1))
    noticed = np.flatnonzero(flight.lost_thruster >= 0)
    (direction,) = np.flatnonzero(~flight.thrusters[lost[0]])
    assert lost[0] < noticed[0]
    assert set(flight.lost_thruster[noticed]) == {direction}
    assert DIRECTIONS[direction]
    assert (flight.phase[noticed] != Phase.DOCKING).all()


class Operator:
    """Commands a target while the graph flies, then ends the flight."""

    def __init__(self) -> None:
        self.accepted: list[Any] = []

    def __call__(self, launcher: Launcher) -> None:
        context = rclpy.Context()
        rclpy.init(args=[], context=context, domain_id=launcher._domain_id)
        self.executor = SingleThreadedExecutor(context=context)
        self.node = Node("operator", context=context)
        self.executor.add_node(self.node)
        try:
            self.command()
        finally:
            self.node.destroy_node()
            self.executor.shutdown()
            rclpy.shutdown(context=context)
        launcher._signal = 2

    def command(self) -> None:
        topic = self.node.create_publisher(*ends(TARGET))
        kind, name, qos = ends(ACCEPTED_TARGET)
        self.node.create_subscription(kind, name, self.accepted.append, qos)
        self.spin(lambda: topic.get_subscription_count() >= 2)  # governor and recorder
        topic.publish(TARGET.encode((0, 0), 0, RelativeReference.of(np.array(WISH))))
        self.spin(lambda: self.accepted)
        reached = time.monotonic() + 2.0  # what is flown meanwhile: some steps at least
        self.spin(lambda: time.monotonic() > reached)

    def spin(self, done: Callable[[], Any]) -> None:
        patience = time.monotonic() + PATIENCE
        while not done():
            assert time.monotonic() < patience, "never came true"
            self.executor.spin_once(timeout_sec=0.05)


@pytest.mark.long
def test_a_target_in_flight(graph: Any, at: Any) -> None:
    operator = Operator()
    out: Path = graph.folder / "target"
    with pytest.raises(Interrupted):
        graph.fly(ENDLESS, scenario=DOCKING, display=at(1, operator), out=out)
    flight: Any = read_flight(out / "bag").trajectory
    taken = int(operator.accepted[0].step)
    assert (flight.target[:taken] == 0.0).all()
    assert (flight.target[taken:] == WISH).all()
    assert flight.n_steps > taken
    assert flight.line_of_sight_margin.min() >= 0.0
    audit = audit_bag(out / "bag", allow_unfinished=True)
    assert audit.passed, audit.first
