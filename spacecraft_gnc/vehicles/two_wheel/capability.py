"""Checks of a scenario against what its wheels and its method are capable of.

What makes a flight impossible, or what is told of it false, is refused. What may be flown on
purpose is warned of (docs/two_wheel.md).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.problems import shown
from spacecraft_gnc.types import Array, Matrix3
from spacecraft_gnc.vehicles.two_wheel.hold import holdable, is_negligible
from spacecraft_gnc.vehicles.two_wheel.start import attitude_at, rotation
from spacecraft_gnc.vehicles.two_wheel.wheels import span_of

_PLANT, _CONTROLLER, _GOVERNOR = "plant", "nmpc_controller", "reference_governor"
_TOLERANT: Final = "fault_tolerant"
_BLIND: Final = ("feedback", "shooting", "underactuated")
"""Methods that do not watch the wheels."""
_FRICTIONS: Final = ("wheel_viscous_friction", "wheel_coulomb_friction")
_LIMITS: Final = ("max_wheel_speed", "max_wheel_acceleration")
_SLACK: Final = 1.0 + 1e-9


def check(checked: Checked) -> None:
    """Add a problem or a warning for each thing that wheels or method cannot do."""
    if checked.problems or _PLANT not in checked.given:
        return
    _check_motors(checked)
    _check_losses(checked)
    if checked.get(_CONTROLLER, "method") == _TOLERANT:
        _check_bounds(checked)
    if not checked.problems:
        _check_momentum(checked)


def _check_motors(checked: Checked) -> None:
    """Refuse Coulomb friction that holds a wheel at rest whatever is commanded."""
    friction = checked.get(_PLANT, "wheel_coulomb_friction")
    most = checked.get(_PLANT, "max_wheel_acceleration")
    if not friction or not most:
        return
    torque = _numbers(checked, "wheel_inertias") * most
    for i in np.flatnonzero(np.array(friction) >= torque).tolist()[:1]:
        checked.complain(
            _PLANT, "wheel_coulomb_friction", shown(friction),
            f"less than the largest torque of the motor, {torque[i]:.6g} N m for wheel {i + 1} "
            "(inertia times max_wheel_acceleration), else it cannot start",
            "lower it or raise max_wheel_acceleration; a wheel that is stuck is lost: "
            "wheel_lost_at: 0.0",
        )  # fmt: skip


def _check_losses(checked: Checked) -> None:
    """Warn of losses after which the method does not reach its target."""
    lost, method = checked.get(_PLANT, "wheel_lost_at"), checked.get(_CONTROLLER, "method")
    if not _lost(checked).any():
        return
    if method in _BLIND:
        more = " with three wheels or more" if method == "underactuated" else ""
        checked.warn(
            _PLANT, "wheel_lost_at",
            f"received {shown(lost)} with method: {method}, which does not notice a lost wheel and "
            f"may never reach the target; required method: {_TOLERANT}{more} to survive it; choose "
            "it, unless the loss is flown on purpose",
        )  # fmt: skip
    elif method == _TOLERANT and (left := span_of(_axes(checked)[:, ~_lost(checked)])) < 2:
        checked.warn(
            _PLANT, "wheel_lost_at",
            f"received {shown(lost)}, which leaves axes that span {left} dimension(s); required 2 "
            "to hold an attitude: what is left only brakes; lose fewer wheels",
        )  # fmt: skip


def _check_bounds(checked: Checked) -> None:
    """Warn of bounds beyond which the monitor excludes wheels that work."""
    believed = np.array(checked.effective(_CONTROLLER, "wheel_inertias"))
    scale = believed / _numbers(checked, "wheel_inertias")
    for name in _FRICTIONS:
        bound: Any = checked.get(_CONTROLLER, name)
        rubs: Any = checked.get(_PLANT, name)
        if not rubs:
            continue
        least = np.array(rubs) * scale
        if (np.array(bound or rubs) * _SLACK < least).any():
            checked.warn(
                _CONTROLLER, name,
                f"received {shown(bound or rubs)}; required at least the friction of the plant, "
                f"{shown(least.tolist())}, else healthy wheels are excluded as lost; raise it, or "
                "leave it out",
            )  # fmt: skip
    for name in _LIMITS:
        limit: Any = checked.get(_CONTROLLER, name)
        real: Any = checked.get(_PLANT, name)
        if limit and real and limit > real:
            checked.warn(
                _CONTROLLER, name,
                f"received {shown(limit)}; required at most plant.{name}, {shown(real)}, else a "
                "wheel at its limit is excluded as lost; lower it, or leave it out",
            )  # fmt: skip


def _check_momentum(checked: Checked) -> None:
    """Refuse total momentum that the wheels cannot carry where it is to be held.

    A method that does not tell what it holds may fly it: that is warned of.
    """
    top = float(_numbers(checked, "max_wheel_speed"))
    inertia = np.reshape(_numbers(checked, "inertia"), (3, 3))
    name, momentum = _momentum(checked, inertia)
    if not top or is_negligible(inertia, momentum):
        return
    method = checked.get(_CONTROLLER, "method")
    if method not in (*_BLIND, _TOLERANT) or method == "underactuated":
        return  # of another package; refuses any momentum
    for what, attitude, wheels in _holds(checked, inertia, momentum):
        speed = _least_speed(wheels, attitude.T @ momentum)
        if not speed > top * _SLACK:
            continue
        size = float(np.linalg.norm(momentum))
        need = (
            f"at most {size * top / speed:.6g} N m s of its {size:.6g} N m s, which is what {what} "
            "can carry at rest there within max_wheel_speed"
        )
        remedy = "lower it, or raise max_wheel_speed"
        if method == _TOLERANT:
            checked.complain(_PLANT, name, shown(checked.get(_PLANT, name)), need, remedy)
        else:
            value = shown(checked.get(_PLANT, name))
            checked.warn(_PLANT, name, f"received {value}; required {need}; {remedy}")
        return


def _holds(
    checked: Checked, inertia: Matrix3, momentum: Array
) -> Iterator[tuple[str, Matrix3, Array]]:
    """Yield which wheels have to carry the momentum, at which attitude, and their A Js (3, w).

    Of lost wheels that spin on, it is not known beforehand what they carry.
    """
    axes, axial = _axes(checked), _numbers(checked, "wheel_inertias")
    target = rotation(np.array(checked.get(_GOVERNOR, "target_rotation_vector")))
    if span_of(axes) == 3:
        yield f"{axial.size} wheels", target, axes * axial
    left = ~_lost(checked)
    stops = checked.get(_PLANT, "wheel_loss") != "spinning"
    told = checked.get(_CONTROLLER, "method") == _TOLERANT and stops and not left.all()
    if told and span_of(axes[:, left]) >= 2:
        still = np.zeros(axial.size)
        held = holdable(inertia, axes, axial, left, still, momentum, target)
        yield f"the {int(left.sum())} wheels left", held.attitude, (axes * axial)[:, left]


def _momentum(checked: Checked, inertia: Matrix3) -> tuple[str, Array]:
    """Return the parameter that gives the total momentum, and that (3,), inertial frame."""
    given = checked.get(_PLANT, "initial_total_momentum")
    if given:
        return "initial_total_momentum", np.array(given)
    rate = _numbers(checked, "initial_angular_velocity")
    axes, axial = _axes(checked), _numbers(checked, "wheel_inertias")
    speed = np.array(checked.get(_PLANT, "initial_wheel_speed") or np.zeros(axial.size))
    start: list[Any] = [
        checked.get(_PLANT, name) for name in ("initial_euler_321", "initial_rotation_vector")
    ]
    total = attitude_at(*start) @ (inertia @ rate + (axes * axial) @ speed)
    return ("initial_angular_velocity" if rate.any() else "initial_wheel_speed"), total


def _least_speed(wheels: Array, momentum: Array) -> float:
    """Return the least largest speed at which A Js (3, w) hold a momentum (3,), body frame.

    Of fewer than three directions: the part that they can hold.
    """
    if wheels.shape[1] <= 3:
        return float(np.abs(np.linalg.pinv(wheels) @ momentum).max())
    from scipy.optimize import linprog  # loaded where it is needed

    m, size = wheels.shape[1], float(np.linalg.norm(wheels, axis=0).max())
    bound = np.block([[np.eye(m), -np.ones((m, 1))], [-np.eye(m), -np.ones((m, 1))]])
    rows = np.hstack([wheels / size, np.zeros((3, 1))])
    projected = wheels @ np.linalg.pinv(wheels) @ momentum / size
    found = linprog(
        np.append(np.zeros(m), 1.0), bound, np.zeros(2 * m), rows, projected, (None, None)
    )
    return float(found.fun) if found.success else math.nan


def _axes(checked: Checked) -> Array:
    """Return the unit axes (3, m) of the plant."""
    axes = np.reshape(_numbers(checked, "wheel_axes"), (3, -1))
    return np.asarray(axes / np.linalg.norm(axes, axis=0))


def _lost(checked: Checked) -> NDArray[np.bool_]:
    """Tell which wheels (m,) are lost in the flight."""
    times = checked.get(_PLANT, "wheel_lost_at")
    m = _numbers(checked, "wheel_inertias").size
    return np.array(times) >= 0.0 if times else np.zeros(m, dtype=bool)


def _numbers(checked: Checked, name: str) -> Array:
    """Return numbers of the plant."""
    return np.array(checked.get(_PLANT, name), dtype=np.float64)
