"""The SlewTo action: reached, preempted, canceled, refused."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from typing import Any

import numpy as np
import pytest
import rclpy
from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from geometry_msgs.msg import Quaternion
from node_messages import PERIOD_NS, decode_reference, encode_reference, encode_state, ends, tell
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from spacecraft_gnc_msgs.action import SlewTo
from unique_identifier_msgs.msg import UUID

from spacecraft_gnc import lie
from spacecraft_gnc.loop.protocols import State
from spacecraft_gnc.nodes import _action_server
from spacecraft_gnc.nodes._door import TokenBucket
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
        self.parts: dict[str, Any] = {}
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

    def ask(self, kind: Any, service: str, request: Any) -> Any:
        """Return the future of the answer of a part of the action."""
        if service not in self.parts:
            name = f"slew_to/_action/{service}"
            self.parts[service] = self.client_node.create_client(kind, name)
            self.ros.spin_until(self.parts[service].service_is_ready)
        return self.parts[service].call_async(request)

    def all_of(self, futures: Iterable[Any]) -> list[Any]:
        """Return what comes of futures; not all at once, a queue of DDS holds ten."""
        found = []
        for some in batched(futures, 10):
            self.ros.spin_until(lambda some=some: all(future.done() for future in some))
            found += [future.result() for future in some]
        return found

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
        {"target": Quaternion(x=1e308, y=0.0, z=1e308, w=1e308)},
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


def batched(items: Iterable[Any], size: int) -> Iterator[list[Any]]:
    """Yield lists of ``size`` items, made when they are asked for."""
    iterator = iter(items)
    while some := list(islice(iterator, size)):
        yield some


def identity(**goal: Any) -> Any:
    return SlewTo.Goal(target=Quaternion(w=1.0), **goal)


def no_time_passes(flight: Flight, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let in a burst of targets, and no more."""
    monkeypatch.setattr(flight.governor._door, "_bucket", TokenBucket(20.0, 10, lambda: 0.0))


def test_of_a_hundred_goals_at_once_a_burst_is_let_in_and_the_newest_of_them_wins(
    flight: Flight, monkeypatch: pytest.MonkeyPatch
) -> None:
    no_time_passes(flight, monkeypatch)
    flight.ros.spin_until(flight.client.server_is_ready)
    sent = flight.all_of(flight.client.send_goal_async(identity()) for _ in range(100))
    accepted = [handle for handle in sent if handle.accepted]
    assert len(accepted) == 10
    assert flight.governor.refused == 90
    results = [handle.get_result_async() for handle in accepted]
    flight.ros.spin_until(lambda: sum(future.done() for future in results) == 9)
    assert {future.result().status for future in results[:-1]} == {GoalStatus.STATUS_ABORTED}
    flight.fly(0.0)
    assert flight.result(results[-1])[1].reached


def test_goals_and_results_do_not_stay(flight: Flight, monkeypatch: pytest.MonkeyPatch) -> None:
    flight.governor.trigger_deactivate()
    flight.governor.trigger_cleanup()
    monkeypatch.setattr(_action_server, "_RESULT_KEPT", 1)  # [s]
    flight.governor.trigger_configure()
    flight.governor.trigger_activate()
    server = flight.governor._slews._server
    for _ in range(5):
        flight.send(0.0)
    assert len(server._goal_handles) == len(server._result_futures) == 5
    flight.fly(0.0)
    flight.ros.spin_until(lambda: not server._goal_handles)
    assert not server._result_futures
    assert not server._futures


def test_a_storm_of_cancels_ends_the_goal_once(flight: Flight) -> None:
    _, result = flight.send(0.5)
    requests = [CancelGoal.Request() for _ in range(100)]  # each means all goals
    requests[50].goal_info.stamp.sec = -1
    requests[51].goal_info.stamp.nanosec = (1 << 32) - 1
    requests[52].goal_info.goal_id = UUID(uuid=[7] * 16)
    answers = flight.all_of(flight.ask(CancelGoal, "cancel_goal", one) for one in requests)
    assert len(answers) == 100
    flight.fly(0.1)
    assert flight.result(result)[0] == GoalStatus.STATUS_CANCELED
    _, result = flight.send(0.1)
    flight.fly(0.1)
    assert flight.result(result)[1].reached


def test_results_of_goals_that_there_are_not_and_of_one_goal_too_often(flight: Flight) -> None:
    kind = SlewTo.Impl.GetResultService
    unknown = flight.ask(kind, "get_result", kind.Request(goal_id=UUID(uuid=[9] * 16)))
    flight.ros.spin_until(unknown.done)
    assert unknown.result().status == GoalStatus.STATUS_UNKNOWN
    handle, result = flight.send(0.5)
    request = kind.Request(goal_id=handle.goal_id)
    waiting = flight.governor._slews._server._waiting
    answers = []
    for count in range(2, 32):
        answers.append(flight.ask(kind, "get_result", request))
        flight.ros.spin_until(lambda count=count: sum(waiting.values()) == count)
    flight.ros.spin_until(lambda: sum(future.done() for future in answers) == 27)
    assert flight.governor.refused == 27
    flight.fly(0.5)
    assert flight.result(result)[1].reached
    flight.ros.spin_until(lambda: all(future.done() for future in answers))


def test_a_client_that_vanishes_leaves_its_goal_to_be_flown(flight: Flight) -> None:
    context = rclpy.Context()
    rclpy.init(args=[], context=context, domain_id=flight.ros.nodes_domain())
    executor, node = SingleThreadedExecutor(context=context), Node("gone", context=context)
    executor.add_node(node)
    client = ActionClient(node, SlewTo, "slew_to")

    def both_spin_until(done: Callable[[], bool]) -> None:
        flight.ros.spin_until(lambda: executor.spin_once(timeout_sec=0.0) or done())

    both_spin_until(client.server_is_ready)
    sending = client.send_goal_async(identity())
    both_spin_until(sending.done)
    sending.result().get_result_async()
    both_spin_until(lambda: sum(flight.governor._slews._server._waiting.values()) == 1)
    executor.shutdown()
    client.destroy()
    node.destroy_node()
    rclpy.shutdown(context=context)
    flight.fly(0.2)
    flight.fly(0.0)  # reached: nobody is there to take the result
    _, result = flight.send(0.1)
    flight.fly(0.1)
    assert flight.result(result)[1].reached


def test_whatever_goes_wrong_with_a_request_does_not_leave_the_executor(
    flight: Flight, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: Any) -> None:
        raise ValueError("a defect of the server")

    slews = flight.governor._slews
    with monkeypatch.context() as patch:
        patch.setattr(slews._server, "_handle_accepted_callback", fail)
        flight.send(0.5)
        flight.ros.spin_until(lambda: flight.governor.refused == 1)
    _, result = flight.send(0.1)
    flight.fly(0.1)
    assert flight.result(result)[1].reached
