"""Namespaces of a parameter file: those of agents, and those of their craft."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from spacecraft_gnc.parameters.problems import InvalidScenario, Problem
from spacecraft_gnc.parameters.yaml_file import Sections
from spacecraft_gnc.scenario.node_sections import (
    CONTROLLER,
    PLANT,
    ROOT,
    add_craft,
    agent_nodes,
    beneath,
    has_craft,
    literal_namespace,
    matches,
    node_names,
    unread,
    vehicle_in,
)
from spacecraft_gnc.scenario.schema import OF_AGENT, OF_GRAPH


def agents_in(sections: Sections) -> tuple[str, ...]:
    """Return the agents of a graph by their namespaces; none where a file is about one vehicle.

    There are agents where several namespaces have sections, or one beside a ``plant`` of the root,
    and the root has neither controller nor governor. The craft of a vehicle are none.

    Raises
    ------
    InvalidScenario
        If there may be craft, of a vehicle that is unknown.
    """
    named = _roles_by_namespace(sections)
    for namespace in list(_of_craft(sections, named)):
        del named[namespace]
    root = named.pop(ROOT, set())
    if root - {PLANT}:
        return ()
    is_whole = any({PLANT, CONTROLLER} <= roles for roles in named.values())
    if len(named) > 1 or (root and is_whole):
        return tuple(namespace.strip("/") for namespace in named)
    return ()


def _roles_by_namespace(sections: Sections) -> dict[str, set[str]]:
    """Return what stands in each namespace that is written without a wildcard."""
    named: dict[str, set[str]] = {}
    for pattern in sections:
        namespace, role = literal_namespace(pattern), pattern.rpartition("/")[2]
        if namespace is not None and role not in OF_GRAPH:
            named.setdefault(namespace, set()).add(role)
    return named


def _of_craft(sections: Sections, named: Mapping[str, set[str]]) -> Iterator[str]:
    """Yield the namespaces of craft: beneath a plant that flies several, and without their own."""
    craft = [space for space, roles in named.items() if PLANT not in roles and space != ROOT]
    hosts = [space for space in named if craft and PLANT in named[space]]
    plants = {host: agent_nodes(host.strip("/")) for host in hosts}
    hosts = [host for host in hosts if vehicle_in(sections, plants[host], "").craft is not None]
    yield from (space for space in craft if any(beneath(space, host) for host in hosts))


def nodes_in(sections: Sections, namespace: str) -> dict[str, str]:
    """Return the sections of the vehicle in a namespace, each with its role, as `node_names`."""
    agent, alone = namespace.strip("/"), node_names(namespace)
    return {**agent_nodes(agent), **alone} if agent in agents_in(sections) else alone


def hosts_of(sections: Sections, namespace: str) -> list[str]:
    """Return the namespaces of the vehicles of which a namespace may be a craft, nearest first."""
    words = namespace.strip("/").split("/") if namespace.strip("/") else []
    above = [f"/{'/'.join(words[:count])}" for count in range(len(words) - 1, -1, -1)]
    agents = {f"/{agent}" for agent in agents_in(sections)} if above else set()
    known = [space for space in above if not agents or space in agents]
    return [space for space in known if has_craft(sections, nodes_in(sections, space))]


def has_plant(sections: Sections, namespace: str) -> bool:
    """Tell whether a namespace has a section ``plant`` of its own, or by a wildcard."""
    plant = f"/{namespace.strip('/')}/{PLANT}".replace("//", "/")
    return any(matches(pattern, plant) for pattern in sections)


def require_sections(sections: Sections, file: str, namespace: str) -> None:
    """Refuse a namespace of whose vehicle a file says nothing.

    Raises
    ------
    InvalidScenario
        With the namespaces of which it does.
    """
    agents = [f"/{agent}" for agent in agents_in(sections)]
    known = agents or list(_roles_by_namespace(sections))
    nodes = [f"{namespace.rstrip('/')}/{role}" for role in OF_AGENT]
    if known and not any(matches(pattern, node) for pattern in sections for node in nodes):
        need = f"one of {', '.join(known)}"
        remedy = "name one of these, or leave it out"
        raise InvalidScenario([Problem(file, None, "--namespace", namespace, need, remedy)])


def namespace_of(sections: Sections, file: str, wanted: str | None = None) -> str:
    """Return the namespace that a file is about: the root, unless it names another one only.

    Parameters
    ----------
    sections : Sections
    file : str
        To blame.
    wanted : str, optional
        The one to prefer where the file names several.

    Raises
    ------
    InvalidScenario
        If it names several, and not the root.
    """
    named = dict.fromkeys(literal_namespace(pattern) for pattern in sections)
    agents = [f"/{agent}" for agent in agents_in(sections)]
    craft = set(_of_craft(sections, _roles_by_namespace(sections)))
    found = agents or [space for space in named if space is not None and space not in craft]
    preferred = f"/{wanted.strip('/')}" if wanted is not None else ROOT
    if preferred in found or not found:
        return preferred if preferred in found else ROOT
    if len(found) == 1:
        return found[0]
    what = f"sections of several spacecraft ({', '.join(found)})"
    raise InvalidScenario([Problem(file, None, "", what, "one", "name it with --namespace")])


def nodes_of_one(
    sections: Sections, file: str, namespace: str | None = None
) -> tuple[dict[str, str], str, list[str]]:
    """Return the nodes of one vehicle by full name, its agent, and what a file says in vain."""
    where = namespace_of(sections, file) if namespace is None else namespace
    nodes = nodes_in(sections, where)
    return nodes, where.strip("/"), _warnings(sections, nodes, file)


def _warnings(sections: Sections, nodes: Mapping[str, str], file: str) -> list[str]:
    """Name the sections that no node reads."""
    known = add_craft(sections, nodes) if has_craft(sections, nodes) else nodes
    names = ", ".join(unread(sections, known))
    controller = next(name for name, role in nodes.items() if role == CONTROLLER)
    namespace = controller.rpartition("/")[0] or ROOT
    return [f"{file}: {names}: not read, no node of namespace {namespace} matches"] if names else []


def incomplete(sections: Sections, file: str) -> Iterator[Problem]:
    """Yield the problems of agents that lack a section of their own."""
    for agent in agents_in(sections):
        nodes = nodes_of(sections, agent)
        for role, name in ((PLANT, "plant"), (CONTROLLER, "controller")):
            section = f"/{agent}/{role}"
            own = [node for node in nodes if nodes[node] == role and node != f"/{PLANT}"]
            if not any(matches(pattern, node) for pattern in sections for node in own):
                what, need = f"an agent without a {name}", f"a section {section}"
                remedy = "add it, or correct the namespace of the agent's other sections"
                yield Problem(file, None, f"/{agent}", what, need, remedy)


def nodes_of(sections: Sections, agent: str) -> dict[str, str]:
    """Return the nodes of an agent, the controllers of its craft among them."""
    nodes = agent_nodes(agent)
    return add_craft(sections, nodes) if has_craft(sections, nodes) else nodes
