"""What must not reach a core does not, is counted, and is told about."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from node_messages import PERIOD_NS, encode_reference, encode_state, tell
from rclpy.duration import Duration
from rclpy.serialization import serialize_message
from spacecraft_gnc_msgs.msg import AttitudeReference, AttitudeState, TorqueCommand

from spacecraft_gnc import lie
from spacecraft_gnc.loop.protocols import Reference, State
from spacecraft_gnc.nodes._node import _MOST_REPEATS, GncNode
from spacecraft_gnc.nodes.nmpc_controller import ControllerNode
from spacecraft_gnc.nodes.plant import PlantNode
from spacecraft_gnc.nodes.reference_governor import GovernorNode
from spacecraft_gnc.signals.attitude import REFERENCE
from spacecraft_gnc.signals.message import stamp_of
from spacecraft_gnc.vehicles.rigid_body.signals import TORQUE

ZERO = np.zeros(3)
IDENTITY = np.eye(3)


def started(node: GncNode) -> Any:
    node.trigger_configure()
    node.trigger_activate()
    assert node.active, node.failure
    node._called = True  # as if the peers, which no test here needs, were matched
    return node


def state(step: int, attitude: np.ndarray = IDENTITY, momentum: np.ndarray = ZERO) -> bytes:
    return encode_state(stamp_of(step, PERIOD_NS), State(step, attitude, momentum), ZERO)


def reference(step: int, attitude: np.ndarray = IDENTITY) -> bytes:
    return encode_reference(stamp_of(step, PERIOD_NS), step, Reference(attitude, ZERO, ZERO))


def with_nan(data: bytes, message_type: type, field: str) -> bytes:
    from rclpy.serialization import deserialize_message

    message = deserialize_message(data, message_type)
    value = getattr(message, field)
    if hasattr(value, "x"):
        value.x = math.nan
    else:
        value[4] = math.nan
    return bytes(serialize_message(message))


MIRROR = np.diag([1.0, 1.0, -1.0])
BAD_STATES: dict[str, Callable[[], bytes]] = {
    "NaN attitude": lambda: with_nan(state(3), AttitudeState, "attitude"),
    "NaN momentum": lambda: with_nan(state(3), AttitudeState, "angular_momentum"),
    "NaN rate": lambda: with_nan(state(3), AttitudeState, "angular_velocity"),
    "scaled": lambda: state(3, 1.01 * IDENTITY),
    "mirrored": lambda: state(3, MIRROR),
    "old": lambda: state(1),
    "another type": lambda: reference(3)[:40],
}


@pytest.mark.parametrize("bad", BAD_STATES)
def test_controller_and_governor_refuse_bad_states(ros: Any, bad: str) -> None:
    controller = started(ros.add(ControllerNode()))
    governor = started(ros.add(GovernorNode()))
    for node in (controller, governor):
        tell(node, "attitude_state", state(2))
        tell(node, "attitude_state", state(2))  # one that joins in mid-flight answers the repeat
        tell(node, "attitude_state", BAD_STATES[bad]())
        assert node.refused == 1
    assert controller._step == 2
    assert governor._step == 2
    tell(governor, "attitude_state", state(3))  # life goes on
    assert governor._step == 3
    assert governor.refused == 1


@pytest.mark.parametrize("bad", ["NaN", "mirrored", "old"])
def test_controller_refuses_bad_references(ros: Any, bad: str) -> None:
    controller = started(ros.add(ControllerNode()))
    tell(controller, "attitude_reference", reference(2))
    data = {
        "NaN": lambda: with_nan(reference(3), AttitudeReference, "attitude"),
        "mirrored": lambda: reference(3, MIRROR),
        "old": lambda: reference(1),
    }[bad]()
    tell(controller, "attitude_reference", data)
    assert controller.refused == 1
    assert controller._reference_step == 2


def test_governor_refuses_a_bad_target(ros: Any) -> None:
    governor = started(ros.add(GovernorNode()))
    before = governor._governor.target
    tell(governor, "target_attitude", reference(0, MIRROR))
    assert governor.refused == 1
    assert governor._governor.target is before
    turned = lie.exp(np.array([0.0, 0.1, 0.0]))
    tell(governor, "target_attitude", reference(0, turned))
    assert np.array_equal(governor._governor.target, turned)


def test_a_target_before_the_flight_is_refused_and_told(
    ros: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    governor = ros.add(GovernorNode())
    governor.trigger_configure()
    warned: list[str] = []
    monkeypatch.setattr(governor, "diagnose", lambda *told: warned.append(told[1]))
    before = governor._governor.target
    tell(governor, "target_attitude", reference(0, lie.exp(np.array([0.0, 0.1, 0.0]))))
    assert governor.refusals == {"target_attitude/values": 1}
    assert "received while the reference_governor is not active" in warned[0]
    assert governor._governor.target is before


def test_plant_refuses_bad_torques(ros: Any) -> None:
    plant = ros.add(PlantNode())
    started(plant)
    plant._awaited.clear()
    plant._pace.begin(0.0)
    good = TorqueCommand(step=0)
    good.torque.x = 0.01
    bad = TorqueCommand(step=0, source=9)
    nan = TorqueCommand(step=0)
    nan.torque.y = math.nan
    for message in (bad, nan, TorqueCommand(step=5)):
        tell(plant, "torque_command", serialize_message(message))
    assert plant.refused == 3
    assert plant.step == 0
    tell(plant, "torque_command", serialize_message(good))
    assert plant.step == 1
    tell(plant, "torque_command", serialize_message(good))  # the same once more: no harm, no step
    assert plant.step == 1
    assert plant.refused == 3


def test_a_repeated_state_is_answered_by_the_same_bytes(ros: Any) -> None:
    controller = started(ros.add(ControllerNode()))
    sent: list[bytes] = []
    controller._outlets[TORQUE] = sent.append
    tell(controller, "attitude_reference", reference(0))
    tell(controller, "attitude_state", state(0))
    tell(controller, "attitude_state", state(0))
    assert len(sent) == 2
    assert sent[0] == sent[1]


@pytest.mark.parametrize(("before_end", "answers"), [(1, 1), (0, 0)])
def test_the_last_state_has_no_step_to_make(ros: Any, before_end: int, answers: int) -> None:
    controller = started(ros.add(ControllerNode()))
    sent: list[bytes] = []
    controller._outlets[TORQUE] = sent.append
    step = controller.window.n_steps - before_end
    controller.is_unheard = lambda _: False  # one that joins in mid-flight would wait
    tell(controller, "attitude_state", state(step))
    tell(controller, "attitude_reference", reference(step))
    assert len(sent) == answers


class Readiness:
    """Outlet of a node's readiness whose readers acknowledge it when they are told to."""

    def __init__(self) -> None:
        self.is_acknowledged = False
        self.publisher = self

    def wait_for_all_acked(self, within: Duration) -> bool:
        assert within == Duration()
        return self.is_acknowledged


@pytest.mark.parametrize(("step", "waits"), [(0, False), (4, True)])
def test_who_joins_in_mid_flight_answers_once_it_is_heard(ros: Any, step: int, waits: bool) -> None:
    """The first answers would be heard by all but the recorder, which finds a new node last."""
    controller = started(ros.add(ControllerNode()))
    governor = started(ros.add(GovernorNode()))
    controller._ready, governor._ready = said = Readiness(), Readiness()
    torques: list[bytes] = []
    references: list[bytes] = []
    controller._outlets[TORQUE] = torques.append
    governor._outlets[REFERENCE] = references.append
    tell(controller, "attitude_reference", reference(step))
    for _ in range(3):
        tell(controller, "attitude_state", state(step))
        tell(governor, "attitude_state", state(step))
    if waits:
        assert torques == references == []
        for ready in said:
            ready.is_acknowledged = True
        tell(controller, "attitude_state", state(step))
        tell(governor, "attitude_state", state(step))
    assert len(torques) == len(references) == (1 if waits else 3)  # an answer to each repeat


def test_who_is_not_matched_yet_is_not_heard(ros: Any) -> None:
    governor = started(ros.add(GovernorNode()))
    references: list[bytes] = []
    governor._outlets[REFERENCE] = references.append
    governor._called = False  # and nobody has anything to acknowledge
    for _ in range(3):
        tell(governor, "attitude_state", state(4))
    assert references == []
    governor._called = True
    tell(governor, "attitude_state", state(4))
    assert len(references) == 1


def test_who_is_never_matched_answers_in_the_end(ros: Any) -> None:
    governor = started(ros.add(GovernorNode()))
    references: list[bytes] = []
    governor._outlets[REFERENCE] = references.append
    governor._called = False
    asked = 0
    while not references:
        tell(governor, "attitude_state", state(4))
        asked += 1
    assert asked == _MOST_REPEATS + 1
