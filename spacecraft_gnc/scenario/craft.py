"""Craft of a vehicle that is several: who they are, and the one law that serves them all."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType
from typing import Any, Final

from spacecraft_gnc.parameters.problems import InvalidScenario, Problem, shown
from spacecraft_gnc.parameters.yaml_file import Entry, Given, Sections
from spacecraft_gnc.scenario.node_sections import CONTROLLER, beneath, given_to, literal_controllers
from spacecraft_gnc.scenario.scenario import Scenario

_Entries = Mapping[str, Entry]
"""Dotted parameter name -> entry."""
_NOTHING: Final = "no value"


def craft_of(scenario: Scenario) -> tuple[str, ...]:
    """Return the namespaces of a vehicle's craft, relative to the agent's; empty: it is one."""
    craft = scenario.vehicle.craft
    return () if craft is None else tuple(craft.load()(scenario))


def take_craft(laid_over: Given) -> dict[str, dict[str, Entry]]:
    """Take what is laid over the controllers of single craft out of what is laid over an agent.

    All of it is laid over the one law, too; `require_one_law` compares the craft.
    """
    own = {key: laid_over.pop(key) for key in list(laid_over) if key.endswith(f"/{CONTROLLER}")}
    for entries in own.values():
        laid_over.setdefault(CONTROLLER, {}).update(entries)
    return {key.rpartition("/")[0]: entries for key, entries in own.items()}


def craft_names(scenario: Scenario, namespace: str) -> tuple[str, ...]:
    """Return the full namespaces of the craft of a vehicle in a namespace."""
    return tuple(f"{namespace.rstrip('/')}/{name}" for name in craft_of(scenario))


def no_craft(file: str, key: str, received: str, craft: Iterable[str], flight: str = "") -> Problem:
    """Return the problem of a namespace that is none of the craft's, nor that of their flight."""
    need = f"one of the craft {', '.join(craft)}"
    if flight:
        need = f"{need}, or {flight} for the flight of all"
    return Problem(file, None, key, received, need, "name one of these")


def require_one_law(
    scenario: Scenario,
    sections: Sections,
    nodes: Mapping[str, str],
    laid_over: Mapping[str, _Entries] = MappingProxyType({}),
    of_all: _Entries = MappingProxyType({}),
) -> None:
    """Refuse what is stated of no craft, and craft that were to have different laws.

    Parameters
    ----------
    scenario
        Of the agent.
    sections, nodes
        Of the file, and full name -> role of the agent's nodes.
    laid_over
        What is laid over the controller of a single craft.
    of_all
        What is laid over that of all.

    Raises
    ------
    InvalidScenario
        With every such problem.
    """
    if problems := list(_law_problems(scenario, sections, nodes, laid_over, of_all)):
        raise InvalidScenario(problems)


def _law_problems(
    scenario: Scenario,
    sections: Sections,
    nodes: Mapping[str, str],
    laid_over: Mapping[str, _Entries],
    of_all: _Entries,
) -> Iterator[Problem]:
    home = next(n for n, role in nodes.items() if role == CONTROLLER).rpartition("/")[0]
    craft = craft_of(scenario)
    if not craft:
        return
    known = {f"{home}/{name}/{CONTROLLER}": name for name in craft}
    yield from _of_no_craft(scenario, sections, home, known, laid_over)
    given = {
        full: _law(sections, nodes, full, scenario) | {**of_all, **laid_over.get(name, {})}
        for full, name in known.items()
    }
    yield from _differences(scenario, given)


def _law(
    sections: Sections, nodes: Mapping[str, str], controller: str, scenario: Scenario
) -> dict[str, Entry]:
    """Return what ROS 2 gives the controller of one craft, over what its vehicle's section says."""
    own = {**nodes, controller: CONTROLLER}
    return given_to(sections, own, vehicle=scenario.vehicle, with_craft=False).get(CONTROLLER, {})


def _of_no_craft(
    scenario: Scenario,
    sections: Sections,
    home: str,
    known: Mapping[str, str],
    laid_over: Mapping[str, Any],
) -> Iterator[Problem]:
    need = f"one of the craft {', '.join(name.rpartition('/')[0] for name in known)}"
    remedy = "correct the namespace, or state the craft in section plant"
    for name in literal_controllers(sections):
        if beneath(name.rpartition("/")[0], home) and name not in known:
            yield Problem(scenario.path, None, name, "a controller of no craft", need, remedy)
    for name in laid_over:
        full = f"{home}/{name}/{CONTROLLER}"
        if full not in known:
            yield Problem("--set", None, full, "a controller of no craft", need, remedy)


def _differences(scenario: Scenario, given: Mapping[str, _Entries]) -> Iterator[Problem]:
    (first, ours), *others = given.items()
    remedy = f"state it once, in section /**/{CONTROLLER}, or make them equal"
    for name, theirs in others:
        for key in dict.fromkeys((*ours, *theirs)):
            entry = theirs.get(key) or ours[key]
            values = [_value(scenario, entries, key, entry) for entries in (theirs, ours)]
            if values[0] != values[1]:
                found, wanted = map(shown, values)
                where = first.rpartition("/")[0]
                need = f"{wanted} as of {where}, for one law serves all craft"
                yield Problem(entry.file, entry.line, f"{name}.{key}", found, need, remedy)


def _value(scenario: Scenario, entries: _Entries, key: str, entry: Entry) -> Any:
    """Return what is given, or else the default."""
    if key in entries:
        return entries[key].value
    spec = scenario.schema.spec_of(CONTROLLER, key, entry.value)
    default = _NOTHING if spec is None else spec.default
    return scenario.defaults.get(CONTROLLER, {}).get(key, default)
