"""Defaults that follow from bus, wheels and the wanted settling time.

With the bandwidth w of the feedback law a turn from rest takes a torque of at most w^2 J_1 and a
momentum of at most w J_1 / 2, where J_1 is the largest moment of inertia. Wheels that start without
momentum give every torque up to s U and every momentum up to s N (two wheels: of their plane),
where s is the least singular value of A Js, U the limit of acceleration and N that of speed
(docs/two_wheel.md).

Each formula stands in words beside its parameter; docs/scenario.md prints them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Final

import numpy as np

from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.formulas import Formula, Missing
from spacecraft_gnc.parameters.parameter import LONGEST, SHORTEST, Value
from spacecraft_gnc.vehicles.two_wheel.start import attitude_at

_PLANT, _CONTROLLER, _GOVERNOR = "plant", "nmpc_controller", "reference_governor"
SETTLING: Final = 8.0
"""w times the settling time: (1 + 8) exp(-8) is 0.1 deg of 30 deg."""
STEPS: Final = 80.0
"""Control periods in a settling time."""
FEWEST_STEPS: Final = 40.0
"""Control periods in the settling time that is computed for a given period."""
FREE_SETTLING: Final = 60.0
"""[s] where neither a limit nor a step asks for another."""
FREE_SPEED: Final = 10.0
"""[rad/s] from which a lost wheel stops in a settling time where no limit asks for another."""
LARGEST_TURN: Final = 0.2
"""[rad] in an integrator step, at the initial rate."""
_NANOSECOND: Final = 1e-9
_START: Final = (
    "initial_euler_321",
    "initial_rotation_vector",
    "inertia",
    "wheel_axes",
    "wheel_inertias",
    "initial_wheel_speed",
)


def formulas(checked: Checked) -> Iterator[Formula]:
    """Yield the formula of each default, in the order of their dependence."""
    for section, name, formula in _FORMULAS:
        yield Formula(section, name, partial(formula, checked))


def _settling_time(checked: Checked) -> float:
    period = _given(checked, _CONTROLLER, "time_step") or _given(checked, _PLANT, "time_step")
    fastest = min(_bandwidths(checked), default=math.inf)
    if math.isfinite(fastest):
        time = max(SETTLING / fastest, FEWEST_STEPS * period)
    else:
        time = STEPS * period or FREE_SETTLING
    return _within(time, STEPS * SHORTEST, 0.25 * LONGEST)


def _bandwidths(checked: Checked) -> Iterator[float]:
    """Yield the largest bandwidth that each limit allows [rad/s]."""
    acceleration = _effective(checked, "max_wheel_acceleration")
    speed = _number(checked, _PLANT, "max_wheel_speed")
    if not (acceleration or speed):
        return
    inertia = np.reshape(_array(checked, "inertia"), (3, 3))
    axes = np.reshape(_array(checked, "wheel_axes"), (3, -1))
    axial = _array(checked, "wheel_inertias")
    if axes.shape[1] != axial.size:
        raise Missing
    wheels = axes / np.linalg.norm(axes, axis=0) * axial
    if axial.size < 2:
        raise Missing  # a rank that the checks refuse
    weakest = float(np.linalg.svd(wheels, compute_uv=False)[-1])
    if not weakest > 0.0:
        raise Missing  # likewise
    share = weakest / float(np.linalg.eigvalsh(inertia)[-1])
    if acceleration:
        yield math.sqrt(share * acceleration)
    if speed:
        yield 2.0 * share * speed


def _time_step(checked: Checked) -> float:
    own = _number(checked, _CONTROLLER, "time_step")
    if own > 0.0:
        return own
    step = _number(checked, _CONTROLLER, "settling_time") / STEPS
    rate = _initial_rate(checked)
    if rate > 0.0:
        step = min(step, max(LARGEST_TURN / rate, 1e-3 * step))
    whole = math.floor(step / _NANOSECOND * (1.0 + 1e-12)) * _NANOSECOND
    return _within(round(whole, 9), SHORTEST, LONGEST)


def _initial_rate(checked: Checked) -> float:
    """Return the size of the initial rate, from the total momentum where that is given [rad/s]."""
    total = _list(checked, _PLANT, "initial_total_momentum")
    if not total:
        return float(np.linalg.norm(_list(checked, _PLANT, "initial_angular_velocity")))
    angles, vector, inertia, axes, axial, speed = (_list(checked, _PLANT, x) for x in _START)
    columns = np.reshape(axes, (3, -1))
    m = columns.shape[1]
    if not inertia or not m or len(axial) != m or len(speed) not in (0, m):
        raise Missing  # refused by the checks
    wheels = columns / np.linalg.norm(columns, axis=0) * axial
    body = attitude_at(angles, vector).T @ total - wheels @ (speed or np.zeros(m))
    return float(np.linalg.norm(np.linalg.solve(np.reshape(inertia, (3, 3)), body)))


def _duration(checked: Checked) -> float:
    period = _number(checked, _CONTROLLER, "time_step") or _number(checked, _PLANT, "time_step")
    settling = _number(checked, _CONTROLLER, "settling_time")
    return _within(3.0 * settling, period, min(LONGEST, 0.999e9 * period))


def _bandwidth(checked: Checked) -> float:
    return _rounded(SETTLING / _number(checked, _CONTROLLER, "settling_time"))


def _rate_tolerance(checked: Checked) -> float:
    tolerance = math.radians(_number(checked, _GOVERNOR, "slew_tolerance_deg"))
    return _rounded(tolerance * SETTLING / _number(checked, _CONTROLLER, "settling_time"))


def _lost_wheel_friction(checked: Checked) -> float:
    lost = max(_list(checked, _PLANT, "wheel_lost_at"), default=-1.0) >= 0.0
    if not lost or checked.get(_PLANT, "wheel_loss") != "friction":
        return 0.0
    axial = max(_list(checked, _PLANT, "wheel_inertias"), default=math.nan)
    if not axial > 0.0:
        raise Missing
    deceleration = 0.1 * _number(checked, _PLANT, "max_wheel_acceleration")
    settling = _number(checked, _CONTROLLER, "settling_time")
    return _rounded(axial * (deceleration or FREE_SPEED / settling))


_FORMULAS: Final[tuple[tuple[str, str, Callable[[Checked], Value]], ...]] = (
    (_CONTROLLER, "settling_time", _settling_time),
    (_PLANT, "time_step", _time_step),
    (_PLANT, "duration", _duration),
    (_PLANT, "lost_wheel_friction", _lost_wheel_friction),
    (_CONTROLLER, "feedback_bandwidth", _bandwidth),
    (_GOVERNOR, "slew_rate_tolerance", _rate_tolerance),
)


def _number(checked: Checked, section: str, name: str) -> float:
    value = checked.get(section, name)
    if not isinstance(value, int | float):
        raise Missing
    return float(value)


def _effective(checked: Checked, name: str) -> float:
    value = checked.effective(_CONTROLLER, name)
    if not isinstance(value, int | float):
        raise Missing
    return float(value)


def _array(checked: Checked, name: str) -> np.ndarray:
    value = checked.effective(_CONTROLLER, name)
    if not isinstance(value, list) or not value:
        raise Missing
    return np.array(value, dtype=np.float64)


def _list(checked: Checked, section: str, name: str) -> list[float]:
    value = checked.get(section, name)
    if not isinstance(value, list):
        raise Missing
    return value


def _given(checked: Checked, section: str, name: str) -> float:
    """Return a number that was given; 0 where none was."""
    is_given = name in checked.given.get(section, {})
    return _number(checked, section, name) if is_given else 0.0


def _within(value: float, least: float, most: float) -> float:
    return _rounded(min(max(value, least), most))


def _rounded(value: float) -> float:
    return float(f"{value:.12g}")
