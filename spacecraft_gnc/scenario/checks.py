"""Checks across the values of a scenario.

Every check stays silent where a value that it needs was refused already. NumPy is all that is
needed: no kernel is compiled to say that a file is wrong. What concerns one vehicle only, the
vehicle checks itself.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final

from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.parameter import Group, specs_of
from spacecraft_gnc.parameters.problems import InvalidScenario, shown, suggestion
from spacecraft_gnc.scenario.checks_reads import check_reads
from spacecraft_gnc.scenario.schema import schema_of
from spacecraft_gnc.vehicles import registry
from spacecraft_gnc.vehicles.vehicle import Vehicle

MAXIMUM_STEPS = 10**9
_STEP_TOLERANCE = 1e-12  # relative; the closed loop compares the periods as strictly
_ELEMENT_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_MOST_LISTED: Final = 3  # parameters of another vehicle that a line names


def check_all(checked: Checked, vehicle: Vehicle) -> None:
    """Add a problem for each pair of values that do not fit together."""
    _check_unknown(checked, vehicle)
    _check_names(checked, vehicle)
    check_reads(checked, vehicle)
    for section in checked.schema.sections:
        for field, group in checked.schema.named_groups(section):
            _check_elements(checked, section, field, group)
    _check_times(checked)
    if vehicle.checks is not None:
        vehicle.checks.load()(checked)


def steps_in(period: float, step: float) -> int | None:
    """Return how many steps make up a period; None where that is no whole number."""
    ratio = period / step
    if not ratio < MAXIMUM_STEPS:
        return None
    count = round(ratio)
    return count if count >= 1 and abs(ratio - count) <= _STEP_TOLERANCE * count else None


def _check_unknown(checked: Checked, vehicle: Vehicle) -> None:
    """Complain of unknown parameters, at once of those that belong to another vehicle."""
    schema = checked.schema
    other = _other_vehicle(checked, vehicle)
    foreign = [] if other is None else _known_to(other, checked.unknown)
    if other is not None:
        listed = ", ".join(f"{s}.{n}" for s, n in foreign[:_MOST_LISTED])
        more = len(foreign) - _MOST_LISTED
        beside = f"{listed} and {more} more" if more > 0 else listed
        value = f"{shown(vehicle.name)} beside parameters of vehicle {other.name} ({beside})"
        need = "sections of one vehicle"
        remedy = f"set vehicle: {other.name}, or remove them"
        checked.complain("plant", "vehicle", value, need, remedy)
    for section, name in checked.unknown:
        if (section, name) in foreign:
            continue
        elsewhere = [s for s in schema.sections if name in schema.known_names(s)]
        known = schema.known_names(section, like=name)
        remedy = f"move it to {elsewhere[0]}" if elsewhere else suggestion(name, known)
        need = f"a parameter of {section}"
        checked.complain(section, name, "an unknown parameter", need, remedy)


def _other_vehicle(checked: Checked, vehicle: Vehicle) -> Vehicle | None:
    """Return the vehicle that knows the most of what this one does not know; None: no one does."""
    if not checked.unknown:
        return None
    others = (other for other in _vehicles() if other.name != vehicle.name)
    counted = [(len(_known_to(other, checked.unknown)), other) for other in others]
    most, best = max(counted, key=lambda pair: pair[0], default=(0, None))
    return best if most else None


def _vehicles() -> Iterator[Vehicle]:
    """Yield every vehicle that can be imported."""
    for name in registry.names(registry.VEHICLES):
        try:
            yield registry.vehicle_of(name)
        except InvalidScenario:
            continue


def _known_to(vehicle: Vehicle, names: list[tuple[str, str]]) -> list[tuple[str, str]]:
    schema = schema_of(vehicle)
    return [(s, name) for s, name in names if schema.spec_of(s, name, None) is not None]


def _check_names(checked: Checked, vehicle: Vehicle) -> None:
    for section, parameters in checked.schema.sections.items():
        for name, spec in specs_of(parameters):
            value = checked.get(section, name)
            if not spec.plugins or not isinstance(value, str):
                continue
            if not registry.is_known(spec.plugins, value, vehicle):
                known = registry.names(spec.plugins, vehicle)
                need = f"one of {', '.join(known)}"
                checked.complain(section, name, shown(value), need, suggestion(value, known))


def _check_elements(checked: Checked, section: str, field: str, group: Group) -> None:
    """Check that the groups which are listed, such as zones, are those which are defined."""
    listed = checked.get(section, group.names)
    if not isinstance(listed, list):
        return
    defined = checked.elements(section, field)
    for name in listed:
        if not _ELEMENT_NAME.fullmatch(name):
            need = "a name of letters, digits and _ that starts with no digit"
            checked.complain(section, group.names, shown(name), need, f"rename the {group.noun}")
        elif name not in defined:
            need = f"its definition under {field}.{name}"
            remedy = f"define it, or remove {name!r} from {group.names}"
            checked.complain(section, group.names, shown(name), need, remedy)
    for name in defined:
        if name not in listed:
            key = next(key for key in checked.given[section] if f"{field}.{name}." in key)
            need = f"{name!r} among {group.names}"
            remedy = f"add it to {group.names}, or remove {field}.{name}"
            checked.complain(section, key, f"a {group.noun} that is not listed", need, remedy)


def _check_times(checked: Checked) -> None:
    step = checked.get("plant", "time_step")
    period = checked.get("nmpc_controller", "time_step")
    duration = checked.get("plant", "duration")
    if not isinstance(step, float) or not isinstance(period, float):
        return
    if period > 0.0 and steps_in(period, step) is None:
        multiple = max(1, round(period / step)) * step if period / step < MAXIMUM_STEPS else step
        need = f"a whole multiple of plant.time_step ({step:g} s)"
        remedy = f"use for example {multiple!r}"
        checked.complain("nmpc_controller", "time_step", f"{period!r} s", need, remedy)
        return
    period = period or step
    if not isinstance(duration, float):
        return
    if duration < period * (1.0 - _STEP_TOLERANCE):
        need = f"at least one control step ({period:g} s)"
        checked.complain("plant", "duration", f"{duration!r} s", need, "lengthen it")
    elif duration / period > MAXIMUM_STEPS:
        need = f"at most {MAXIMUM_STEPS:.0e} control steps of {period:g} s"
        checked.complain("plant", "duration", f"{duration!r} s", need, "shorten it")
