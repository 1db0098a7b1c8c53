"""Checks of a scenario: bus, wheels, start and method."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np

from spacecraft_gnc.errors import GncError
from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.parameter import specs_of
from spacecraft_gnc.parameters.problems import problem_of, shown
from spacecraft_gnc.vehicles.two_wheel import capability
from spacecraft_gnc.vehicles.two_wheel.controllers.fault_tolerant import checks as fault_tolerant
from spacecraft_gnc.vehicles.two_wheel.controllers.feedback import FeedbackParameters
from spacecraft_gnc.vehicles.two_wheel.controllers.methods import METHODS
from spacecraft_gnc.vehicles.two_wheel.controllers.underactuated import checks as underactuated
from spacecraft_gnc.vehicles.two_wheel.parameters.plant import PlantParameters
from spacecraft_gnc.vehicles.two_wheel.wheels import as_axes, as_axial, require_bus, require_span

_PLANT, _CONTROLLER = "plant", "nmpc_controller"
_SLACK: Final = 1e-9
"""Share of a control period by which sums of it may be off."""
_EXAMPLES: Final = {
    "inertia": "[1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]",
    "wheel_axes": "[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]",
    "wheel_inertias": "[0.01, 0.01, 0.01]",
}

_OF_EACH_WHEEL: Final = (
    "initial_wheel_speed",
    "wheel_lost_at",
    "wheel_viscous_friction",
    "wheel_coulomb_friction",
)
_OF_A_KIND: Final = (
    ("lost_wheel_friction", "friction", 0.0),
    ("lost_wheel_share", "partial", 0.5),
)
"""What only one kind of loss reads, and its default otherwise."""
_INSTEAD: Final = {
    "initial_euler_321": "initial_rotation_vector",
    "initial_total_momentum": "initial_angular_velocity",
}
"""What stands instead of what."""


def check(checked: Checked) -> None:
    """Add a problem for each pair of values that do not fit together."""
    _check_given(checked)
    for section in (_PLANT, _CONTROLLER):
        _check_wheels(checked, section)
    _check_start(checked)
    _check_losses(checked)
    _check_belief(checked)
    fault_tolerant.check(checked)
    underactuated.check(checked)
    capability.check(checked)


def _check_given(checked: Checked) -> None:
    """Ask for what every plant, and every controller that is alone, has to know."""
    specs = dict(specs_of(PlantParameters))
    alone = _PLANT not in checked.given and _CONTROLLER in checked.given
    for name, example in _EXAMPLES.items():
        missing = checked.get(_PLANT, name) == []
        needed = not alone or checked.get(_CONTROLLER, name) == []
        if missing and needed and (_PLANT in checked.given or alone):
            need, remedy = specs[name].requirement, f"add it, such as {example}"
            checked.complain(_PLANT, name, "nothing", need, remedy)


def _check_wheels(checked: Checked, section: str) -> None:
    """Check axes and inertias of the wheels against each other and against the bus."""
    axes = checked.effective(section, "wheel_axes")
    axial = checked.effective(section, "wheel_inertias")
    inertia = checked.effective(section, "inertia")
    if not (axes and axial and inertia) or (section == _CONTROLLER and not _has_belief(checked)):
        return
    m = np.size(axes) // 3
    if np.size(axial) != m:
        need = f"{m} numbers [kg m^2], one for each column of wheel_axes"
        checked.complain(section, "wheel_inertias", shown(axial), need, "write one for each wheel")
        return

    def fit() -> None:
        unit = as_axes(np.reshape(axes, (3, m)))
        require_span(unit, 2)
        require_bus(np.reshape(inertia, (3, 3)), unit, as_axial(np.array(axial), m))

    _complain_of(checked, section, fit)


def _check_start(checked: Checked) -> None:
    """Check what is one number for each wheel, and the initial speeds against their limit."""
    axes = checked.get(_PLANT, "wheel_axes")
    m = np.size(axes) // 3 if axes else 0
    for name in _OF_EACH_WHEEL:
        value = checked.get(_PLANT, name)
        if value and m and np.size(value) != m:
            need = f"{m} numbers, one for each column of wheel_axes, or none"
            checked.complain(_PLANT, name, shown(value), need, "write one for each wheel")
    speed, limit = checked.get(_PLANT, "initial_wheel_speed"), _limit(checked, "max_wheel_speed")
    if speed and limit and np.abs(speed).max() > limit:
        need = f"at most max_wheel_speed ({limit:g} rad/s) in size"
        checked.complain(_PLANT, "initial_wheel_speed", shown(speed), need, "lower it")
    for name, other in _INSTEAD.items():
        if checked.get(_PLANT, name) and checked.is_changed(_PLANT, other):
            value, need = shown(checked.get(_PLANT, other)), f"either it or {name}"
            checked.complain(_PLANT, other, value, need, "remove one of them")


def _check_losses(checked: Checked) -> None:
    """Check that wheels are lost within the flight, and that what is said of them has a use."""
    lost, duration = checked.get(_PLANT, "wheel_lost_at"), checked.get(_PLANT, "duration")
    period = checked.get(_CONTROLLER, "time_step") or checked.get(_PLANT, "time_step")
    latest = max(lost, default=-1.0) if isinstance(lost, list) else -1.0
    if latest >= 0.0 and isinstance(duration, float) and isinstance(period, float):
        last = (math.floor(duration / period + _SLACK) - 1) * period
        if latest > last + _SLACK * period:
            need = f"times up to the start of the last control step ({last:g} s)"
            remedy = "lose the wheel earlier, or lengthen the flight; negative: it is never lost"
            checked.complain(_PLANT, "wheel_lost_at", shown(lost), need, remedy)
    kind = checked.get(_PLANT, "wheel_loss")
    for name, of, unused in _OF_A_KIND:
        if checked.is_changed(_PLANT, name) and kind != of:
            value, need = shown(checked.get(_PLANT, name)), f"wheel_loss: {of} beside it"
            remedy = f"give {unused} or leave it out, or set wheel_loss: {of}"
            checked.complain(_PLANT, name, value, need, remedy)


def _check_belief(checked: Checked) -> None:
    """Check that the method can command every torque, and as many wheels as there are."""
    axes, real = checked.effective(_CONTROLLER, "wheel_axes"), checked.get(_PLANT, "wheel_axes")
    if not axes:
        return
    if real and np.size(axes) != np.size(real):
        value, m = f"{np.size(axes) // 3} wheels", np.size(real) // 3
        need = f"as many as plant.wheel_axes has ({m})"
        checked.complain(_CONTROLLER, "wheel_axes", value, need, "write one column for each wheel")
        return
    if _needs_all_torques(checked):
        section = _CONTROLLER if checked.get(_CONTROLLER, "wheel_axes") else _PLANT
        spans = np.reshape(axes, (3, -1))
        _complain_of(checked, section, lambda: require_span(as_axes(spans)))


def _needs_all_torques(checked: Checked) -> bool:
    """Tell whether the method commands a torque about every axis."""
    name = checked.get(_CONTROLLER, "method")
    read = next((method.parameters for method in METHODS if method.name == name), None)
    return read is not None and issubclass(read, FeedbackParameters)


def _has_belief(checked: Checked) -> bool:
    """Tell whether the controller believes something else than the plant has."""
    return any(checked.get(_CONTROLLER, name) for name in _EXAMPLES)


def _limit(checked: Checked, name: str) -> float:
    value = checked.get(_PLANT, name)
    return float(value) if isinstance(value, int | float) else 0.0


def _complain_of(checked: Checked, section: str, work: Callable[[], Any]) -> None:
    """Add the problem that a core would have."""
    try:
        work()
    except GncError as error:
        problem = problem_of(error, checked.source, section, checked.schema.known_names(section))
        if problem is None:
            raise
        name = problem.key.removeprefix(f"{section}.")
        told = problem.value, problem.requirement, problem.remedy
        if not any(p.key == problem.key and p.value == problem.value for p in checked.problems):
            checked.complain(section, name, *told)
