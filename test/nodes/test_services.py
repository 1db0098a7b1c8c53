"""Requests that make no sense, or that nobody but the launcher should make: each is answered."""

from __future__ import annotations

import math
from typing import Any

import pytest
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from rclpy.node import Node
from type_description_interfaces.srv import GetTypeDescription

from spacecraft_gnc.launcher.environment import SUPERVISED
from spacecraft_gnc.nodes._node import GncNode
from spacecraft_gnc.nodes.plant import PlantNode
from spacecraft_gnc.nodes.reference_governor import GovernorNode

UNKNOWN_TYPE = Parameter(name="duration", value=ParameterValue(type=99))
READ_ONLY = Parameter(name="start_type_description_service", value=ParameterValue(type=1))
UNDECLARED = Parameter(name="", value=ParameterValue(type=8, double_array_value=[math.nan] * 999))
WALL_TIME = Parameter(name="use_sim_time", value=ParameterValue(type=1, bool_value=False))
CONFIGURE, CLEANUP, ACTIVATE, DEACTIVATE, SHUTDOWN = 1, 2, 3, 4, 7


class Asked:
    """A node, and somebody who asks it for things."""

    def __init__(self, ros: Any, node_type: type[GncNode]) -> None:
        self.ros = ros
        self.node = ros.add(node_type())
        self.client = ros.add(Node("client"))

    def call(self, kind: type, service: str, request: Any) -> Any:
        client = self.client.create_client(kind, f"{self.node.ROLE}/{service}")
        self.ros.spin_until(client.service_is_ready)
        answer = client.call_async(request)
        self.ros.spin_until(answer.done)
        return answer.result()

    def set(self, *parameters: Parameter) -> list[tuple[bool, str]]:
        request = SetParameters.Request(parameters=parameters)
        results = self.call(SetParameters, "set_parameters", request).results
        return [(result.successful, result.reason) for result in results]

    def change(self, number: int, label: str = "") -> bool:
        request = ChangeState.Request()
        request.transition.id, request.transition.label = number, label
        return self.call(ChangeState, "change_state", request).success

    @property
    def state(self) -> str:
        return self.call(GetState, "get_state", GetState.Request()).current_state.label


@pytest.fixture(params=[PlantNode, GovernorNode])
def asked(ros: Any, request: Any) -> Asked:
    return Asked(ros, request.param)


@pytest.fixture
def launched(ros: Any, monkeypatch: pytest.MonkeyPatch) -> Asked:
    monkeypatch.setenv(SUPERVISED, "1")
    return Asked(ros, PlantNode)


def test_each_parameter_that_cannot_be_set_is_answered_with_the_reason(asked: Asked) -> None:
    asked.node.trigger_configure()
    results = asked.set(READ_ONLY, UNKNOWN_TYPE, UNDECLARED)
    assert [successful for successful, _ in results] == [False, False, False]
    assert "read-only" in results[0][1]
    assert results[1][1] == results[2][1] == "99 is not a valid Parameter.Type"
    assert asked.node.refused == 1
    assert "read-only" in asked.set(WALL_TIME)[0][1]
    assert asked.node.get_parameter("use_sim_time").value
    assert "required one that is declared" in asked.set(UNDECLARED)[0][1]
    assert not asked.node.has_parameter("")
    request = SetParametersAtomically.Request(parameters=[READ_ONLY, UNKNOWN_TYPE])
    result = asked.call(SetParametersAtomically, "set_parameters_atomically", request).result
    assert (result.successful, result.reason) == (False, "99 is not a valid Parameter.Type")
    assert asked.node.refused == 2


def test_before_it_is_configured_too(asked: Asked) -> None:
    assert asked.set(UNKNOWN_TYPE) == [(False, "99 is not a valid Parameter.Type")]
    assert asked.node.refused == 1


@pytest.mark.parametrize(
    ("kind", "service", "field", "answer"),
    [
        (GetParameters, "get_parameters", "names", "values"),
        (GetParameterTypes, "get_parameter_types", "names", "types"),
        (DescribeParameters, "describe_parameters", "names", "descriptors"),
        (ListParameters, "list_parameters", "prefixes", "result"),
    ],
)
def test_long_lists_are_not_worked_through(
    ros: Any, kind: type, service: str, field: str, answer: str
) -> None:
    asked = Asked(ros, PlantNode)
    request = kind.Request(**{field: ["use_sim_time"] * 20_000})
    found = getattr(asked.call(kind, service, request), answer)
    assert not getattr(found, "names", found)
    assert asked.node.refused == 1
    request = kind.Request(**{field: ["use_sim_time"] * 3})
    found = getattr(asked.call(kind, service, request), answer)
    assert getattr(found, "names", found)


def test_a_long_list_of_parameters_is_refused_one_by_one(ros: Any) -> None:
    asked = Asked(ros, PlantNode)
    results = asked.set(*[READ_ONLY] * 1001)
    assert len(results) == 1001
    assert {successful for successful, _ in results} == {False}
    long = ParameterValue(type=8, double_array_value=[0.0] * 1001)
    ((successful, reason),) = asked.set(Parameter(name="inertia", value=long))
    assert not successful
    assert reason.startswith("double_array_value: received a length of 1001; required 1000")
    assert asked.node.refused == 2


def test_types_that_are_not_there(asked: Asked) -> None:
    for name, refused in (("no/such", 0), ("no/such" * 1000, 1)):
        request = GetTypeDescription.Request(type_name=name, type_hash="RIHS01_")
        answer = asked.call(GetTypeDescription, "get_type_description", request)
        assert not answer.successful
        assert asked.node.refused == refused
    assert answer.failure_reason.startswith("type_name: received a length of 7000; required 1000")


def test_a_transition_that_there_is_not_is_answered(asked: Asked) -> None:
    for number in (DEACTIVATE, 0, 8, 99, 255):
        assert not asked.change(number)
    assert asked.node.refused == 5
    assert not asked.change(CONFIGURE, "no such label")
    assert asked.state == "unconfigured"


def test_a_node_started_by_hand_changes_its_state_for_everybody(asked: Asked) -> None:
    for number, state in (
        (CONFIGURE, "inactive"),
        (ACTIVATE, "active"),
        (DEACTIVATE, "inactive"),
        (CLEANUP, "unconfigured"),
    ):
        assert asked.change(number)
        assert asked.state == state


def test_a_node_of_a_launch_goes_up_and_not_down(launched: Asked) -> None:
    refused = 0
    for number, state in ((0, "unconfigured"), (CONFIGURE, "inactive"), (ACTIVATE, "active")):
        if number:
            assert launched.change(number)
            assert launched.change(number)  # a stranger may have asked before the launcher
        assert launched.state == state
        refused = launched.node.refused
        for other in (CLEANUP, DEACTIVATE, SHUTDOWN, 99):
            assert not launched.change(other)
        assert not launched.change(ACTIVATE, "deactivate")  # rclpy would look at the label
        assert launched.node.refused == refused + 5
        assert launched.state == state
    assert launched.node.failure is None
    assert launched.node.trigger_deactivate().name == "SUCCESS"  # it may do so by itself


def test_a_node_of_a_launch_is_not_activated_before_it_is_configured(launched: Asked) -> None:
    assert not launched.change(ACTIVATE)
    assert launched.state == "unconfigured"


def test_the_scenario_may_have_a_foreign_transition_end_the_run(
    launched: Asked, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert launched.change(CONFIGURE)
    launcher = launched.node.scenario.launcher
    monkeypatch.setitem(launcher.__dict__, "on_foreign_transition", "stop")
    assert not launched.change(DEACTIVATE)
    assert launched.node.finished
    assert "plant: transition deactivate was requested by somebody else" in str(
        launched.node.failure
    )
