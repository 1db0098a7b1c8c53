"""The scenario of a recording: what a recorder attaches, and what it says today."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final

from spacecraft_gnc.errors import GncError, ParameterError
from spacecraft_gnc.parameters.checked import plain_values
from spacecraft_gnc.parameters.parameter import Value
from spacecraft_gnc.parameters.yaml_file import Sections
from spacecraft_gnc.scenario.defaults import follows_from_formula, former_defaults
from spacecraft_gnc.scenario.load import from_sections, read_sections
from spacecraft_gnc.scenario.node_sections import ROOT, add_file, given_to, node_names
from spacecraft_gnc.scenario.scenario import Scenario

SCENARIO_ATTACHMENT: Final = "scenario.yaml"
"""Name under which a recorder attaches the scenario that flew, with overrides merged in."""
DEFAULTS_ATTACHMENT: Final = "defaults.yaml"
"""Name under which it attaches the defaults that this scenario took by formulas."""


def scenario_texts(attachments: Mapping[str, bytes]) -> tuple[str, str]:
    """Return the scenario in the attachments of a bag and the defaults that it took, as texts."""
    names = SCENARIO_ATTACHMENT, DEFAULTS_ATTACHMENT
    scenario, defaults = (attachments.get(name, b"").decode(errors="replace") for name in names)
    return scenario, defaults


def parse_scenario(
    text: str, source: Path, namespace: str | None = None, defaults: str = ""
) -> tuple[Scenario | None, str]:
    """Return the scenario of a namespace in a text and, if it is refused, the first reason.

    ``defaults``: those that the flight took, as recorded; a flight without any is one of before
    they followed from the spacecraft. Files that the scenario names are left out.
    """
    if not text:
        return None, ""
    try:
        # as the nodes read it: a flight may have been cut short on purpose
        sections = read_sections(SCENARIO_ATTACHMENT, namespace, text)
        stated = _defaults(defaults, sections, namespace) if defaults else former_defaults(sections)
        scenario = from_sections(sections, SCENARIO_ATTACHMENT, stated)
        named = list(scenario.named_files())
        for section, name, _ in named:
            del sections[section][name]  # a recording stands for itself, wherever it is
        if named:
            scenario = from_sections(sections, SCENARIO_ATTACHMENT, stated)
    except GncError as error:
        return None, str(error).splitlines()[0]
    return replace(scenario, path=f"{source}/{SCENARIO_ATTACHMENT}"), ""


def _defaults(
    text: str, sections: Mapping[str, Mapping[str, Value]], namespace: str | None
) -> dict[str, dict[str, Value]]:
    if not any(line and not line.startswith("#") for line in text.splitlines()):
        return {}  # the scenario states everything
    recorded: Sections = {}
    add_file(recorded, Path(DEFAULTS_ATTACHMENT), text)
    # a single vehicle's are written down without its namespace
    stated = plain_values(given_to(recorded, {**node_names(), **node_names(namespace or ROOT)}))
    for section, values in stated.items():
        for name in values:
            if not follows_from_formula(sections, section, name):
                raise ParameterError(
                    f"{section}.{name}: received as a default that the recording took; required "
                    "one that a formula gives (docs/scenario.md); the attachment was changed"
                )
    return stated
