"""The SlewTo action: reached, preempted, canceled, refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import Quaternion
from node_messages import PERIOD_NS, decode_reference, encode_reference, encode_state, ends, tell
from rclpy.action import ActionClient
from rclpy.node import Node
from spacecraft_gnc_msgs.action import SlewTo

from spacecraft_gnc import lie
from spacecraft_gnc.loop.protocols import State
from spacecraft_gnc.nodes._node import _MOST_REPEATS
from spacecraft_gnc.nodes.reference_governor import GovernorNode
from spacecraft_gnc.signals.attitude import ACCEPTED_TARGET
from spacecraft_gnc.signals.message import stamp_of

ZERO = np.zeros(3)


class Flight:
    """A governor, a client, and states made up by the test."""

    def __init__(self, ros: Any) -> None:
        self.ros = ros
        self.governor = ros.add(GovernorNode())
        self.client_node = ros.add(Node("client"))
        assert self.governor.trigger_configure().name == "SUCCESS"
        assert self.governor.trigger_activate().name == "SUCCESS"
        self.client = ActionClient(self.client_node, SlewTo, "slew_to")
        self.feedback: list[SlewTo.Feedback] = []
        self.accepted: list[tuple[int, float]] = []
        kind, topic, qos = ends(ACCEPTED_TARGET)
        self.client_node.create_subscription(kind, topic, self._note_target, qos, raw=True)
        self.step = -1

    def send(self, angle: float, **goal: Any) -> tuple[Any, Any]:
        """Command a turn about z; return goal handle and future of the result."""
        self.ros.spin_until(self.client.server_is_ready)
        x, y, z, w = lie.to_quaternion_xyzw(turn(angle)).tolist()
        target = goal.pop("target", Quaternion(x=x, y=y, z=z, w=w))
        sending = self.client.send_goal_async(
            SlewTo.Goal(target=target, **goal),
            feedback_callback=lambda m: self.feedback.append(m.feedback),
        )
        self.ros.spin_until(sending.done)
        handle = sending.result()
        assert handle.accepted
        return handle, handle.get_result_async()

    def fly(self, angle: float, rate: float = 0.0) -> None:
        self.step += 1
        data = encode_state(
            stamp_of(self.step, PERIOD_NS),
            State(self.step, turn(angle), ZERO),
            np.array([0.0, 0.0, rate]),
        )
        tell(self.governor, "attitude_state", data)

    def _note_target(self, data: bytes) -> None:
        step, reference = decode_reference(data)
        self.accepted.append((step, float(lie.log(reference.attitude)[2])))

    def result(self, future: Any) -> tuple[int, Any]:
        self.ros.spin_until(future.done)
        return future.result().status, future.result().result


def turn(angle: float) -> np.ndarray:
    return lie.exp(np.array([0.0, 0.0, angle]))


@pytest.fixture
def flight(ros: Any) -> Any:
    flight = Flight(ros)
    yield flight
    flight.client.destroy()
    flight.governor.trigger_shutdown()


def test_reached(flight: Flight) -> None:
    _, result = flight.send(0.5)
    flight.ros.spin_until(lambda: flight.governor._slews._slew is not None)
    assert np.allclose(flight.governor._governor.target, turn(0.5), atol=1e-15)
    for _ in range(21):
        flight.fly(0.2)
    flight.ros.spin_until(lambda: len(flight.feedback) == 3)
    assert [f.step for f in flight.feedback] == [0, 10, 20]
    assert flight.feedback[0].error_angle == pytest.approx(0.3)
    assert flight.feedback[0].alpha == 1.0
    flight.fly(0.5, rate=0.1)  # passing through is not arriving
    flight.fly(0.5 + 1e-5)
    status, answer = flight.result(result)
    assert status == GoalStatus.STATUS_SUCCEEDED
    assert answer.reached
    assert answer.final_error == pytest.approx(1e-5)
    assert answer.step == 22


def test_a_newer_goal_preempts(flight: Flight) -> None:
    _, first = flight.send(0.5)
    _, second = flight.send(-0.5)
    status, answer = flight.result(first)
    assert status == GoalStatus.STATUS_ABORTED
    assert "preempted" in answer.message
    flight.fly(-0.5)
    assert flight.result(second)[1].reached


def test_canceled_holds_the_target(flight: Flight) -> None:
    handle, result = flight.send(0.5)
    canceling = handle.cancel_goal_async()
    flight.ros.spin_until(canceling.done)
    flight.fly(0.1)
    status, answer = flight.result(result)
    assert status == GoalStatus.STATUS_CANCELED
    assert not answer.reached
    assert np.allclose(flight.governor._governor.target, turn(0.5), atol=1e-15)


def test_a_target_on_the_topic_replaces_the_goal(flight: Flight) -> None:
    from spacecraft_gnc.loop.protocols import Reference

    _, result = flight.send(0.5)
    target = Reference(turn(0.1), ZERO, ZERO)
    tell(flight.governor, "target_attitude", encode_reference((0, 0), 0, target))
    status, answer = flight.result(result)
    assert status == GoalStatus.STATUS_ABORTED
    assert "target_attitude" in answer.message


def test_every_target_taken_is_told_with_the_step_that_it_counts_from(flight: Flight) -> None:
    flight.fly(0.0)
    flight.send(0.5)
    flight.fly(0.0)
    flight.fly(0.0)
    flight.send(-0.2)
    _, refused = flight.send(0.1, target=Quaternion(w=0.0))
    flight.result(refused)
    flight.fly(0.0)
    flight.ros.spin_until(lambda: len(flight.accepted) == 2)
    assert flight.accepted == [(1, pytest.approx(0.5)), (3, pytest.approx(-0.2))]
    flight.governor.trigger_deactivate()
    flight.governor.trigger_activate()  # it is at the scenario's target again
    for _ in range(_MOST_REPEATS + 2):  # it waits for a recorder, which never comes, to find it
        flight.fly(0.0)
        flight.step -= 1
    flight.ros.spin_until(lambda: len(flight.accepted) == 3)
    assert flight.accepted[2] == (4, 0.0)


def test_without_a_slew_no_target_is_told(flight: Flight) -> None:
    flight.fly(0.0)
    flight.governor.trigger_deactivate()
    flight.governor.trigger_activate()
    flight.step = -1
    flight.fly(0.0)
    flight.send(0.5)
    flight.fly(0.0)
    flight.ros.spin_until(lambda: bool(flight.accepted))
    assert flight.accepted == [(1, pytest.approx(0.5))]


def test_deactivation_aborts(flight: Flight) -> None:
    _, result = flight.send(0.5)
    flight.governor.trigger_deactivate()
    assert "stopped" in flight.result(result)[1].message


@pytest.mark.parametrize(
    "goal",
    [
        {"target": Quaternion(x=0.0, y=0.0, z=0.0, w=0.0)},
        {"target": Quaternion(x=math.nan, y=0.0, z=0.0, w=1.0)},
        {"target": Quaternion(x=0.0, y=0.0, z=1.0, w=1.0)},
        {"tolerance": -1.0},
        {"tolerance": math.nan},
    ],
)
def test_goals_that_make_no_sense_are_refused_with_the_reason(
    flight: Flight, goal: dict[str, Any]
) -> None:
    before = flight.governor._governor.target
    _, result = flight.send(0.5, **goal)
    status, answer = flight.result(result)
    assert status == GoalStatus.STATUS_ABORTED
    assert "required" in answer.message
    assert flight.governor._governor.target is before
