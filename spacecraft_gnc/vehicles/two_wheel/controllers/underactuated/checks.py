"""Checks of a scenario that two wheels fly: number of wheels, momentum, start, horizon, solver."""

from __future__ import annotations

import math
from importlib.util import find_spec
from typing import Any, Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.problems import shown
from spacecraft_gnc.vehicles.two_wheel.controllers.underactuated import weights_of
from spacecraft_gnc.vehicles.two_wheel.euler import from_euler_321, to_euler_321
from spacecraft_gnc.vehicles.two_wheel.ocp.problem import WheelOcp

_PLANT, _CONTROLLER, _GOVERNOR = "plant", "nmpc_controller", "reference_governor"
_NEGLIGIBLE: Final = 1e-9
"""Rate [rad/s] that total momentum may give the bus: a degree in half a year."""
_SHORTEST: Final = 4
"""Steps of the horizon for which every target is proved to be reached (docs/full_range.md)."""
_SINGULAR: Final = 0.01
"""Cosine of the pitch below which 3-2-1 angles are no coordinates."""


def check(checked: Checked) -> None:
    """Add a problem for each reason why two wheels cannot fly it."""
    if checked.get(_CONTROLLER, "solver") == "ipopt" and find_spec("casadi") is None:
        checked.complain(
            _CONTROLLER, "solver", "ipopt", "CasADi for it, which is not installed",
            "pip install 'spacecraft_gnc[reference]', or choose solver: sqp",
        )  # fmt: skip
    if checked.problems:
        return
    method = checked.get(_CONTROLLER, "method")
    if method == "fault_tolerant":
        _check_shaped(checked)
    if method != "underactuated":
        return
    start = _Start(checked)
    if start.is_complete and _are_two(checked, start):
        _check_momentum(checked, start)
        _check_angles(checked, start)
        _check_horizon(checked, start)


class _Start:
    """Numbers of the start, as plant and controller have them."""

    def __init__(self, checked: Checked) -> None:
        believed: dict[str, Any] = {
            name: checked.effective(_CONTROLLER, name) for name in _BELIEVED
        }
        self.is_complete = all(believed.values()) and _PLANT in checked.given
        if not self.is_complete:
            return
        axes = np.reshape(believed["wheel_axes"], (3, -1))
        self.inertia = np.reshape(believed["inertia"], (3, 3))
        self.wheels = axes / np.linalg.norm(axes, axis=0) * np.array(believed["wheel_inertias"])
        angles = checked.get(_PLANT, "initial_euler_321")
        vector = np.array(checked.get(_PLANT, "initial_rotation_vector"))
        self.attitude = from_euler_321(np.array(angles)) if angles else lie.exp(vector)
        self.target = lie.exp(np.array(checked.get(_GOVERNOR, "target_rotation_vector")))
        speed = checked.get(_PLANT, "initial_wheel_speed")
        self.speed = np.array(speed) if speed else np.zeros(self.wheels.shape[1])


_BELIEVED: Final = ("inertia", "wheel_axes", "wheel_inertias")


def _are_two(checked: Checked, start: _Start) -> bool:
    m = int(start.wheels.shape[1])
    if m != 2:
        section = _CONTROLLER if checked.get(_CONTROLLER, "wheel_axes") else _PLANT
        checked.complain(
            section, "wheel_axes", f"{m} wheels", "2 for method: underactuated",
            "remove the others, or choose another method, such as shooting",
        )  # fmt: skip
    return m == 2


def _check_momentum(checked: Checked, start: _Start) -> None:
    """Refuse a start with total momentum, which two wheels cannot bring to rest everywhere."""
    given = checked.get(_PLANT, "initial_total_momentum")
    rate = np.array(checked.get(_PLANT, "initial_angular_velocity"))
    total = np.array(given) if given else start.inertia @ rate + start.wheels @ start.speed
    left = float(np.linalg.norm(np.linalg.solve(start.inertia, total)))
    if left > _NEGLIGIBLE:
        name = "initial_total_momentum" if given else "initial_angular_velocity"
        checked.complain(
            _PLANT, name, shown(checked.get(_PLANT, name)),
            "no total momentum: rest at the target is impossible with two wheels and "
            f"{float(np.linalg.norm(total)):.3g} N m s",
            "give initial_total_momentum: [0.0, 0.0, 0.0], or choose method: fault_tolerant, which "
            "holds what can be held",
        )  # fmt: skip


def _check_angles(checked: Checked, start: _Start) -> None:
    """Refuse a start at the singularity of the angles that the model is written in."""
    model = checked.get(_CONTROLLER, "prediction_model")
    if model == "so3":
        return
    frame = _problem(checked, start).frame
    pitch = to_euler_321(frame.T @ start.target.T @ start.attitude @ frame)[1]
    if math.cos(pitch) < _SINGULAR:
        angles = checked.get(_PLANT, "initial_euler_321")
        name = "initial_euler_321" if angles else "initial_rotation_vector"
        checked.complain(
            _PLANT, name, shown(checked.get(_PLANT, name)),
            f"a pitch off +-90 deg from the target for prediction_model: {model}; it is "
            f"{math.degrees(pitch):.4g} deg",
            "start elsewhere, or choose prediction_model: so3",
        )  # fmt: skip


def _check_horizon(checked: Checked, start: _Start) -> None:
    """Refuse a horizon in which the wheels do not stop, or too short for the end of a plan."""
    if checked.problems:
        return
    ocp = _problem(checked, start)
    most = ocp.time_step * ocp.max_acceleration or math.inf
    stop = math.ceil(float(np.abs(start.speed).max()) / most * (1.0 - 1e-12))
    if stop > ocp.horizon:
        need, remedy = f"at least {stop} steps, in which the wheels come to rest", "lengthen it"
        checked.complain(_CONTROLLER, "horizon", str(ocp.horizon), need, remedy)
    elif checked.get(_CONTROLLER, "terminal") == "hard":
        _check_reach(checked, start, ocp)
    else:
        _check_shaped(checked)


def _check_shaped(checked: Checked) -> None:
    """Refuse a horizon with which a spacecraft may stop on the way to its target."""
    horizon: Any = checked.get(_CONTROLLER, "horizon")
    if checked.get(_CONTROLLER, "terminal") == "shaped" and horizon < _SHORTEST:
        checked.complain(
            _CONTROLLER, "horizon", str(horizon),
            f"at least {_SHORTEST} steps for terminal: shaped, else it may stop on the way",
            f"give {_SHORTEST} or more; 30 is the default",
        )  # fmt: skip


def _check_reach(checked: Checked, start: _Start, ocp: WheelOcp) -> None:
    """Refuse a horizon with no plan that ends at the target."""
    from spacecraft_gnc.vehicles.two_wheel.ocp.horizon import shortest_horizon  # kernels
    from spacecraft_gnc.vehicles.two_wheel.ocp.sqp import SqpSolver

    state = start.attitude, start.speed, start.target
    if SqpSolver(ocp).solve(*state).converged:
        return
    shortest = shortest_horizon(ocp, *state)
    found = "none was found" if shortest is None else f"{shortest} steps are the fewest found"
    checked.complain(
        _CONTROLLER, "horizon", str(ocp.horizon),
        f"a horizon with a plan that ends at rest at the target for terminal: hard; {found}",
        "lengthen it, or choose terminal: shaped",
    )  # fmt: skip


def _problem(checked: Checked, start: _Start) -> WheelOcp:
    """Return the problem of the controller."""
    c: dict[str, Any] = {name: checked.get(_CONTROLLER, name) for name in _OF_PROBLEM}
    limits: dict[str, Any] = {
        name: checked.effective(_CONTROLLER, f"max_wheel_{name.removeprefix('max_')}") or 0.0
        for name in ("max_speed", "max_acceleration")
    }
    model = str(checked.get(_CONTROLLER, "prediction_model"))
    weights = weights_of(model, np.array(checked.get(_CONTROLLER, "attitude_weights")))
    period: Any = checked.get(_CONTROLLER, "time_step") or checked.get(_PLANT, "time_step")
    return WheelOcp(
        start.inertia,
        start.wheels,
        period,
        attitude_weights=weights,
        model=model,
        **limits,
        **c,
    )


_OF_PROBLEM: Final = ("horizon", "speed_weight", "acceleration_weight", "terminal_weight")
