"""Transitions, parameters and services of the lifecycle nodes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.srv import DescribeParameters, GetParameters, SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter

from spacecraft_gnc.launcher import domain
from spacecraft_gnc.nodes._node import GncNode
from spacecraft_gnc.nodes.nmpc_controller import ControllerNode
from spacecraft_gnc.nodes.plant import PlantNode
from spacecraft_gnc.nodes.recorder import RecorderNode
from spacecraft_gnc.nodes.reference_governor import GovernorNode

ALL = [PlantNode, ControllerNode, GovernorNode, RecorderNode]


def call(ros: Any, client_node: Node, service: type, name: str, request: Any) -> Any:
    client = client_node.create_client(service, name)
    ros.spin_until(client.service_is_ready)
    answer = client.call_async(request)
    ros.spin_until(answer.done)
    return answer.result()


@pytest.mark.parametrize("node_type", ALL)
def test_up_and_down_twice(ros: Any, node_type: type[GncNode], tmp_path: Path) -> None:
    node = ros.add(node_type())
    for _ in range(2):
        for transition in ("configure", "activate", "deactivate", "cleanup"):
            result = getattr(node, f"trigger_{transition}")()
            assert result.name == "SUCCESS", (transition, node.failure)
            assert node.active == (transition == "activate")
        assert node.resolve_topic_name("attitude_state") not in {
            endpoint.topic_name for endpoint in [*node.publishers, *node.subscriptions]
        }
    assert node.trigger_shutdown().name == "SUCCESS"
    assert not (tmp_path / "bag").exists()  # nothing was recorded, so nothing is left behind


def test_over_services(ros: Any) -> None:
    ros.add(GovernorNode())
    client = ros.add(Node("client"))
    for number, label in ((1, "inactive"), (3, "active"), (4, "inactive"), (2, "unconfigured")):
        request = ChangeState.Request()
        request.transition.id = number
        name = "reference_governor/change_state"
        assert call(ros, client, ChangeState, name, request).success
        state = call(ros, client, GetState, "reference_governor/get_state", GetState.Request())
        assert state.current_state.label == label


def test_parameters_are_declared_with_unit_range_and_description(ros: Any) -> None:
    node = ros.add(PlantNode())
    client = ros.add(Node("client"))
    node.trigger_configure()
    names = ["command_timeout", "inertia", "peers"]
    request = DescribeParameters.Request(names=names)
    found = call(ros, client, DescribeParameters, "plant/describe_parameters", request).descriptors
    assert [d.name for d in found] == names
    assert "[s]" in found[0].description
    assert 0.0 < found[0].floating_point_range[0].from_value < 1e-300
    assert "9 numbers" in found[1].additional_constraints
    assert all(d.read_only for d in found)
    request = GetParameters.Request(names=["time_step", "use_sim_time", "max_held_steps"])
    values = call(ros, client, GetParameters, "plant/get_parameters", request).values
    assert values[0].double_value == 0.4
    assert values[1].bool_value
    assert values[2].integer_value == 5
    changed = Parameter("duration", value=3.0).to_parameter_msg()
    request = SetParameters.Request(parameters=[changed])
    result = call(ros, client, SetParameters, "plant/set_parameters", request).results[0]
    assert not result.successful
    assert "read-only" in result.reason


def test_a_second_plant_is_refused(ros: Any) -> None:
    lock = domain.claim(domain.CLOCK, ros.nodes_domain(), {"plant": "/first"})
    node = ros.add(PlantNode())
    assert node.trigger_configure().name == "FAILURE"
    assert "/first" in str(node.failure)
    lock.release()
    assert node.trigger_configure().name == "SUCCESS"
