"""A governor in the graph: the same bytes every time; targets in flight, taken and refused."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rclpy
from geometry_msgs.msg import Quaternion
from graph.comparison import CASE1, assert_equals_simulation
from graph.killing import kill_governor_between_steps
from graph.test_flight import payloads
from node_messages import ends
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from spacecraft_gnc_msgs.action import SlewTo
from spacecraft_gnc_msgs.msg import GovernorStatus

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.analysis.reader import read_flight
from spacecraft_gnc.audit.ledger import Check
from spacecraft_gnc.launcher.launcher import Launcher
from spacecraft_gnc.launcher.outcome import Interrupted
from spacecraft_gnc.signals.attitude import GOVERNOR_STATUS, TARGET, at_rest
from spacecraft_gnc.signals.graph import DIAGNOSTICS, GOVERNOR

pytestmark = pytest.mark.graph

KALABIC = CASE1.parent / "kalabic2014_governor.yaml"
COMPOSED = "launcher.composed=true"
SHORT = "plant.duration=12.0"
LONG = "plant.duration=4000.0"  # [s]: more than the slews take; the launch is ended after them
PATIENCE = 60.0  # [s] wall: after this a test has failed
LIMIT = 0.02  # [N m]


def about_x(degrees: float) -> np.ndarray:
    return lie.exp(np.array([math.radians(degrees), 0.0, 0.0]))


class Operator:
    """Commands targets while the graph flies, then ends the flight."""

    def __init__(self) -> None:
        self.first: Any = None
        self.refused: Any = None
        self.second: Any = None
        self.diagnostics: list[Any] = []
        self.admissible: list[bool] = []
        self.feedback: dict[str, list[Any]] = {}

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
        self.action = ActionClient(self.node, SlewTo, "slew_to")
        assert self.action.wait_for_server(PATIENCE)
        topic = self.node.create_publisher(*ends(TARGET))
        listen = self.node.create_subscription
        for signal, take in ((GOVERNOR_STATUS, self.on_status), (DIAGNOSTICS, self.on_diagnostics)):
            kind, name, qos = ends(signal)
            listen(kind, name, take, qos)
        first = self.send("first", about_x(40.0))
        self.spin(lambda: self.feedback["first"])
        self.refused = self.result(self.send("refused", about_x(75.0)))
        target = TARGET.encode((0, 0), 0, at_rest(about_x(75.0)))
        self.spin(topic.get_subscription_count)
        topic.publish(target)
        self.spin(lambda: any("rejected" in d.message for d in self.diagnostics))
        # neither has changed anything: the first slew goes on
        seen = len(self.feedback["first"])
        self.spin(lambda: len(self.feedback["first"]) > seen + 1)
        second = self.send("second", about_x(-20.0))
        self.first = self.result(first)
        self.second = self.result(second)
        self.action.destroy()

    def on_status(self, message: GovernorStatus) -> None:
        self.admissible.append(message.admissible)

    def on_diagnostics(self, message: Any) -> None:
        self.diagnostics += message.status

    def spin(self, done: Callable[[], Any]) -> None:
        patience = time.monotonic() + PATIENCE
        while not done():
            assert time.monotonic() < patience, "never came true"
            self.executor.spin_once(timeout_sec=0.05)

    def send(self, name: str, target: np.ndarray) -> Any:
        x, y, z, w = lie.to_quaternion_xyzw(target).tolist()
        feedback = self.feedback.setdefault(name, [])
        goal = SlewTo.Goal(target=Quaternion(x=x, y=y, z=z, w=w), tolerance=math.radians(0.5))
        sending = self.action.send_goal_async(goal, lambda m: feedback.append(m.feedback))
        self.spin(sending.done)
        assert sending.result().accepted
        return sending.result().get_result_async()

    def result(self, future: Any) -> Any:
        self.spin(future.done)
        return future.result().result


def test_two_launches_under_a_governor_are_identical(graph: Any) -> None:
    first = graph.fly(SHORT, COMPOSED, scenario=KALABIC)
    second = graph.fly(SHORT, COMPOSED, scenario=KALABIC)
    third = graph.fly(SHORT, scenario=KALABIC)
    assert graph.exit_codes == dict.fromkeys(graph.exit_codes, 0)
    expected = payloads(first / "bag")
    assert len(expected["/governor_status"]) == 121
    assert payloads(second / "bag") == expected
    assert payloads(third / "bag") == expected
    assert_equals_simulation(first / "bag", SHORT, scenario=KALABIC)
    assert 0.0 < read_flight(first / "bag").trajectory.alpha.max() < 1.0


def test_targets_in_flight(graph: Any, at: Any) -> None:
    operator = Operator()
    out: Path = graph.folder / "slews"
    with pytest.raises(Interrupted):
        graph.fly(LONG, scenario=KALABIC, display=at(1, operator), out=out)
    assert not operator.refused.reached
    assert operator.refused.message.startswith("refused: target: received an attitude with")
    assert "zone 'earth'; required at least 0.1 deg at rest" in operator.refused.message
    assert not operator.first.reached
    assert "preempted by a newer target" in operator.first.message
    assert operator.second.reached
    assert operator.second.final_error < math.radians(0.5)
    assert operator.second.step > operator.first.step
    alphas = [f.alpha for f in operator.feedback["second"]]
    assert all(0.0 <= alpha <= 1.0 for alpha in alphas)
    assert operator.feedback["second"][-1].error_angle < operator.feedback["second"][0].error_angle
    rejections = [d.message for d in operator.diagnostics if "rejected" in d.message]
    assert "zone 'earth'" in rejections[0]
    assert all(operator.admissible)
    flown = read_flight(out / "bag").trajectory
    assert np.nanmax(np.linalg.norm(flown.torque, axis=1)) <= LIMIT * (1.0 + 1e-9)
    assert lie.angle_between(flown.reference[-1], about_x(-20.0)) < 1e-9
    assert lie.angle_between(flown.target[-1], about_x(-20.0)) < 1e-9
    decisions = audited(out)
    assert decisions.steps >= flown.n_steps
    assert decisions.note.startswith("targets taken in flight: ")


def audited(out: Path) -> Check:
    """Audit a flight and return the line of the governor."""
    audit = audit_bag(out / "bag", allow_unfinished=True)
    assert audit.passed, audit.first
    return next(check for check in audit.checks if check.name == "decision of the governor")


def test_a_governor_restarted_in_flight_goes_on_with_its_moving_reference(
    graph: Any, at: Any
) -> None:
    """The reference follows from the step alone: no target is announced, and nothing jumps."""
    patient = "plant.command_timeout=120.0"  # a busy machine may take long to start a process
    changes = (patient, "launcher.on_node_death=restart")
    scenario = CASE1.with_name("turning_reference.yaml")
    out = graph.fly(*changes, scenario=scenario, display=at(60, kill_governor_between_steps))
    assert graph.outcome.restarts == (GOVERNOR,)
    assert audited(out).note == ""
    assert_equals_simulation(out / "bag", *changes, scenario=scenario)
