"""What no value shows by itself: whether the values of a scenario fit together.

Every check stays silent where a value that it needs was refused already. NumPy is all that is
needed: no kernel is compiled to say that a file is wrong.
"""

from __future__ import annotations

import re

import numpy as np

from spacecraft_gnc.parameters.parameter import Value, specs_of
from spacecraft_gnc.parameters.problems import shown, suggestion
from spacecraft_gnc.scenario import registry
from spacecraft_gnc.scenario.checked import Checked
from spacecraft_gnc.scenario.checks_governor import check_governor_parameters
from spacecraft_gnc.scenario.checks_method import check_method
from spacecraft_gnc.scenario.schema import SECTIONS, PlantParameters
from spacecraft_gnc.solvability import largest_free_step
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.checks.pointing import check_pointing
from spacecraft_gnc.vehicles.rigid_body.checks.target import check_target
from spacecraft_gnc.vehicles.rigid_body.checks.torque import check_torque

MAXIMUM_STEPS = 10**9
_STEP_TOLERANCE = 1e-12  # relative; the closed loop compares the periods as strictly
_ZONE_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def check_all(checked: Checked) -> None:
    """Add a problem for each pair of values that do not fit together."""
    _check_names(checked)
    check_method(checked)
    check_governor_parameters(checked)
    _check_zones(checked)
    _check_inertia(checked)
    _check_times(checked)
    _check_momentum(checked)
    check_pointing(checked)
    check_target(checked)
    check_torque(checked)


def steps_in(period: float, step: float) -> int | None:
    """Return how many steps make up a period; None where that is no whole number."""
    ratio = period / step
    if not ratio < MAXIMUM_STEPS:
        return None
    count = round(ratio)
    return count if count >= 1 and abs(ratio - count) <= _STEP_TOLERANCE * count else None


def _check_names(checked: Checked) -> None:
    for section, parameters in SECTIONS.items():
        for name, spec in specs_of(parameters):
            value = checked.get(section, name)
            if not spec.plugins or not isinstance(value, str):
                continue
            if not registry.is_known(spec.plugins, value):
                known = registry.names(spec.plugins)
                need = f"one of {', '.join(known)}"
                checked.complain(section, name, shown(value), need, suggestion(value, known))


def _check_zones(checked: Checked) -> None:
    listed = checked.get("nmpc_controller", "zone_names")
    if not isinstance(listed, list):
        return
    defined = checked.zone_names()
    for name in listed:
        if not _ZONE_NAME.fullmatch(name):
            need = "a name of letters, digits and _ that starts with no digit"
            checked.complain("nmpc_controller", "zone_names", shown(name), need, "rename the zone")
        elif name not in defined:
            need = f"its definition under zones.{name}"
            remedy = f"define it, or remove {name!r} from zone_names"
            checked.complain("nmpc_controller", "zone_names", shown(name), need, remedy)
    for name in defined:
        if name not in listed:
            field = next(key for key in checked.given["nmpc_controller"] if f"zones.{name}." in key)
            need = f"{name!r} among zone_names"
            remedy = f"add it to zone_names, or remove zones.{name}"
            checked.complain("nmpc_controller", field, "a zone that is not listed", need, remedy)


def _check_inertia(checked: Checked) -> None:
    """Ask for the plant's inertia where the plant, or a controller without its own, needs it."""
    value = checked.get("plant", "inertia")
    needed = "plant" in checked.given or (
        "nmpc_controller" in checked.given and checked.get("nmpc_controller", "inertia") == []
    )
    if value == [] and needed:
        spec = dict(specs_of(PlantParameters))["inertia"]
        remedy = "add it, such as [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]"
        checked.complain("plant", "inertia", "nothing", spec.requirement, remedy)


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


def _check_momentum(checked: Checked) -> None:
    """Check Kalabic (3) for the plant's step, and for the controller's prediction step."""
    momentum = checked.get("plant", "initial_momentum")
    inertia = checked.get("plant", "inertia")
    believed = checked.get("nmpc_controller", "inertia") or inertia
    for section, body in (("plant", inertia), ("nmpc_controller", believed)):
        step = checked.get(section, "time_step")
        if body and momentum and isinstance(step, float) and step > 0.0:
            largest = largest_free_step(_matrix(body), np.array(momentum))
            if step > largest:
                need = (
                    "(h hat(Pi))^2 + 4 Jd^2 >= 0 (Kalabic et al. 2014, (3)) in free motion from "
                    f"plant.initial_momentum {shown(momentum)}: less than {largest:.6g} s"
                )
                remedy = "use a smaller time step, or less momentum"
                checked.complain(section, "time_step", f"{step!r} s", need, remedy)


def _matrix(value: Value) -> Array:
    return np.array(value, dtype=np.float64).reshape(3, 3)
