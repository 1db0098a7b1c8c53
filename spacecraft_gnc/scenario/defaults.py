"""Defaults that follow from other values, by the formulas of the vehicle."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TypeAlias

import numpy as np

from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.formulas import Formula, Missing
from spacecraft_gnc.parameters.parameter import Value
from spacecraft_gnc.parameters.sections import DEFAULT_VEHICLE
from spacecraft_gnc.parameters.values import Refusal, admissible, plain
from spacecraft_gnc.scenario.schema import schema_of
from spacecraft_gnc.vehicles import registry
from spacecraft_gnc.vehicles.vehicle import Vehicle

Stated: TypeAlias = Mapping[str, Mapping[str, Value]]
"""Section -> dotted name -> the default that counts in place of the formula's."""


def fill_in(checked: Checked, vehicle: Vehicle, stated: Stated) -> None:
    """Work out the defaults that follow from other values, in the order of their dependence."""
    for section, defaults in stated.items():
        for name, default in defaults.items():
            _take_stated(checked, section, name, default)
    for section, name, formula in _formulas(checked, vehicle):
        if name in checked.defaults[section]:
            continue
        try:
            with np.errstate(all="ignore"):
                _take(checked, section, name, plain(formula()))
        except (Missing, np.linalg.LinAlgError):
            continue  # a value that was refused, or that the checks refuse


def _formulas(checked: Checked, vehicle: Vehicle) -> Iterator[Formula]:
    if vehicle.defaults is not None:
        yield from vehicle.defaults.load()(checked)


def _take_stated(checked: Checked, section: str, name: str, default: Value) -> None:
    """Take a default that a recording states, if it is one of what that holds."""
    spec, element = checked.schema.spec_of(section, name, default), None
    if spec is not None:
        element = checked.schema.element_of(section, name)
    is_absent = element is not None and element.name not in checked.elements(section, element.field)
    if spec is None or is_absent:
        return
    try:
        _take(checked, section, name, admissible(spec, default, coerce=True))
    except Refusal as refusal:
        remedy = f"{refusal.remedy} in the defaults that the recording states"
        checked.complain(section, name, refusal.received, refusal.requirement, remedy)


def _take(checked: Checked, section: str, name: str, default: Value) -> None:
    checked.defaults[section][name] = default
    if name not in checked.given.get(section, {}) or checked.get(section, name) == []:
        checked.values[section][name] = default


def former_defaults(sections: Mapping[str, Mapping[str, Value]]) -> Stated:
    """Return the defaults of a recorded scenario that states none: those of before the formulas."""
    former = _vehicle_in(sections).former_defaults
    return {} if former is None else former.load()(sections)


def follows_from_formula(
    sections: Mapping[str, Mapping[str, Value]], section: str, name: str
) -> bool:
    """Tell whether a parameter of a scenario has a default that follows from other values."""
    spec = schema_of(_vehicle_in(sections)).spec_of(section, name, None)
    return spec is not None and bool(spec.formula)


def _vehicle_in(sections: Mapping[str, Mapping[str, Value]]) -> Vehicle:
    return registry.vehicle_of(str(sections.get("plant", {}).get("vehicle", DEFAULT_VEHICLE)))
