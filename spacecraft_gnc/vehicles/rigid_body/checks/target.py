"""Checks of a governed flight: start, target and limits.

Only for the governor of this package. What needs a prediction, such as whether a moving start can
be held, the governor itself refuses when it is built (`Scenario.check_cores`).

At rest momentum and torque are zero, so no limit on their norms excludes an equilibrium; pointing
zones alone can. One zone or a pair that leaves nothing is named here. More zones that leave nothing
only together are found all the same: the target then lies outside one of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations
from typing import Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.problems import shown
from spacecraft_gnc.types import Array, Matrix3
from spacecraft_gnc.vehicles.rigid_body.checks.pointing import attitude_of, zones_of
from spacecraft_gnc.vehicles.rigid_body.checks.pointing_cones import (
    ANGLE_TOLERANCE,
    Cone,
    leave_nothing,
)
from spacecraft_gnc.vehicles.rigid_body.chosen import is_governed, method_reads
from spacecraft_gnc.vehicles.rigid_body.controllers.feedback import FeedbackParameters

_GOVERNOR: Final = "reference_governor"
_CONTROLLER: Final = "nmpc_controller"
_ROUNDING: Final = 1e-9  # relative


def check_target(checked: Checked) -> None:
    """Add a problem for each reason why the governor ``attitude`` could not begin."""
    if not is_governed(checked):
        return
    margin = checked.get(_GOVERNOR, "steady_margin_deg")
    if isinstance(margin, float):
        _check_references(checked, math.radians(margin))
        _check_clearance(checked, margin)
    _check_momentum(checked)
    if method_reads(checked, FeedbackParameters):
        _check_feedback(checked)


# Pointing zones: the set of references.


def _check_references(checked: Checked, margin: float) -> None:
    zones = zones_of(checked)
    empty = _check_emptiness(checked, zones, margin)
    known = [zone for zone in zones if zone.name not in empty]
    for what, attitude in _references(checked):
        for zone in known:
            room = zone.margin(attitude)
            told = what != "initial reference" and zone.is_violated(attitude)  # by check_pointing
            if room < margin - ANGLE_TOLERANCE and not told:
                _complain_of_room(checked, what, zone, room, margin)


def _check_emptiness(checked: Checked, zones: list[Cone], margin: float) -> set[str]:
    """Return the names of the zones that leave no reference, by themselves or in pairs."""
    empty = set()
    for zone in zones:
        if zone.allowed[1] <= margin:
            empty.add(zone.name)
            value = f"{math.degrees(zone.half_angle):.6g} deg of {zone.kind}, {_leaving(margin)}"
            _complain_of_cone(checked, zone, value)
    for first, second in combinations([zone for zone in zones if zone.name not in empty], 2):
        if leave_nothing(first, second):
            empty |= {first.name, second.name}  # told by check_pointing
        elif leave_nothing(first.shrunk(margin), second.shrunk(margin)):
            empty |= {first.name, second.name}
            half_angle = f"{math.degrees(second.half_angle):.6g} deg"
            other = f"{first.kind} zone {first.name!r} ({math.degrees(first.half_angle):.6g} deg)"
            value = f"{half_angle} of {second.kind} beside {other}, {_leaving(margin)}"
            _complain_of_cone(checked, second, value)
    return empty


def _references(checked: Checked) -> Iterator[tuple[str, Matrix3]]:
    """Yield what has to be admissible as a reference; the start is, where none is given."""
    initial = checked.get(_GOVERNOR, "initial_reference_rotation_vector")
    if isinstance(initial, list) and initial:
        yield "initial reference", lie.exp(np.array(initial))
    for what in ("target", "start"):
        attitude = attitude_of(checked, what)
        if attitude is not None and (what == "target" or initial == []):
            yield what, attitude


def _check_clearance(checked: Checked, margin: float) -> None:
    """Refuse intermediate references nearer to a zone than any reference may be."""
    clearance = checked.get(_GOVERNOR, "route_clearance_deg")
    if not (checked.get(_GOVERNOR, "route") and checked.get(_CONTROLLER, "zone_names")):
        return
    if isinstance(clearance, float) and clearance < margin:
        need = f"at least {margin:g} deg (reference_governor.steady_margin_deg)"
        remedy = "raise it, or lower steady_margin_deg"
        name = "route_clearance_deg"
        value = f"{clearance!r} deg"
        if name not in checked.given.get(_GOVERNOR, {}):  # blame what was given
            name, value = "steady_margin_deg", f"{margin!r} deg"
            need = f"at most {clearance:g} deg (reference_governor.route_clearance_deg)"
            remedy = "lower it, or raise route_clearance_deg"
        checked.complain(_GOVERNOR, name, value, need, remedy)


_PARAMETERS: Final = {
    "initial reference": (_GOVERNOR, "initial_reference_rotation_vector"),
    "target": (_GOVERNOR, "target_rotation_vector"),
    "start": ("plant", "initial_rotation_vector"),
}


def _complain_of_room(checked: Checked, what: str, zone: Cone, room: float, margin: float) -> None:
    section, name = _PARAMETERS[what]
    place = f"an attitude {math.degrees(room):.6g} deg from the border of {zone.kind} zone"
    value = f"{shown(checked.get(section, name))}, {place} {zone.name!r}"
    need = f"at least {math.degrees(margin):g} deg at rest (reference_governor.steady_margin_deg)"
    remedy = f"choose another {what}, or lower steady_margin_deg"
    if what == "start":
        remedy += ", or give initial_reference_rotation_vector"
    if name not in checked.given.get(section, {}):  # blame what was given
        value = f"with {section}.{name} {value}"
        section, name = _CONTROLLER, f"zones.{zone.name}.half_angle_deg"
    checked.complain(section, name, value, need, remedy)


def _leaving(margin: float) -> str:
    return f"of which a margin of {math.degrees(margin):g} deg leaves nothing"


def _complain_of_cone(checked: Checked, zone: Cone, value: str) -> None:
    need = "an attitude that keeps reference_governor.steady_margin_deg to every zone"
    change = "shrink" if zone.is_exclusion else "widen"
    remedy = f"{change} the cone, or lower steady_margin_deg"
    checked.complain(_CONTROLLER, f"zones.{zone.name}.half_angle_deg", value, need, remedy)


# Limits at the start.


def _check_momentum(checked: Checked) -> None:
    limit = checked.get(_GOVERNOR, "max_momentum")
    momentum = _start_momentum(checked)
    if momentum is None or not (isinstance(limit, float) and limit > 0.0):
        return
    size = math.hypot(*momentum)
    if size > limit * (1.0 + _ROUNDING):
        value = f"{shown(checked.get('plant', 'initial_momentum'))}, of norm {size:.6g} N m s"
        need = f"at most {limit:g} N m s (reference_governor.max_momentum)"
        checked.complain(
            "plant", "initial_momentum", value, need, "start slower, or raise max_momentum"
        )


def _start_momentum(checked: Checked) -> Array | None:
    momentum = checked.get("plant", "initial_momentum")
    return np.array(momentum) if "plant" in checked.given and momentum else None


def _check_feedback(checked: Checked) -> None:
    gains = _gains(checked)
    if gains is None:
        return
    attitude_gain, momentum_gain = gains
    _check_level(checked, attitude_gain)
    _check_start_torque(checked, attitude_gain, momentum_gain)


def _gains(checked: Checked) -> tuple[Matrix3, Matrix3] | None:
    """Return A and K of the law T = -K Pi - e; None where a value that they need was refused."""
    gains = [checked.get(_CONTROLLER, f"feedback_{what}_gain") for what in ("attitude", "momentum")]
    if None in gains:
        return None
    attitude, momentum = (np.array(gain).reshape(3, 3) for gain in gains)
    return attitude, momentum


def _check_level(checked: Checked, attitude_gain: Matrix3) -> None:
    """Refuse a level at which the invariant set holds an unstable equilibrium.

    These lie half a turn about an eigenvector of A from the reference, with W = 2 (tr(A) - a_i).
    Source: Kalabic et al. 2014, (10) and (13).
    """
    level = checked.get(_GOVERNOR, "lyapunov_level")
    smallest = np.linalg.eigvalsh(attitude_gain)[:2]
    unstable = 2.0 * float(smallest.sum())
    if isinstance(level, float) and level >= unstable * (1.0 - _ROUNDING):
        need = (
            f"less than {unstable:.6g} J, the level of the lowest unstable equilibrium (twice the "
            "two smallest eigenvalues of nmpc_controller.feedback_attitude_gain)"
        )
        checked.complain(_GOVERNOR, "lyapunov_level", f"{level!r} J", need, "lower it, or give 0.0")


def _check_start_torque(checked: Checked, attitude_gain: Matrix3, momentum_gain: Matrix3) -> None:
    limit, momentum = checked.get(_GOVERNOR, "max_torque"), _start_momentum(checked)
    start = attitude_of(checked, "start")
    initial = checked.get(_GOVERNOR, "initial_reference_rotation_vector")
    if start is None or momentum is None or not isinstance(initial, list):
        return
    reference = lie.exp(np.array(initial)) if initial else start
    error = 2.0 * lie.vee(attitude_gain @ reference.T @ start)  # vee takes the antisymmetric half
    size = float(np.linalg.norm(momentum_gain @ momentum + error))
    saturation = checked.get(_CONTROLLER, "max_torque")
    if isinstance(saturation, float) and saturation > 0.0:
        size = min(size, saturation)
    if isinstance(limit, float) and 0.0 < limit * (1.0 + _ROUNDING) < size:
        value = f"{limit!r} N m, where the feedback law commands {size:.6g} N m at the start"
        need = "a limit that the start keeps"
        remedy = "raise it, start slower, or give initial_reference_rotation_vector near the start"
        checked.complain(_GOVERNOR, "max_torque", value, need, remedy)
