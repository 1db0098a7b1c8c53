"""Checks of the pointing zones: compatible with start and target, and with each other."""

from __future__ import annotations

import math
from itertools import combinations
from typing import Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.problems import shown
from spacecraft_gnc.types import Matrix3
from spacecraft_gnc.vehicles import registry
from spacecraft_gnc.vehicles.rigid_body.checks.pointing_cones import (
    Cone,
    direction,
    implies,
    leave_nothing,
)
from spacecraft_gnc.vehicles.rigid_body.chosen import is_governed, moves
from spacecraft_gnc.vehicles.rigid_body.descriptor import VEHICLE

_CONTROLLER: Final = "nmpc_controller"
_ATTITUDES: Final = {
    "start": ("plant", "initial_rotation_vector"),
    "target": ("reference_governor", "target_rotation_vector"),
}


def check_pointing(checked: Checked) -> None:
    """Add a problem for each pair of zones at odds, and for each that start or target violates.

    Every attitude violates one of two contradictory zones, so these are not held against it.
    """
    zones = zones_of(checked)
    contradictory = set()
    for first, second in combinations(zones, 2):
        if leave_nothing(first, second):
            contradictory |= {first.name, second.name}
            _complain_of_contradiction(checked, first, second)
        elif implies(first, second):
            _complain_of_redundancy(checked, second, first)
        elif implies(second, first):
            _complain_of_redundancy(checked, first, second)
    for what in _ATTITUDES:
        attitude = attitude_of(checked, what)
        if attitude is not None:
            for zone in zones:
                if zone.name not in contradictory and zone.is_violated(attitude):
                    _complain_of_attitude(checked, what, zone, math.degrees(zone.angle(attitude)))


def attitude_of(checked: Checked, what: str) -> Matrix3 | None:
    """Return the start or the target attitude (3, 3); None where the scenario tells of none.

    A node by itself may be given neither; a whole scenario has a plant. A moving reference leads to
    no target.
    """
    section, name = _ATTITUDES[what]
    if what == "target" and moves(checked):
        return None
    if not {"plant", section} & checked.given.keys():
        return None
    value = checked.get(section, name)
    with np.errstate(over="ignore"):
        known = value is not None and math.isfinite(np.linalg.norm(np.array(value)))
    return lie.exp(np.array(value)) if known else None


def zones_of(checked: Checked) -> list[Cone]:
    """Return the listed zones whose parameters were all admitted."""
    listed = checked.get(_CONTROLLER, "zone_names")
    zones = []
    for name in listed if isinstance(listed, list) else ():
        fields = ("kind", "body_axis", "inertial_axis", "half_angle_deg")
        kind, body, cone, half = (checked.get(_CONTROLLER, f"zones.{name}.{f}") for f in fields)
        if isinstance(half, float) and half > 0.0 and kind and body and cone:
            axes = direction(np.array(body)), direction(np.array(cone))
            zones.append(Cone(name, str(kind), *axes, math.radians(half)))
    return zones


def _are_soft(checked: Checked) -> bool:
    """Tell whether zones are terms of the cost, which a flight may violate on its way out."""
    is_hard = is_governed(checked) or checked.get("reference_governor", "governor") is None
    method = registry.known_method(VEHICLE, str(checked.get(_CONTROLLER, "method")))
    return not is_hard and "torque_penalty" in method.reads


def _complain_of_attitude(checked: Checked, what: str, zone: Cone, angle: float) -> None:
    """Blame the attitude where it was given, else the zone that the default lies in.

    A start inside a soft zone is told only: the penalty drives the flight out.
    """
    place = section, name = _ATTITUDES[what]
    stands = f"the {what} at which the body axis is {angle:.6g} deg from the axis of the cone"
    value = f"{shown(checked.get(section, name))}, {stands}"
    if name not in checked.given.get(section, {}):
        place = _half_angle(zone)
        value = f"{_degrees(zone)} deg, with {section}.{name} {value}"
    bound, change = ("at least", "shrink") if zone.is_exclusion else ("at most", "widen")
    need = f"{bound} {_degrees(zone)} deg ({zone.kind} zone {zone.name!r})"
    if what == "start" and _are_soft(checked):
        text = f"{value}; required {need}; the zone is soft: the flight begins inside and leaves it"
        checked.warn(*place, text)
        return
    checked.complain(*place, value, need, f"choose another {what}, or {change} the cone")


def _complain_of_contradiction(checked: Checked, first: Cone, second: Cone) -> None:
    bodies = math.degrees(lie.vector_angle(first.body_axis, second.body_axis))
    cones = math.degrees(lie.vector_angle(first.cone_axis, second.cone_axis))
    other = f"{first.kind} zone {first.name!r} ({_degrees(first)} deg)"
    value = (
        f"{_degrees(second)} deg of {second.kind}, with the cone axis {cones:.6g} deg and the body "
        f"axis {bodies:.6g} deg from that of {other}, which leaves nothing"
    )
    need = "at least one attitude that both zones allow"
    exclusions = first.is_exclusion, second.is_exclusion
    changes = [w for w, due in (("shrink", any(exclusions)), ("widen", not all(exclusions))) if due]
    cone = {"shrink": "an exclusion cone", "widen": "an inclusion cone"}
    remedy = ", ".join(f"{change} {cone[change]}" for change in changes)
    checked.complain(*_half_angle(second), value, need, f"{remedy}, or remove one of the two")


def _complain_of_redundancy(checked: Checked, zone: Cone, stricter: Cone) -> None:
    relation = "inside" if zone.is_exclusion else "around"
    value = (
        f"{_degrees(zone)} deg, a cone wholly {relation} that of {zone.kind} zone "
        f"{stricter.name!r} ({_degrees(stricter)} deg) for the same body axis"
    )
    need = f"a zone that forbids what {stricter.name!r} does not forbid already"
    checked.complain(*_half_angle(zone), value, need, f"remove {zone.name!r}, or mend its axes")


def _half_angle(zone: Cone) -> tuple[str, str]:
    return _CONTROLLER, f"zones.{zone.name}.half_angle_deg"


def _degrees(zone: Cone) -> str:
    return f"{math.degrees(zone.half_angle):.6g}"
