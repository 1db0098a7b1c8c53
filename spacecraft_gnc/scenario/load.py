"""A ROS 2 parameter file, or the parameters of a live node, to a checked `Scenario`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from spacecraft_gnc.arguments import require_kind, require_path
from spacecraft_gnc.parameters.checked import check_values, plain_values
from spacecraft_gnc.parameters.declare import Schema, flatten, unflatten
from spacecraft_gnc.parameters.parameter import Value
from spacecraft_gnc.parameters.problems import InvalidScenario, Problem, suggestion
from spacecraft_gnc.parameters.values import plain
from spacecraft_gnc.parameters.yaml_file import Entry, Given, Sections, read
from spacecraft_gnc.scenario.agents import (
    has_plant,
    hosts_of,
    namespace_of,
    nodes_in,
    nodes_of_one,
    require_sections,
)
from spacecraft_gnc.scenario.checks import check_all
from spacecraft_gnc.scenario.checks_reads import unread_by
from spacecraft_gnc.scenario.craft import craft_names, no_craft, require_one_law, take_craft
from spacecraft_gnc.scenario.defaults import Stated, fill_in
from spacecraft_gnc.scenario.node_sections import add_file, given_to, has_craft, vehicle_in
from spacecraft_gnc.scenario.overrides import Overrides, apply
from spacecraft_gnc.scenario.scenario import Scenario
from spacecraft_gnc.scenario.schema import ROLES, schema_of, vehicle_given
from spacecraft_gnc.scenario.shipped import find
from spacecraft_gnc.vehicles.vehicle import Vehicle

_CONTROLLER: Final = "nmpc_controller"


def load(path: str | Path, overrides: Overrides = (), namespace: str | None = None) -> Scenario:
    """Read and check a scenario file.

    Parameters
    ----------
    path : str or Path
        ROS 2 parameter file, or the name of a scenario that comes with the package.
    overrides : mapping or sequence of str
        Values that replace those of the file; an integer may stand for a double here.
    namespace : str, optional
        Of the nodes that the file is for; by default the root, or the only one that it names.
        Of several agents it picks one; `load_fleet` takes them all.

    Raises
    ------
    InvalidScenario
        With every problem of the file and of the overrides at once.
    """
    file = str(find(require_path("path", path)))
    sections, problems = read(Path(file), ROLES)
    return load_one(sections, file, problems, overrides, namespace)


def load_one(
    sections: Sections,
    file: str,
    problems: list[Problem],
    overrides: Overrides = (),
    namespace: str | None = None,
) -> Scenario:
    """Check what a file says of one vehicle, as `load`; ``problems``: those of reading it.

    The namespace of one of a vehicle's craft means the vehicle.
    """
    wanted = f"/{(namespace or '').strip('/')}"
    hosts = [
        (host, _load_at(sections, file, list(problems), overrides, host))
        for host in hosts_of(sections, wanted)
    ]
    found = next((one for host, one in hosts if wanted in craft_names(one, host)), None)
    if found is not None:
        return found
    if hosts and not has_plant(sections, wanted):
        home, one = hosts[0]
        known = craft_names(one, home)
        raise InvalidScenario([no_craft(file, "--namespace", wanted, known, home)])
    if namespace is not None:
        require_sections(sections, file, wanted)
    return _load_at(sections, file, problems, overrides, namespace)


def _load_at(
    sections: Sections,
    file: str,
    problems: list[Problem],
    overrides: Overrides,
    namespace: str | None,
) -> Scenario:
    """Check what a file says of the vehicle in a namespace; None: of the only one."""
    nodes, agent, warnings = nodes_of_one(sections, file, namespace)
    hosts = [agent] if has_craft(sections, nodes) else []
    laid_over = apply(overrides, problems, [agent], hosts)[agent]
    return load_nodes(sections, nodes, file, problems, laid_over, warnings)


def load_nodes(
    sections: Sections,
    nodes: Mapping[str, str],
    file: str,
    problems: list[Problem],
    laid_over: Given,
    warnings: Sequence[str] = (),
) -> Scenario:
    """Check what a file gives the nodes of one vehicle, by full name, and what is laid over it."""
    plant = laid_over.get("plant", {})
    vehicle = vehicle_in(sections, nodes, file)
    if "vehicle" in plant:
        vehicle = vehicle_given(plant, file)
    given = given_to(sections, nodes, problems, vehicle)
    given.setdefault("plant", {})  # a scenario has a plant, stated or by default
    of_all = dict(laid_over.get(_CONTROLLER, {}))
    of_craft = take_craft(laid_over)
    lay_over(given, found_from_here(vehicle, laid_over))
    warnings = [*warnings, *_leave_out_unread(vehicle, given, file)]
    scenario = check_given(vehicle, given, file, problems, warnings)
    require_one_law(scenario, sections, nodes, of_craft, of_all)
    return scenario


def read_sections(
    path: str | Path, namespace: str | None = None, text: str | None = None
) -> dict[str, dict[str, Value]]:
    """Return what a file gives each node, by dotted name, without checking the values.

    Parameters
    ----------
    path : str or Path
        ROS 2 parameter file.
    namespace : str, optional
        Of the nodes, where the file names several.
    text : str, optional
        What the file says, if it is at hand; ``path`` then only tells where it stands.

    Raises
    ------
    InvalidScenario
        If the file cannot be read, or holds keys that ROS 2 could not use.
    """
    sections: Sections = {}
    add_file(sections, Path(require_path("path", path)), text)
    problems: list[Problem] = []
    nodes = nodes_in(sections, namespace_of(sections, str(path), namespace))
    given = given_to(sections, nodes, problems)
    if problems:
        raise InvalidScenario(problems)
    return plain_values(given)


def from_sections(
    sections: Mapping[str, Mapping[str, Any]],
    source: str = "parameters",
    stated: Stated | None = None,
) -> Scenario:
    """Check parameters that are already in memory.

    Parameters
    ----------
    sections : mapping
        Node name -> parameters, nested or dotted; tuples and arrays stand for lists, None for
        "not given". Sections that are absent take their defaults: a node alone need not know the
        plant, and is asked for the inertia only where it needs it.
    source : str
        What to name as the file in problems.
    stated : mapping, optional
        Node name -> dotted name -> the default that a flight took, in place of what the formulas
        give today.

    Raises
    ------
    InvalidScenario
        With every problem at once.
    """
    given: Given = {}
    problems: list[Problem] = []
    for section, values in require_kind("sections", sections, Mapping).items():
        if section not in ROLES:
            remedy = suggestion(section, ROLES)
            need = f"one of {', '.join(ROLES)}"
            problems.append(Problem(source, None, section, "an unknown node", need, remedy))
            continue
        given[section] = entries_of(require_kind(section, values, Mapping), source)
    vehicle = vehicle_given(given.get("plant", {}), source)
    return check_given(vehicle, given, source, problems, stated=stated)


def lay_over(given: Given, entries: Given) -> None:
    """Have values replace those of the same name."""
    for section, values in entries.items():
        given.setdefault(section, {}).update(values)


def found_from_here(vehicle: Vehicle, laid_over: Given) -> Given:
    """Return values with whole paths of files: those laid over are relative to this folder."""
    schema, found = schema_of(vehicle), {}
    for section, values in laid_over.items():
        found[section] = dict(values)
        for name, entry in values.items():
            spec = schema.spec_of(section, name, entry.value)
            if entry.value and spec is not None and spec.is_file:
                found[section][name] = entry._replace(value=str(Path(str(entry.value)).absolute()))
    return found


def entries_of(values: Mapping[str, Any], source: str) -> dict[str, Entry]:
    """Return values in memory, nested or dotted, as entries of a section."""
    return {
        name: Entry(plain(value), source, coerce=True)
        for name, value in flatten(values).items()
        if value is not None
    }


def _leave_out_unread(vehicle: Vehicle, given: Given, file: str) -> list[str]:
    """Take out of a file what a method that was laid over it does not read, and say so."""
    controller = given.get(_CONTROLLER, {})
    method = controller.get("method")
    if method is None or method.line is not None:
        return []
    schema = schema_of(vehicle)
    in_file = ((name, entry) for name, entry in controller.items() if entry.line is not None)
    written = [name for name, entry in in_file if _says(schema, name, entry)]
    names = list(unread_by(vehicle, str(method.value), written))
    for name in names:
        del controller[name]
    listed = ", ".join(f"{_CONTROLLER}.{name}" for name in names)
    return [f"{file}: not read by method {method.value}: {listed}"] if names else []


def _says(schema: Schema, name: str, entry: Entry) -> bool:
    """Tell whether a value of the controller is another than a default that is always the same."""
    spec = schema.spec_of(_CONTROLLER, name, entry.value)
    return spec is None or bool(spec.formula) or entry.value != spec.default


def check_given(
    vehicle: Vehicle,
    given: Given,
    source: str,
    problems: list[Problem],
    warnings: Sequence[str] = (),
    stated: Stated | None = None,
) -> Scenario:
    """Return the scenario of what was given to each node.

    ``problems``: those found so far; ``stated``: as of `from_sections`.

    Raises
    ------
    InvalidScenario
        With every problem at once.
    """
    checked = check_values(schema_of(vehicle), given, source, problems)
    checked.is_over = stated is not None
    fill_in(checked, vehicle, stated or {})
    check_all(checked, vehicle)
    if problems:
        raise InvalidScenario(sorted(problems, key=_place))
    sections = plain_values(checked.given)
    return Scenario(
        vehicle=vehicle,
        plant=checked.section("plant"),
        controller=checked.section("nmpc_controller"),
        governor=checked.section("reference_governor"),
        recorder=checked.section("recorder"),
        launcher=checked.section("launcher"),
        path=source,
        sections={section: unflatten(values) for section, values in sections.items()},
        values=checked.values,
        defaults=checked.defaults,
        warnings=(*warnings, *checked.warnings),
    )


def _place(problem: Problem) -> tuple[str, int]:
    return problem.file, problem.line or 0
