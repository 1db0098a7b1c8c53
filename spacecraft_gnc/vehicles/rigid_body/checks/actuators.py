"""Check of the plant's actuators: whether they can do what the controller may ask for."""

from __future__ import annotations

from typing import Final

import numpy as np

from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.vehicles.rigid_body.chosen import is_governed, own_law, own_method
from spacecraft_gnc.vehicles.rigid_body.controllers import planned
from spacecraft_gnc.vehicles.rigid_body.governors.laws import PLANNED

_PLANT: Final = "plant"
_CONTROLLER: Final = "nmpc_controller"
_GOVERNOR: Final = "reference_governor"


def check_actuators(checked: Checked) -> None:
    """Warn of a limit of the plant below what its controller may ask for."""
    limit = _number(checked, _PLANT)
    if not limit or own_method(checked) is None:
        return
    asked = _asked(checked)
    if not asked:
        checked.warn(
            _PLANT, "max_torque",
            f"received {limit!r} N m beside a controller without a torque limit; required a limit "
            f"that the plant can give, else what is asked for is cut; set "
            f"{_CONTROLLER}.{_own_limit(checked)} to {limit!r}, unless that is flown on purpose",
        )  # fmt: skip
        return
    most, name = min(asked)
    if limit < most:
        checked.warn(
            _PLANT, "max_torque",
            f"received {limit!r} N m; required at least {most:.6g} N m, which {name} lets be asked "
            f"for about an axis, else that is cut; raise it, or lower {name}",
        )  # fmt: skip


def _asked(checked: Checked) -> list[tuple[float, str]]:
    """Return what each limit lets be asked for about an axis [N m], with its parameter."""
    asked = [(_gain(checked) * _number(checked, _CONTROLLER), f"{_CONTROLLER}.max_torque")]
    if is_governed(checked):
        asked.append((_number(checked, _GOVERNOR), f"{_GOVERNOR}.max_torque"))
    if own_method(checked) is planned.METHOD:
        asked.append(_of_plan(checked, _CONTROLLER))
    if own_law(checked) is PLANNED:
        asked.append(_of_plan(checked, _GOVERNOR))
    return [one for one in asked if one[0] > 0.0]


def _of_plan(checked: Checked, section: str) -> tuple[float, str]:
    """Return the largest bound of plans; 0 where an axis has none."""
    bounds = checked.get(section, "plan.torque_bounds")
    sizes = np.abs(np.array(bounds if isinstance(bounds, list) else [], dtype=np.float64))
    most = float(sizes.max(initial=0.0))
    return most if np.isfinite(most) else 0.0, f"{section}.plan.torque_bounds"


def _gain(checked: Checked) -> float:
    """Return the largest torque about an axis of actuator commands of norm 1."""
    matrix = checked.get(_CONTROLLER, "actuators")
    if not isinstance(matrix, list) or not matrix:
        return 1.0
    return float(np.linalg.norm(np.reshape(matrix, (3, -1)), axis=1).max())


def _number(checked: Checked, section: str) -> float:
    value = checked.get(section, "max_torque")
    return value if isinstance(value, float) else 0.0


def _own_limit(checked: Checked) -> str:
    is_plan = own_method(checked) is planned.METHOD
    return "plan.torque_bounds" if is_plan else "max_torque"
