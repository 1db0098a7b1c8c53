"""Parameters that a campaign can vary."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping
from typing import Final, TypeAlias

from spacecraft_gnc.campaign.distributions.distribution import Target
from spacecraft_gnc.parameters.parameter import ParameterSpec, Value
from spacecraft_gnc.parameters.problems import Problem, suggestion
from spacecraft_gnc.scenario import Scenario
from spacecraft_gnc.scenario.checks_reads import readers
from spacecraft_gnc.scenario.fingerprint import FLOWN
from spacecraft_gnc.vehicles import registry

_Reason: TypeAlias = tuple[str, str, str]
"""What was received, what is required, what to do."""
_BY_CAMPAIGN: Final = {
    "plant.vehicle": "one vehicle throughout: its parameters are those that are varied",
    "plant.seed": "the seed of the campaign, --seed",
    "plant.run": "the number of the run, which the campaign sets",
}


def target_of(
    scenario: Scenario,
    name: str,
    place: tuple[str, int],
    problems: list[Problem],
    varied: Collection[str],
) -> Target | None:
    """Return the parameter of a name; None where there is none to vary, which is reported.

    Parameters
    ----------
    scenario
        That is varied.
    name
        ``section.parameter``, as ``--set`` names it.
    place
        File and line of the name.
    problems
        Takes the reason.
    varied
        Names of all parameters that vary.
    """
    section, _, key = name.partition(".")
    specs = {d.name: d.spec for d in scenario.declarations(section)} if section in FLOWN else {}
    reason = _unknown(name, specs) or _unread(scenario, section, key, varied)
    if reason is not None:
        problems.append(Problem(*place, name, *reason))
        return None
    spec = specs[key]
    if spec.plugins:  # the words that it leaves to others to know
        spec = dataclasses.replace(spec, choices=registry.names(spec.plugins, scenario.vehicle))
    return Target(name, spec, _nominal(scenario, section, key, spec))


def _unknown(name: str, specs: Mapping[str, ParameterSpec]) -> _Reason | None:
    """Return why there is no such parameter to vary; None where there is."""
    section, _, key = name.partition(".")
    if name in _BY_CAMPAIGN:
        return "a parameter that may vary", _BY_CAMPAIGN[name], "remove it"
    if section not in FLOWN or not key:
        need = f"NODE.PARAMETER with a node out of {', '.join(FLOWN)}"
        remedy = "add the name of the parameter" if section in FLOWN else suggestion(section, FLOWN)
        return "no parameter of a flight", need, remedy
    if key not in specs:
        remedy = suggestion(key, list(specs))
        return "an unknown parameter", f"a parameter of {section} in the scenario", remedy
    return None


def _unread(scenario: Scenario, section: str, key: str, varied: Collection[str]) -> _Reason | None:
    """Return why the method or the governor ignores a parameter; None where it reads it."""
    vehicle = scenario.vehicle
    for group, laws in (
        (registry.CONTROLLERS, vehicle.methods),
        (registry.GOVERNORS, vehicle.governors),
    ):
        chooser = registry.KEYS[group]
        where, _, noun = chooser.partition(".")
        if where != section or chooser in varied:
            continue
        chosen, read_by = scenario.values[section][noun], readers(laws).get(key, ())
        if read_by and chosen in [law.name for law in laws] and chosen not in read_by:
            need = f"a {noun} that reads it ({' or '.join(read_by)}), not {chosen}"
            return "a parameter that is not read", need, f"remove it, or set {noun}: {read_by[0]}"
    return None


def _nominal(scenario: Scenario, section: str, key: str, spec: ParameterSpec) -> Value:
    """Return the value in the scenario, that of another parameter where it is left open."""
    value = scenario.values[section][key]
    if value == spec.default and spec.otherwise:
        section, _, key = spec.otherwise.partition(".")
        value = scenario.values[section].get(key, value)
    return value
