"""Parameters that a campaign can vary."""

from __future__ import annotations

from typing import Final

from spacecraft_gnc.campaign.distributions.distribution import Target
from spacecraft_gnc.parameters.parameter import ParameterSpec, Value
from spacecraft_gnc.parameters.problems import Problem, suggestion
from spacecraft_gnc.scenario import Scenario
from spacecraft_gnc.scenario.fingerprint import FLOWN

_BY_CAMPAIGN: Final = {
    "plant.vehicle": "one vehicle throughout: its parameters are those that are varied",
    "plant.seed": "the seed of the campaign, --seed",
    "plant.run": "the number of the run, which the campaign sets",
}


def target_of(
    scenario: Scenario, name: str, place: tuple[str, int], problems: list[Problem]
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
    """
    section, _, key = name.partition(".")
    specs = {d.name: d.spec for d in scenario.declarations(section)} if section in FLOWN else {}
    if name in _BY_CAMPAIGN:
        reason = "a parameter that may vary", _BY_CAMPAIGN[name], "remove it"
    elif section not in FLOWN:
        need = f"NODE.PARAMETER with a node out of {', '.join(FLOWN)}"
        reason = "an unknown node", need, suggestion(section, FLOWN)
    elif key not in specs:
        need = f"a parameter of {section}"
        reason = "an unknown parameter", need, suggestion(key, list(specs))
    else:
        return Target(name, specs[key], _nominal(scenario, section, key, specs[key]))
    problems.append(Problem(*place, name, *reason))
    return None


def _nominal(scenario: Scenario, section: str, key: str, spec: ParameterSpec) -> Value:
    """Return the value in the scenario, that of another parameter where it is left open."""
    value = scenario.values[section][key]
    if value == spec.default and spec.otherwise:
        section, _, key = spec.otherwise.partition(".")
        value = scenario.values[section].get(key, value)
    return value
