"""Checked values of a scenario, with every problem found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from spacecraft_gnc.parameters.declare import PLUGIN_PREFIX, Declaration, Schema
from spacecraft_gnc.parameters.formulas import Missing
from spacecraft_gnc.parameters.parameter import Value, typed_section
from spacecraft_gnc.parameters.problems import Problem, shown
from spacecraft_gnc.parameters.values import Refusal, admissible
from spacecraft_gnc.parameters.yaml_file import Entry, Given

_ROUNDING: Final = 1e-9


@dataclass(slots=True)
class Checked:
    """What was given, what of it holds, and what does not."""

    schema: Schema
    """Of the sections: those of the vehicle, and what every graph has."""
    source: str
    """File (or caller) to blame for what is missing."""
    given: Given
    """By section: what ROS 2 gives each node."""
    problems: list[Problem]
    is_over: bool = False
    """Whether it is the scenario of a flight that is over."""
    warnings: list[str] = field(default_factory=list)
    """What to know before it flies, one line each."""
    unknown: list[tuple[str, str]] = field(default_factory=list)
    """(section, name) of what was given and is no parameter."""
    values: dict[str, dict[str, Value]] = field(default_factory=dict)
    """Section -> every parameter by dotted name, defaults included; refused ones are absent."""
    defaults: dict[str, dict[str, Value]] = field(default_factory=dict)
    """Section -> the defaults that formulas give (`formulas`), by dotted name."""

    def get(self, section: str, name: str) -> Value | None:
        """Return an admissible value; None where it was refused."""
        return self.values[section].get(name)

    def number(self, section: str, name: str) -> float:
        """Return a number for a formula, of which too large a quotient is infinite.

        Raises
        ------
        Missing
            If it was refused.
        """
        value = self.get(section, name)
        if not isinstance(value, int | float):
            raise Missing
        return np.float64(value)

    def numbers(self, section: str, name: str) -> list[float]:
        """Return a list of numbers for a formula, likewise."""
        value = self.get(section, name)
        if not isinstance(value, list):
            raise Missing
        return value

    def effective(self, section: str, name: str) -> Value | None:
        """Return the value that counts: that of another parameter where this one is left open."""
        value = self.get(section, name)
        spec = self.schema.spec_of(section, name, value)
        if spec is None or not spec.otherwise or value != spec.default:
            return value
        other, _, key = spec.otherwise.partition(".")
        return self.get(other, key)

    def section(self, section: str) -> Any:
        """Return the typed section; every value of it has to be admissible."""
        parameters, further = self.schema.sections[section], {}
        known = dict(self.values[section])
        for name in (name for name, spec in self.declarations(section) if spec.otherwise):
            value = self.effective(section, name)
            if value is not None:
                known[name] = value
        if self.schema.is_node(section):
            further["plugin"] = self.plugin(section)
        return typed_section(parameters, known, **further)

    def is_changed(self, section: str, name: str) -> bool:
        """Tell whether a value was given, admitted, and is not the default."""
        value = self.get(section, name)
        spec = self.schema.spec_of(section, name, value)
        if value is None or spec is None:
            return False
        default = self.defaults[section].get(name, spec.default)
        return not (_nearly_equal(value, default) if spec.formula else value == default)

    def is_laid_over(self, section: str, name: str) -> bool:
        """Tell whether a value was given in another place than the lines of a file."""
        entry = self.given.get(section, {}).get(name)
        return entry is not None and entry.line is None

    def elements(self, section: str, field: str) -> tuple[str, ...]:
        """Return the named groups of a field that are defined, in the order of the file."""
        given = self.given.get(section, {})
        found = (self.schema.element_of(section, name) for name in given)
        return tuple(dict.fromkeys(e.name for e in found if e is not None and e.field == field))

    def declarations(self, section: str) -> tuple[Declaration, ...]:
        """Return the declarations of a section, with the groups and plug-in parameters given."""
        fields = [field for field, _ in self.schema.named_groups(section)]
        elements = {field: self.elements(section, field) for field in fields}
        return self.schema.declarations(section, elements, self.plugin(section))

    def plugin(self, section: str) -> dict[str, Value]:
        """Return the given parameters ``plugin.<name>`` without their prefix."""
        return {
            name.removeprefix(PLUGIN_PREFIX): entry.value
            for name, entry in self.given.get(section, {}).items()
            if name.startswith(PLUGIN_PREFIX) and entry.value is not None
        }

    def complain(self, section: str, name: str, value: str, requirement: str, remedy: str) -> None:
        """Add a problem, placed at the line of ``section.name`` where that was given."""
        place = self._place(section, name)
        self.problems.append(Problem(*place, f"{section}.{name}", value, requirement, remedy))

    def warn(self, section: str, name: str, text: str) -> None:
        """Add a warning, placed likewise."""
        file, line = self._place(section, name)
        place = file if line is None else f"{file}:{line}"
        self.warnings.append(f"{place}: {section}.{name}: {text}")

    def _place(self, section: str, name: str) -> tuple[str, int | None]:
        entry = self.given.get(section, {}).get(name)
        return (entry.file, entry.line) if entry else (self.source, None)


def check_values(schema: Schema, given: Given, source: str, problems: list[Problem]) -> Checked:
    """Check every value by itself and fill in the defaults, but for those of formulas."""
    checked = Checked(schema, source, given, problems)
    for section in schema.sections:
        checked.values[section], checked.defaults[section] = {}, {}
        for name, entry in checked.given.get(section, {}).items():
            _check_entry(checked, section, name, entry)
        for declaration in checked.declarations(section):
            _fill_in(checked, section, declaration)
    return checked


def _check_entry(checked: Checked, section: str, name: str, entry: Entry) -> None:
    if checked.schema.is_ros_own(section, name) or entry.value is None:
        return
    spec = checked.schema.spec_of(section, name, entry.value)
    if spec is None:
        checked.unknown.append((section, name))
        return
    try:
        value = admissible(spec, entry.value, entry.coerce, entry.written)
        checked.values[section][name] = value
    except Refusal as refusal:
        checked.complain(section, name, refusal.received, refusal.requirement, refusal.remedy)


def _fill_in(checked: Checked, section: str, declaration: Declaration) -> None:
    name, spec = declaration
    entry = checked.given.get(section, {}).get(name)
    if entry is None and not spec.formula:
        checked.values[section][name] = spec.default
    if spec.required and checked.schema.element_of(section, name) is not None:
        value = checked.get(section, name)
        if entry is None or value == []:
            received = "nothing" if entry is None else shown(entry.value)
            checked.complain(section, name, received, spec.requirement, "add it")


def _nearly_equal(value: Value, default: Value) -> bool:
    """Tell whether a default that was written down is that which a formula gives again."""
    pair = [np.array(v if isinstance(v, list) else [v], dtype=np.float64) for v in (value, default)]
    largest = max(float(np.abs(v).max(initial=0.0)) for v in pair)
    return len(pair[0]) == len(pair[1]) and bool(
        (np.abs(pair[0] - pair[1]) <= _ROUNDING * largest).all()
    )


def plain_values(given: Mapping[str, Mapping[str, Entry]]) -> dict[str, dict[str, Value]]:
    """Return the plain values by section and dotted name."""
    return {
        section: {name: entry.value for name, entry in entries.items() if entry.value is not None}
        for section, entries in given.items()
    }
