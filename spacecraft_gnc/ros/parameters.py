"""ROS 2 parameters of a node: read from the command line, checked and declared by the schema."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node
from rclpy.parameter import Parameter

from spacecraft_gnc.parameters.checked import plain_values
from spacecraft_gnc.parameters.parameter import Kind, ParameterSpec, Value
from spacecraft_gnc.parameters.yaml_file import Sections
from spacecraft_gnc.scenario import Fleet, InvalidScenario, Problem, Scenario, from_sections
from spacecraft_gnc.scenario.agents import agents_in, has_plant, hosts_of, incomplete
from spacecraft_gnc.scenario.craft import craft_names, no_craft, require_one_law
from spacecraft_gnc.scenario.fleet import gather
from spacecraft_gnc.scenario.node_sections import (
    OPTION,
    add_file,
    add_option,
    agent_nodes,
    given_to,
    has_craft,
    matches,
    node_names,
)
from spacecraft_gnc.signals.graph import CONTROLLER, GOVERNOR, PLANT

_FILE = "--params-file"
_OPTIONS = ("-p", "--param")
_RANGE_END = 1.7976931348623157e308
AGENTS = "agents"
"""Parameter of a plant that simulates several: their namespaces, without the first slash."""
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


def load_graph(node: Node, section: str) -> Fleet:
    """Return the agents of the graph that a node was started for, and declare its parameters.

    The command line tells what ROS 2 gives this node and the others of the graph, so that one file
    describes all of it. A controller or governor stands beside those of other agents where its
    namespace is that of an agent, plant and recorder where they stand in the root. A vehicle of
    several craft has no controller in its own namespace, but one in that of each craft.

    Raises
    ------
    ScenarioError
        With every problem at once.
    """
    sections = command_line(sys.argv)
    fleet = _find_graph(node, section, sections)
    _declare(node, section, fleet)
    return fleet


def _find_graph(node: Node, section: str, sections: Sections) -> Fleet:
    namespace = node.get_namespace()
    if section != CONTROLLER:
        return _gather_at(node, section, sections, namespace)
    above = {
        home: _gather_at(node, section, sections, home) for home in hosts_of(sections, namespace)
    }
    for home, fleet in above.items():
        if _has_craft_at(fleet, home, namespace):
            return fleet
    if not above or has_plant(sections, namespace):
        above = {namespace: _gather_at(node, section, sections, namespace)}
    home, fleet = next(iter(above.items()))
    craft = craft_names(fleet.agents[agent_of_namespace(home, fleet)], home)
    if craft:  # and none of them is here
        raise InvalidScenario([no_craft(_source(node), f"{section}: __ns", namespace, craft)])
    return fleet


def _gather_at(node: Node, section: str, sections: Sections, home: str) -> Fleet:
    """Return the agents of the graph of which a namespace is that of one, or the only one."""
    source = _source(node)
    nodes = _nodes_of_agents(sections, home, section)
    if problems := list(incomplete(sections, source)) if "" not in nodes else []:
        raise InvalidScenario(problems)
    return gather(
        {
            agent: partial(_read, node, section, sections, known, source)
            for agent, known in nodes.items()
        }
    )


def _source(node: Node) -> str:
    """Return what to blame for the parameters of a node."""
    return next((str(file) for file in parameter_files(sys.argv)), node.get_name())


def _has_craft_at(fleet: Fleet, home: str, namespace: str) -> bool:
    """Tell whether a namespace is that of a craft; the only agent's stand in its home."""
    root = home.rstrip("/") if "" in fleet.agents else ""
    return namespace in {f"{root}/{craft}" for craft in fleet.craft}


def controllers_in(sections: Sections) -> Iterator[str]:
    """Yield the controllers that sections describe, relative to the root namespace.

    Raises
    ------
    ScenarioError
        If a vehicle of several craft is refused.
    """
    for agent in agents_in(sections) or ("",):
        nodes = agent_nodes(agent) if agent else node_names()
        spaces: tuple[str, ...] = (f"/{agent}",)
        if has_craft(sections, nodes):
            one = from_sections(plain_values(given_to(sections, nodes)))
            spaces = craft_names(one, spaces[0])
        yield from (f"{space}/{CONTROLLER}".strip("/") for space in spaces)


def agent_of_namespace(namespace: str, fleet: Fleet) -> str:
    """Return the agent of a node in a namespace; the first one where the node serves all."""
    space = namespace.strip("/")
    agent = fleet.craft.get(space, space)
    return agent if agent in fleet.agents else next(iter(fleet.agents))


def _nodes_of_agents(sections: Sections, namespace: str, section: str) -> dict[str, dict[str, str]]:
    """Return by agent the full names of its nodes, each with its role."""
    agents, own = agents_in(sections), namespace.strip("/")
    if own in (agents if section in (CONTROLLER, GOVERNOR) else ("",)) and agents:
        return {agent: agent_nodes(agent) for agent in agents}
    return {"": node_names(namespace)}


def _read(
    node: Node, section: str, sections: Sections, known: Mapping[str, str], source: str
) -> Scenario:
    """Return the scenario of the agent whose nodes have these names; one may be ``node`` itself."""
    own_name = node.get_fully_qualified_name()
    default_name = f"{node.get_namespace().rstrip('/')}/{section}"
    is_own = default_name in known
    nodes = {own_name if name == default_name else name: role for name, role in known.items()}
    problems: list[Problem] = []
    given = given_to(sections, nodes, problems)
    if problems:
        raise InvalidScenario(problems)
    values = plain_values(given)
    if is_own and list(known.values()).count(section) == 1:  # else an agent's own plant goes first
        own = values.setdefault(section, {})
        shared = _names_in_files(sections, own_name)
        for name, value in given_parameters(node).items():
            # ROS 2 has no empty list: it gives None; and it gives all of a wildcard to every node
            if value is not None and (name in own or name not in shared):
                own[name] = value
    scenario = from_sections(values, source)
    require_one_law(scenario, sections, known)
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


def _declare(node: Node, section: str, fleet: Fleet) -> None:
    """Declare every parameter with type, range, unit and description, holding its checked value.

    A plant of several agents has a value in which they differ once for each, ``sc1.inertia``, and
    tells who they are.
    """
    own = agent_of_namespace(node.get_namespace(), fleet)
    if section == PLANT and "" not in fleet.agents and not node.has_parameter(AGENTS):
        about = ParameterDescriptor(description="agents that it simulates", read_only=True)
        node.declare_parameter(AGENTS, list(fleet.agents), about, True)
    agents = fleet.agents if section == PLANT else {own: fleet.agents[own]}
    values = [one.values[section] for one in agents.values()]
    for agent, one in agents.items():
        for name, spec in one.declarations(section):
            value = one.values[section][name]
            is_common = all(other.get(name) == value for other in values)
            told = name if is_common else f"{_prefix(agent)}{name}"
            if not node.has_parameter(told):  # else declared by an earlier configure
                node.declare_parameter(told, _ros_value(spec, value), _descriptor(spec), True)


def of_agent(values: Mapping[str, Any], agent: str) -> dict[str, Any]:
    """Return the parameters of one agent out of those of the plant that simulates it."""
    others = tuple(_prefix(other) for other in values[AGENTS] if other != agent)
    own = {n: v for n, v in values.items() if not n.startswith(others) and n != AGENTS}
    return {name.removeprefix(_prefix(agent)): value for name, value in own.items()}


def _prefix(agent: str) -> str:
    return f"{agent.replace('/', '.')}."


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
