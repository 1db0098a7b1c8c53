"""A slow governor decides beside the executor; targets are put to it between two decisions."""

from __future__ import annotations

import threading
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import Quaternion
from node_messages import PERIOD_NS, decode_reference, encode_reference, encode_state, tell
from rcl_interfaces.srv import GetParameters
from rclpy.action import ActionClient
from rclpy.node import Node
from spacecraft_gnc_msgs.action import SlewTo

from spacecraft_gnc import lie
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors.pass_through import PassThroughGovernor
from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.loop import Reference, State
from spacecraft_gnc.loop.protocols import GovernorDecision
from spacecraft_gnc.nodes import _worker
from spacecraft_gnc.nodes.reference_governor import GovernorNode
from spacecraft_gnc.signals.attitude import REFERENCE
from spacecraft_gnc.signals.message import stamp_of
from spacecraft_gnc.vehicles.rigid_body import descriptor

PATIENCE = 30.0  # [s] wall: after this a test has failed
ZERO = np.zeros(3)
FORBIDDEN = 1.0  # [rad] from which on a turn about z is inadmissible


class Gated(PassThroughGovernor):
    """Decides when the test lets it; takes no target beyond `FORBIDDEN`."""

    slow = True
    begun: threading.Semaphore
    gate: threading.Semaphore
    threads: list[int]
    error: Exception | None

    def set_target(self, attitude: np.ndarray) -> None:
        self.threads.append(threading.get_ident())
        angle = lie.angle_between(np.eye(3), attitude)
        if angle > FORBIDDEN:
            raise ParameterError(
                f"target: received an attitude {FORBIDDEN - angle:.3g} rad inside zone 'star'; "
                "required at least 0 rad; choose another"
            )
        super().set_target(attitude)

    def reset(self) -> None:
        super().set_target(self._initial)

    def decide(self, state: State) -> GovernorDecision:
        self.threads.append(threading.get_ident())
        self.begun.release()
        assert self.gate.acquire(timeout=PATIENCE)
        if self.error is not None:
            raise self.error
        return super().decide(state)

    @classmethod
    def from_scenario(cls, scenario: Any) -> Any:
        return cls(lie.exp(scenario.governor.target_rotation_vector))

    @classmethod
    def await_decision(cls) -> None:
        assert cls.begun.acquire(timeout=PATIENCE)


@pytest.fixture
def governor(ros: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return an active node around `Gated` that sends its references to the list ``sent``."""
    for name, value in {
        "begun": threading.Semaphore(0),
        "gate": threading.Semaphore(0),
        "threads": [],
        "error": None,
    }.items():
        monkeypatch.setattr(Gated, name, value, raising=False)
    first, *others = descriptor.VEHICLE.governors
    gated = replace(first, build=Lazy(f"{__name__}:Gated.from_scenario"))
    vehicle = replace(descriptor.VEHICLE, governors=(gated, *others))
    monkeypatch.setattr(descriptor, "VEHICLE", vehicle)
    node = ros.add(GovernorNode())
    assert node.trigger_configure().name == "SUCCESS"
    assert node.trigger_activate().name == "SUCCESS"
    node.sent = []
    node._outlets[REFERENCE] = node.sent.append
    yield node
    Gated.gate.release(9)  # no thread outlives its test
    node.trigger_shutdown()


def turn(angle: float) -> np.ndarray:
    return lie.exp(np.array([0.0, 0.0, angle]))


def ask(governor: Any, step: int) -> None:
    tell(
        governor,
        "attitude_state",
        encode_state(stamp_of(step, PERIOD_NS), State(step, turn(0.2), ZERO), ZERO),
    )


def aim(governor: Any, angle: float) -> None:
    target = Reference(turn(angle), ZERO, ZERO)
    tell(governor, "target_attitude", encode_reference((0, 0), 0, target))


def answers(governor: Any) -> list[tuple[int, float]]:
    """Steps answered, and angles of the references."""
    found = [decode_reference(data) for data in governor.sent]
    angles = [lie.angle_between(np.eye(3), reference.attitude) for _, reference in found]
    return [(step, round(angle, 9)) for (step, _), angle in zip(found, angles, strict=True)]


class Client:
    """Sends goals of turns about z."""

    def __init__(self, ros: Any) -> None:
        self.ros = ros
        self.node = ros.add(Node("client"))
        self.action = ActionClient(self.node, SlewTo, "slew_to")
        ros.spin_until(self.action.server_is_ready)

    def send(self, angle: float) -> Any:
        x, y, z, w = lie.to_quaternion_xyzw(turn(angle)).tolist()
        goal = SlewTo.Goal(target=Quaternion(x=x, y=y, z=z, w=w))
        sending = self.action.send_goal_async(goal)
        self.ros.spin_until(sending.done)
        return sending.result().get_result_async()

    def result(self, future: Any) -> tuple[int, Any]:
        self.ros.spin_until(future.done)
        return future.result().status, future.result().result


@pytest.fixture
def client(ros: Any, governor: Any) -> Any:
    client = Client(ros)
    yield client
    client.action.destroy()


def test_the_node_is_responsive_while_it_decides(ros: Any, governor: Any) -> None:
    ask(governor, 0)
    Gated.await_decision()
    client = ros.add(Node("client"))
    service = client.create_client(GetParameters, "reference_governor/get_parameters")
    ros.spin_until(service.service_is_ready)
    answer = service.call_async(GetParameters.Request(names=["governor"]))
    ros.spin_until(answer.done)
    assert answer.result().values[0].string_value == "none"
    assert governor.sent == []
    Gated.gate.release()
    ros.spin_until(lambda: governor.sent)
    assert answers(governor) == [(0, 0.0)]
    assert threading.get_ident() not in Gated.threads


def test_the_latest_state_wins_and_the_others_are_counted(ros: Any, governor: Any) -> None:
    for step in range(4):
        ask(governor, step)
    Gated.gate.release(2)
    ros.spin_until(lambda: len(governor.sent) == 2)
    assert [step for step, _ in answers(governor)] == [0, 3]
    assert governor._skipped == 2
    assert len(Gated.threads) == 2


def test_a_repeated_state_waits_for_its_own_reference(ros: Any, governor: Any) -> None:
    ask(governor, 0)
    Gated.gate.release()
    ros.spin_until(lambda: governor.sent)
    ask(governor, 1)
    ask(governor, 1)
    assert len(governor.sent) == 1
    Gated.gate.release()
    ros.spin_until(lambda: len(governor.sent) == 2)
    ask(governor, 1)
    assert governor.sent[1] == governor.sent[2]


def test_a_target_that_comes_during_a_decision_counts_from_the_next(
    ros: Any, governor: Any
) -> None:
    ask(governor, 0)
    Gated.await_decision()
    aim(governor, 0.5)
    ask(governor, 1)
    Gated.gate.release(2)
    ros.spin_until(lambda: len(governor.sent) == 2)
    assert answers(governor) == [(0, 0.0), (1, 0.5)]
    assert len(set(Gated.threads)) == 1  # never two at a time


def test_so_does_a_goal_and_it_preempts_only_where_it_is_taken(
    ros: Any, governor: Any, client: Client
) -> None:
    first = client.send(0.5)
    ros.spin_until(lambda: governor._slews._slew is not None)
    ask(governor, 0)
    Gated.await_decision()
    refused = client.send(1.5)
    second = client.send(-0.5)
    ros.spin_until(lambda: len(governor._slews._asked) == 2)
    Gated.gate.release()
    status, answer = client.result(refused)
    assert status == GoalStatus.STATUS_ABORTED
    assert answer.message.startswith("refused: target: received an attitude -0.5 rad inside zone")
    status, answer = client.result(first)
    assert status == GoalStatus.STATUS_ABORTED
    assert "preempted by a newer target" in answer.message
    assert answers(governor) == [(0, 0.5)]
    assert not second.done()
    governor.trigger_deactivate()
    assert "stopped" in client.result(second)[1].message


def test_an_inadmissible_target_leaves_the_older_one(
    ros: Any, governor: Any, client: Client
) -> None:
    first = client.send(0.5)
    ros.spin_until(lambda: governor._slews._slew is not None)
    aim(governor, 1.5)
    ros.spin_until(lambda: governor.refused)
    Gated.gate.release()
    ask(governor, 0)
    ros.spin_until(lambda: governor.sent)
    assert answers(governor) == [(0, 0.5)]
    assert not first.done()


def test_goals_that_wait_for_an_answer_end_with_the_node(
    ros: Any, governor: Any, client: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_worker, "_PATIENCE", 0.0)
    ask(governor, 0)
    Gated.await_decision()
    waiting = client.send(0.5)
    ros.spin_until(lambda: governor._slews._asked)
    assert governor.trigger_deactivate().name == "SUCCESS"
    assert "stopped" in client.result(waiting)[1].message
    assert governor.trigger_activate().name == "FAILURE"
    assert "a decision of the last one goes on" in str(governor.failure)
    Gated.gate.release()
    worker = governor._worker
    ros.spin_until(lambda: not worker._thread.is_alive())
    assert governor.trigger_activate().name == "SUCCESS"
    assert governor.sent == []
    assert client.result(client.send(1.5))[1].message.startswith("refused: ")


def test_an_inactive_governor_takes_no_goal(governor: Any, client: Client) -> None:
    governor.trigger_deactivate()
    _, answer = client.result(client.send(0.5))
    assert "is not active, as the graph starts or ends" in answer.message
    assert "required an active one; try again later" in answer.message


def test_an_exception_in_the_thread_ends_the_node(ros: Any, governor: Any) -> None:
    Gated.error = ZeroDivisionError("a defect")
    ask(governor, 0)
    Gated.gate.release()
    ros.spin_until(lambda: governor.finished)
    assert governor.failure is Gated.error
    assert governor.sent == []
