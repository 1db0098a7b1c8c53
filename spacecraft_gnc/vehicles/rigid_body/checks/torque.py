"""Checks of the torque: actuator authority, and time to reach the target."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.problems import shown
from spacecraft_gnc.types import Array, Matrix3
from spacecraft_gnc.vehicles.rigid_body.checks.pointing import attitude_of
from spacecraft_gnc.vehicles.rigid_body.chosen import is_governed, own_method
from spacecraft_gnc.vehicles.rigid_body.descriptor import VEHICLE

_CONTROLLER: Final = "nmpc_controller"
_GOVERNOR: Final = "reference_governor"
_NEGLIGIBLE: Final = 1e-9
"""Share of the largest entry, or singular value, under which another counts as zero."""


def check_torque(checked: Checked) -> None:
    """Add a problem for actuators that cannot control a body, and for a target out of reach."""
    matrix = _actuators(checked)
    if matrix is None:
        return
    if matrix.size:
        _check_actuators(checked, matrix)
        _check_torque_weight(checked, matrix.shape[1])
    _check_reach(checked, _largest_gain(matrix) if matrix.size else 1.0)


def shortest_time(angle: float, momentum: float, torque: float, smallest_moment: float) -> float:
    """Return a time [s] that no slew to rest undercuts, T = (2 max(p, sqrt(U J a + p^2/2)) - p)/U.

    With |Pi(t)| <= min(p + U t, U (T - t)) and |omega| <= |Pi| / J the attitude turns by at most
    the integral of the two lines, ((p + U T)^2 / 4 - p^2 / 2) / (U J), which must reach ``angle``;
    and braking alone takes p / U.

    Parameters
    ----------
    angle : float
        Angle a from the initial to the final attitude [rad].
    momentum : float
        Initial |Pi|, p [N m s].
    torque : float
        Largest |torque|, U > 0 [N m].
    smallest_moment : float
        Smallest principal moment of inertia, J > 0 [kg m^2].
    """
    peak = math.sqrt(torque * smallest_moment * angle + 0.5 * momentum * momentum)
    return (2.0 * max(momentum, peak) - momentum) / torque


def _actuators(checked: Checked) -> Array | None:
    value = checked.get(_CONTROLLER, "actuators")
    return np.array(value).reshape(3, -1) if isinstance(value, list) else None


def _largest_gain(matrix: Array) -> float:
    """Return the largest singular value, of entries of any size."""
    scale = float(np.abs(matrix).max())
    return scale * float(np.linalg.norm(matrix / scale, 2)) if scale > 0.0 else 0.0


def _check_actuators(checked: Checked, matrix: Array) -> None:
    given = shown(checked.get(_CONTROLLER, "actuators"))
    largest = float(np.abs(matrix).max())
    idle = [j + 1 for j, column in enumerate(matrix.T) if np.abs(column).max() <= 1e-12 * largest]
    if idle:
        value = f"{given} with nothing in column {idle[0]}"
        need = "a torque from every actuator (3 x m, row-major)"
        checked.complain(
            _CONTROLLER, "actuators", value, need, "remove the column, or check the order of rows"
        )
        return
    sizes = np.linalg.svd(matrix / largest, compute_uv=False)
    rank = int((sizes > _NEGLIGIBLE * sizes[0]).sum())
    if rank < 2:
        value = f"{given} of rank {rank}"
        need = "torques about two axes or more (rank 2 or 3), to control an attitude at all"
        checked.complain(_CONTROLLER, "actuators", value, need, "add an actuator of another axis")


def _check_torque_weight(checked: Checked, columns: int) -> None:
    """Refuse a 3x3 weight on commands that are not three."""
    name = "weights.stage_torque"
    value = checked.get(_CONTROLLER, name)
    if columns == 3 or not isinstance(value, list) or own_method(checked) is None:
        return
    weight = np.array(value).reshape(3, 3)
    if (weight != weight[0, 0] * np.eye(3)).any():
        need = f"one number, as the actuator matrix has {columns} columns and not 3"
        remedy = f"write for example {float(weight[0, 0])!r}"
        checked.complain(_CONTROLLER, name, shown(value), need, remedy)


def _check_reach(checked: Checked, gain: float) -> None:
    """Refuse a flight that ends before any torque could bring the body to the target, at rest.

    A duration that is laid over the file is meant to cut a flight short and stays allowed, also in
    the file that the launcher saved of such a flight.
    """
    duration = checked.get("plant", "duration")
    cut = checked.is_laid_over("plant", "duration") or checked.get("launcher", "cut_short")
    if cut or not _steers(checked):
        return
    attitudes = attitude_of(checked, "start"), attitude_of(checked, "target")
    motion = _motion(checked)
    limits = _torque_limits(checked, gain)
    if not (isinstance(duration, float) and limits and motion):
        return
    torque, limiting = min(limits)
    start, target = attitudes
    if start is None or target is None:
        return
    moment, momentum, period = motion
    angle = lie.angle_between(start, target)
    soonest = shortest_time(angle, momentum, torque, moment)
    # motion in steps gains less than one of them on the continuous motion of the bound
    if soonest > duration + period:
        need = (
            f"at least {soonest:.4g} s, the shortest time from {math.degrees(angle):.4g} deg and "
            f"|Pi| {momentum:g} N m s to rest at the target with {torque:g} N m at the most"
        )
        remedy = f"lengthen it, or raise {limiting}"
        checked.complain("plant", "duration", f"{duration!r} s", need, remedy)


def _torque_limits(checked: Checked, gain: float) -> list[tuple[float, str]]:
    """Return each limit on |torque| [N m] that is kept, with the parameter that sets it."""
    own = checked.get(_CONTROLLER, "max_torque")
    limits = [(gain * own, f"{_CONTROLLER}.max_torque")] if isinstance(own, float) else []
    kept = checked.get(_GOVERNOR, "max_torque")
    if is_governed(checked) and isinstance(kept, float):
        limits.append((kept, f"{_GOVERNOR}.max_torque"))
    return [limit for limit in limits if limit[0] > 0.0]


def _motion(checked: Checked) -> tuple[float, float, float] | None:
    """Return smallest moment of inertia, |Pi_0| and control period; None where one is missing."""
    inertia = checked.get("plant", "inertia")
    momentum = checked.get("plant", "initial_momentum")
    step = checked.get("plant", "time_step")
    period = checked.get(_CONTROLLER, "time_step")
    if not (inertia and isinstance(step, float) and isinstance(period, float)):
        return None
    if not isinstance(momentum, list):
        return None
    moment = _smallest_moment(np.array(inertia).reshape(3, 3))
    return (moment, math.hypot(*momentum), period or step) if moment > 0.0 else None


def _smallest_moment(inertia: Matrix3) -> float:
    with np.errstate(over="ignore"):
        return float(np.linalg.eigvalsh(inertia)[0])


def _steers(checked: Checked) -> bool:
    """Tell whether a controller and a vehicle that keep to the torque limit fly."""
    nodes = checked.get("launcher", "nodes")
    flies = isinstance(nodes, list) and _CONTROLLER in nodes
    is_ours = checked.get("plant", "vehicle") == VEHICLE.name and own_method(checked) is not None
    return flies and is_ours
