"""Assignment of parameter-file sections to nodes, as ROS 2 does it.

A section's name is a pattern of full node names: ``*`` stands for one word, ``**`` for any number
of words, none included. ROS 2 lays the sections that match a node over each other in the order in
which their names first appear, in all files and ``-p`` options together; the last value wins. So a
wildcard beneath a node's own section replaces its values, and a name that appears again (in another
file, or by ``-p``) changes the values at its first place.

Source: rclpy 7.1 ``Node.get_parameters``, rcl ``arguments.c``; docs/scenario.md has the table, and
``test/nodes/test_parameter_files.py`` compares every form with live nodes.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from spacecraft_gnc.parameters.declare import Schema
from spacecraft_gnc.parameters.problems import InvalidScenario, Problem, suggestion
from spacecraft_gnc.parameters.sections import NODE_NAMES
from spacecraft_gnc.parameters.yaml_file import Entry, Given, Sections, parse_value, read
from spacecraft_gnc.scenario.schema import (
    LAUNCHER,
    OF_AGENT,
    OF_GRAPH,
    ROLES,
    schema_of,
    vehicle_entries,
    vehicle_given,
)
from spacecraft_gnc.vehicles.vehicle import Vehicle

PLANT, CONTROLLER, *_ = NODE_NAMES  # not `signals.graph`: it loads what encodes messages
ROOT: Final = "/"
OPTION: Final = "-p"
"""What an `Entry` has as its file where the value comes from the command line of a node."""
_EVERY_NODE: Final = "/**"
_ANY_CRAFT: Final = "any_craft"
"""Stands for a craft of any name: a wildcard that gives to each craft gives to it."""


def node_names(namespace: str = ROOT) -> dict[str, str]:
    """Return the full names of the nodes in a namespace, each with its role (section).

    The launcher is no node: its section may stand inside the namespace or outside.
    """
    prefix = namespace.strip("/")
    prefix = f"/{prefix}" if prefix else ""
    return {f"{prefix}/{role}": role for role in ROLES} | {f"/{LAUNCHER}": LAUNCHER}


def agent_nodes(agent: str) -> dict[str, str]:
    """Return the sections of one agent of a graph, each with its role.

    What the graph has once stands in the root namespace; there, the values of ``plant`` are those
    of every agent that does not replace them.
    """
    shared = {f"/{role}": role for role in (PLANT, *OF_GRAPH)}
    return shared | {f"/{agent}/{role}": role for role in OF_AGENT}


def beneath(space: str, other: str) -> bool:
    """Tell whether a namespace stands beneath another one."""
    return space != other and f"{space}/".startswith(f"{other.rstrip('/')}/")


def literal_controllers(sections: Sections) -> list[str]:
    """Return the full names of the controllers that have a section without a wildcard."""
    names = (p for p in sections if p.rpartition("/")[2] == CONTROLLER)
    return [f"/{n.strip('/')}" for n in names if literal_namespace(n) is not None]


def has_craft(sections: Sections, nodes: Mapping[str, str]) -> bool:
    """Tell whether the vehicle among the nodes is several craft; an unknown one is not."""
    try:
        return vehicle_in(sections, nodes, "").craft is not None
    except InvalidScenario:
        return False


def add_craft(sections: Sections, nodes: Mapping[str, str]) -> dict[str, str]:
    """Return the nodes of a vehicle of several craft, and the controllers of these behind them.

    Their sections are laid over that of the vehicle: one law serves all.
    """
    whole = next(name for name, role in nodes.items() if role == CONTROLLER).rpartition("/")[0]
    named = [n for n in literal_controllers(sections) if beneath(n.rpartition("/")[0], whole)]
    craft = [f"{whole}/{_ANY_CRAFT}/{CONTROLLER}", *named]
    return {**nodes, **dict.fromkeys(craft, CONTROLLER)}


def matches(pattern: str, node: str) -> bool:
    """Tell whether ROS 2 gives a section to the node of that full name."""
    return re.fullmatch(pattern.replace("/*", r"(/\w+)"), node, re.ASCII) is not None


def vehicle_in(sections: Sections, nodes: Mapping[str, str], file: str) -> Vehicle:
    """Return the vehicle that sections give the plant among the nodes.

    Raises
    ------
    InvalidScenario
        If it is unknown, or the plug-in behind it is broken.
    """
    plants = [name for name, role in nodes.items() if role == "plant"]
    patterns = (p for name in plants for p in sections if matches(p, name))
    return vehicle_given(vehicle_entries(sections, patterns), file)


def given_to(
    sections: Sections,
    nodes: Mapping[str, str],
    problems: list[Problem] | None = None,
    vehicle: Vehicle | None = None,
    *,
    with_craft: bool = True,
) -> Given:
    """Return what ROS 2 gives each of the nodes, by role.

    A wildcard gives a node everything, also what is meant for others: a parameter that the role
    does not know is left out where another node of the same pattern knows it.

    Parameters
    ----------
    sections : Sections
        Of one file, or of all that a command line names.
    nodes : mapping
        Full node name -> role; of two with one role, the later lies over the earlier.
    problems : list of Problem, optional
        Gets one more for each parameter of a wildcard that no node knows.
    vehicle : Vehicle, optional
        Where it is another than the one that the sections name.
    with_craft : bool
        Whether the controllers of a vehicle's craft are among the nodes.

    Raises
    ------
    InvalidScenario
        If the vehicle is unknown, or the plug-in behind it is broken.
    """
    vehicle = vehicle_in(sections, nodes, "") if vehicle is None else vehicle
    schema = schema_of(vehicle)
    if vehicle.craft is not None and with_craft:
        nodes = add_craft(sections, nodes)
    by_node: Given = {}
    for pattern, entries in sections.items():
        names = [name for name in nodes if matches(pattern, name)]
        is_shared = len({nodes[name] for name in names}) > 1
        for parameter, entry in entries.items():
            users = [name for name in names if _knows(schema, nodes[name], parameter, entry)]
            if is_shared and not users:
                if problems is not None:
                    problems.append(_unknown_to_all(schema, pattern, parameter, entry))
                continue
            for name in users or names:
                by_node.setdefault(name, {})[parameter] = entry
    given: Given = {nodes[name]: {} for name in by_node}
    for name in filter(by_node.__contains__, nodes):
        given[nodes[name]].update(by_node[name])
    return {r: e for r, e in given.items() if not all(schema.is_ros_own(r, n) for n in e)}


def unread(sections: Sections, nodes: Mapping[str, str]) -> list[str]:
    """Return the names of the sections that match none of the nodes."""
    return [pattern for pattern in sections if not any(matches(pattern, name) for name in nodes)]


def add_file(sections: Sections, path: Path, text: str | None = None) -> None:
    """Lay the values of a parameter file, or of its ``text``, over sections, as ROS 2 does.

    Raises
    ------
    InvalidScenario
        If it cannot be read, or holds keys that ROS 2 could not use.
    """
    found, problems = read(path, ROLES, text)
    if problems:
        raise InvalidScenario(problems)
    for pattern, entries in found.items():
        sections.setdefault(pattern, {}).update(entries)


def add_option(sections: Sections, option: str) -> None:
    """Lay the value of a ``-p [NODE:]NAME:=VALUE`` over sections, likewise."""
    key, _, text = option.partition(":=")
    node, _, name = key.rpartition(":")
    try:
        value: Any = parse_value(text)
    except ValueError:
        return  # ROS 2 says why it refuses it
    sections.setdefault(f"/{node}" if node else _EVERY_NODE, {})[name] = Entry(value, OPTION)


def _knows(schema: Schema, role: str, name: str, entry: Entry) -> bool:
    return schema.is_ros_own(role, name) or schema.spec_of(role, name, entry.value) is not None


def literal_namespace(pattern: str) -> str | None:
    """Return the namespace before the node's name; None where a wildcard leaves it open."""
    namespace, _, role = pattern.rpartition("/")
    if "*" in namespace or (not namespace and "*" in role) or role == LAUNCHER:
        return None
    return namespace or ROOT


def _unknown_to_all(schema: Schema, pattern: str, name: str, entry: Entry) -> Problem:
    known = sorted({known for role in ROLES for known in schema.known_names(role)})
    need = "a parameter of at least one node"
    key = name if entry.file == OPTION else f"{pattern}.{name}"
    remedy = suggestion(name, known)
    return Problem(entry.file, entry.line, key, "an unknown parameter", need, remedy)
