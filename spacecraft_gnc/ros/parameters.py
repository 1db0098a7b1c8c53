"""ROS 2 parameters of a node: read from the command line, checked and declared by the schema."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node
from rclpy.parameter import Parameter

from spacecraft_gnc.parameters.checked import plain_values
from spacecraft_gnc.parameters.parameter import Kind, ParameterSpec, Value
from spacecraft_gnc.parameters.yaml_file import Sections
from spacecraft_gnc.scenario import InvalidScenario, Problem, Scenario, from_sections
from spacecraft_gnc.scenario.node_sections import (
    OPTION,
    add_file,
    add_option,
    given_to,
    matches,
    node_names,
)

_FILE = "--params-file"
_OPTIONS = ("-p", "--param")
_RANGE_END = 1.7976931348623157e308
ROS_OWN = ("use_sim_time", "start_type_description_service")
"""Parameters that every node has, of no concern to a scenario."""


def parameter_files(arguments: Sequence[str]) -> Iterator[Path]:
    """Paths after ``--params-file`` on a command line."""
    for flag, value in pairwise(arguments):
        if flag == _FILE:
            yield Path(value)


def command_line(arguments: Sequence[str]) -> Sections:
    """Return the sections that a command line gives its nodes, by files and by ``-p``.

    Raises
    ------
    ScenarioError
        If a file cannot be read, or holds keys that ROS 2 could not use.
    """
    sections: Sections = {}
    for flag, value in pairwise(arguments):
        if flag == _FILE:
            add_file(sections, Path(value))
        elif flag in _OPTIONS:
            add_option(sections, value)
    return sections


def load_scenario(node: Node, section: str) -> Scenario:
    """Return the checked scenario that a node was started with, and declare its parameters.

    The command line tells what ROS 2 gives this node and the others of its namespace, so that one
    file describes the whole graph.

    Raises
    ------
    ScenarioError
        With every problem at once.
    """
    sections = command_line(sys.argv)
    own_name = node.get_fully_qualified_name()
    names = node_names(node.get_namespace())
    nodes = {name: role for name, role in names.items() if role != section} | {own_name: section}
    problems: list[Problem] = []
    given = given_to(sections, nodes, problems)
    if problems:
        raise InvalidScenario(problems)
    values = plain_values(given)
    own = values.setdefault(section, {})
    shared = _names_in_files(sections, own_name)
    for name, value in given_parameters(node).items():
        # ROS 2 has no empty list: it gives None; and it gives all of a wildcard to every node
        if value is not None and (name in own or name not in shared):
            own[name] = value
    files = list(parameter_files(sys.argv))
    scenario = from_sections(values, str(files[0]) if files else node.get_name())
    _declare(node, section, scenario)
    return scenario


def _names_in_files(sections: Sections, node: str) -> set[str]:
    """Return the parameters that files give a node, wanted or not."""
    return {
        name
        for pattern, entries in sections.items()
        if matches(pattern, node)
        for name, entry in entries.items()
        if entry.file != OPTION
    }


def given_parameters(node: Node) -> dict[str, Any]:
    """Return the values that ROS 2 was given for a node (files, ``-p``), declared or not."""
    # rclpy offers no public view of them, and declaring them all fails on an empty list.
    overrides: dict[str, Parameter] = node._parameter_overrides  # noqa: SLF001
    return {
        name: parameter.value
        for name, parameter in overrides.items()
        if name not in ROS_OWN and not name.startswith("qos_overrides.")
    }


def _declare(node: Node, section: str, scenario: Scenario) -> None:
    """Declare every parameter with type, range, unit and description, holding its checked value."""
    for name, spec in scenario.declarations(section):
        value = scenario.values[section][name]
        if not node.has_parameter(name):  # else declared by an earlier configure
            node.declare_parameter(name, _ros_value(spec, value), _descriptor(spec), True)


def _ros_value(spec: ParameterSpec, value: Value) -> Any:
    if value == []:  # rclpy takes an empty list for bytes
        return _EMPTY.get(spec.kind, Parameter.Type.DOUBLE_ARRAY)
    return value


_EMPTY = {Kind.STRING_ARRAY: Parameter.Type.STRING_ARRAY}


def _descriptor(spec: ParameterSpec) -> ParameterDescriptor:
    descriptor = ParameterDescriptor(
        description=f"{spec.description} [{spec.unit or '-'}]",
        additional_constraints=spec.requirement,
        read_only=spec.read_only,
        dynamic_typing=spec.kind is Kind.DYNAMIC,
    )
    low, high = spec.lowest, spec.highest
    if low is None and high is None:
        return descriptor
    if spec.kind is Kind.DOUBLE:
        ends = (-_RANGE_END if low is None else low, _RANGE_END if high is None else high)
        descriptor.floating_point_range = [FloatingPointRange(from_value=ends[0], to_value=ends[1])]
    elif spec.kind is Kind.INTEGER:
        whole = (-(2**63) if low is None else int(low), 2**63 - 1 if high is None else int(high))
        descriptor.integer_range = [IntegerRange(from_value=whole[0], to_value=whole[1], step=1)]
    return descriptor
