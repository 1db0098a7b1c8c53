"""Values laid over those of a scenario file: ``--set`` on a command line, a mapping in Python."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any, Final

from spacecraft_gnc.arguments import as_tuple, require_kind
from spacecraft_gnc.parameters.declare import flatten
from spacecraft_gnc.parameters.problems import Problem, shown, suggestion
from spacecraft_gnc.parameters.values import plain
from spacecraft_gnc.parameters.yaml_file import Entry, Given, parse_value
from spacecraft_gnc.parameters.yaml_scalar import Scalar
from spacecraft_gnc.scenario.schema import OF_AGENT, OF_GRAPH, ROLES

_OF_CRAFT: Final = "nmpc_controller"
"""The node that each craft has of its own."""
_DURATION: Final = re.compile(r"\s*(/?(\w+/)*)?plant\b.*\bduration\b")
Overrides = Mapping[str, Any] | Sequence[str]
"""``{"plant.duration": 10.0}``, nested or dotted, or ``["plant.duration=10"]`` as for ``--set``.

A node of one agent is named by its path, ``/sc1/plant.duration``; without one it is that of all."""


def replaces_duration(texts: Iterable[str]) -> bool:
    """Tell whether values of ``--set`` lay another ``plant.duration`` over that of a file."""
    return any(_DURATION.match(text) for text in texts)


def apply(
    overrides: Overrides,
    problems: list[Problem],
    agents: Sequence[str] = ("",),
    hosts: Collection[str] = (),
) -> dict[str, Given]:
    """Return what overrides lay over a file, by agent.

    Of the agents ``hosts`` that are several craft each, what is laid over the controller of one is
    named by its path: ``sc1/nmpc_controller``.
    """
    written: dict[str, str] = {}
    if isinstance(overrides, Mapping):
        values = flatten(overrides)
    else:
        values = {}
        for i, text in enumerate(as_tuple("overrides", overrides, "NODE.PARAMETER=VALUE")):
            require_kind(f"overrides[{i}]", text, str)
            values |= _parse_override(text, problems)
            key, _, value_text = text.partition("=")
            written[key.strip()] = value_text.strip()
    given: dict[str, Given] = {agent: {} for agent in agents}
    for key, value in values.items():
        if value is None:  # as in `from_sections`: not given
            continue
        section, _, name = key.partition(".")
        path, _, role = section.strip("/").rpartition("/")
        concerned = [agent for agent in agents if not path or agent == path]
        if not concerned and role == _OF_CRAFT:
            concerned = [host for host in hosts if f"{path}/".startswith(f"{host}/".lstrip("/"))]
            craft = path.removeprefix(concerned[0]).strip("/") if concerned else ""
            is_known, role = bool(concerned and name), f"{craft}/{role}"
        else:
            is_known = bool(
                role in ROLES and name and concerned and not (path and role in OF_GRAPH)
            )
        if not is_known:
            problems.append(_unknown(key, section, value, agents))
            continue
        as_written = written.get(key) if isinstance(value, Scalar) else None
        entry = Entry(plain(value), "--set", coerce=True, written=as_written)
        for agent in concerned:
            given[agent].setdefault(role, {})[name] = entry
    return given


def _unknown(key: str, section: str, value: Any, agents: Sequence[str]) -> Problem:
    of_agents = [f"/{agent}/{role}" for agent in agents for role in OF_AGENT if agent]
    known = [*ROLES, *of_agents]
    need = f"NODE.PARAMETER with a node out of {', '.join(known)}"
    return Problem("--set", None, key, shown(plain(value)), need, suggestion(section, known))


def _parse_override(text: str, problems: list[Problem]) -> dict[str, Any]:
    key, equals, value = text.partition("=")
    key = key.strip()
    if not equals or not key:
        remedy = "write for example --set plant.duration=10.0"
        problems.append(Problem("--set", None, "", shown(text), "NODE.PARAMETER=VALUE", remedy))
        return {}
    try:
        parsed = parse_value(value)
    except ValueError as error:
        requirement, _, remedy = str(error).partition("; ")
        problems.append(Problem("--set", None, key, shown(value), requirement, remedy))
        return {}
    if isinstance(parsed, dict):
        return {f"{key}.{name}": item for name, item in parsed.items()}
    return {key: parsed}
