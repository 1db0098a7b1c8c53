"""Defaults that follow from the spacecraft, its torque limit and the wanted settling time.

About a principal axis, at the target, the body is the double integrator J a'' = u. In units of its
inertia, of 1/omega and of J omega^2 every such axis of every spacecraft is the same one, and so the
weights are those of one nondimensional problem: of the law u = -J (omega^2 eta + 2 omega eta'),
critically damped, with the terminal weights that give about this law at any horizon from 2 steps on
(test/scenario/test_defaults.py; docs/tuning.md derives them).

Each formula stands in words beside its parameter; docs/scenario.md prints them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Final, TypeAlias

import numpy as np

from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.formulas import Formula
from spacecraft_gnc.parameters.parameter import LARGEST, LARGEST_WEIGHT, LONGEST, SHORTEST, Value
from spacecraft_gnc.types import Array, Matrix3
from spacecraft_gnc.vehicles.rigid_body.parameters.known import SATURATION, SETTLING, Values

_PLANT: Final = "plant"
_CONTROLLER: Final = "nmpc_controller"
_GOVERNOR: Final = "reference_governor"

STEPS: Final = 80.0
"""Control periods in a settling time."""
FEWEST_STEPS: Final = 40.0
"""Control periods in the settling time that is computed for a given period."""
FREE_SETTLING: Final = 60.0
"""[s] where neither a torque limit nor a step asks for another."""
HORIZON: Final = 0.25
"""Settling times that the horizon covers, with `FEWEST` to `MOST` steps."""
FEWEST, MOST = 5, 60
MOST_STEPS: Final = 0.999e9
"""Of a flight; `checks` admits 1e9."""
PENALTY: Final = 1e6
"""Of the torque limit, in units of the torque weight over the limit squared."""
ZONE_PENALTY: Final = 1e5
"""In units of the weight of the attitude."""
SMALLEST: Final = 1e-4
"""Eigenvalue of a default weight, in units of its largest."""
FLATTEST: Final = 1e-3
"""Share of tr(J) that keeps the feedback gain of a flat body positive definite."""
_NANOSECOND: Final = 1e-9


def formulas(checked: Checked) -> Iterator[Formula]:
    """Yield the formula of each default, in the order of their dependence."""
    known = Values(checked)
    zones = [
        (_CONTROLLER, f"zones.{name}.penalty", _zone_penalty)
        for name in checked.elements(_CONTROLLER, "zones")
    ]
    for section, name, formula in (*_FORMULAS, *zones):
        yield Formula(section, name, partial(formula, known))


def _settling_time(known: Values) -> float:
    """Return 4 sqrt(J_max / max_torque), at least 40 given periods; 80 of them without a limit."""
    limit = known.number(_CONTROLLER, "max_torque")
    period = known.given(_CONTROLLER, "time_step") or known.given(_PLANT, "time_step")
    if limit > 0.0:
        ratio = SETTLING / math.sqrt(SATURATION)
        time = max(ratio * math.sqrt(known.largest_moment / limit), FEWEST_STEPS * period)
    else:
        time = STEPS * period or FREE_SETTLING
    return _within(time, STEPS * SHORTEST, 0.25 * LONGEST)


def _time_step(known: Values) -> float:
    own = known.number(_CONTROLLER, "time_step")
    if own > 0.0:
        return own
    moments = np.linalg.eigvalsh(known.inertia)
    thinnest = 0.5 * float(moments.sum()) - float(moments[-1])
    step = known.number(_CONTROLLER, "settling_time") / STEPS
    step = min(step, max(0.5 * thinnest / known.largest_momentum, 1e-3 * step))
    whole = math.floor(step / _NANOSECOND * (1.0 + 1e-12)) * _NANOSECOND
    return _within(round(whole, 9), SHORTEST, LONGEST)


def _duration(known: Values) -> float:
    limit = known.number(_CONTROLLER, "max_torque")
    braking = 2.0 * known.momentum / limit if limit > 0.0 else 0.0
    settling = known.number(_CONTROLLER, "settling_time")
    longest = min(LONGEST, MOST_STEPS * known.period)
    return _within(3.0 * settling + braking, known.period, longest)


def _horizon(known: Values) -> int:
    steps = HORIZON * known.number(_CONTROLLER, "settling_time") / known.period
    return int(_within(round(min(steps, MOST)), FEWEST, MOST))


def _stage_torque(known: Values) -> float:
    """Return 1 / u_0^2, or what stands in the ratio of the formulas to a weight that was given."""
    for name, formula in _FROM_TORQUE.items():
        if not known.is_given_and_read(f"weights.{name}"):
            continue
        size = float(np.linalg.eigvalsh(known.weight(name))[-1])
        unit = float(np.linalg.eigvalsh(formula(known, np.eye(1)))[-1])
        if size > 0.0:
            return _within(size / unit, 1.0 / LARGEST_WEIGHT, LARGEST_WEIGHT)
    return _within(known.torque_scale**-2, 1.0 / LARGEST_WEIGHT, LARGEST_WEIGHT)


def _control_weight(known: Values) -> Matrix3:
    """Return S of the stage_torque Q: the cost is h u . S u, S = (tr(Q) I - Q) / 2."""
    weight = known.weight("stage_torque")
    actuators = known.numbers(_CONTROLLER, "actuators")
    if len(actuators) not in (0, 9):
        return np.asarray(weight[:1, :1])
    return np.asarray(0.5 * (np.trace(weight) * np.eye(3) - weight))


def _stage_attitude(known: Values, control: Matrix3) -> Matrix3:
    return known.bandwidth**4 * _weight_of(known.acceleration_effort(control))


def _stage_momentum(known: Values, control: Matrix3) -> Matrix3:
    return 2.0 * known.bandwidth**2 * _weight_of(known.effort(control))


def _terminal_attitude(known: Values, control: Matrix3) -> Matrix3:
    omega = known.bandwidth
    steps = max(known.number(_CONTROLLER, "horizon") - 1.0, 1.0)
    slope = math.hypot(1.0 / (steps * known.period), 2.0 * omega)
    return omega**2 * slope * _weight_of(known.acceleration_effort(control))


def _terminal_momentum(known: Values, control: Matrix3) -> Matrix3:
    return 2.0 * known.bandwidth * _weight_of(known.effort(control))


def _torque_penalty(known: Values) -> float:
    size = float(np.linalg.eigvalsh(_control_weight(known))[-1])
    demand = max(1.0, known.torque_scale / known.limit)
    return _within(PENALTY * demand * size / known.limit**2, 1.0 / LARGEST_WEIGHT, LARGEST_WEIGHT)


def _zone_penalty(known: Values) -> float:
    span = known.number(_CONTROLLER, "horizon") * known.period
    stage, end = known.weight("stage_attitude"), known.weight("terminal_attitude")
    sizes = [float(np.linalg.eigvalsh(weight)[-1]) for weight in (stage, end / span)]
    return _within(ZONE_PENALTY * max(sizes), 1.0 / LARGEST_WEIGHT, LARGEST_WEIGHT)


def _attitude_gain(known: Values) -> Value:
    inertia = known.inertia
    gain = known.bandwidth**2 * ((0.5 + FLATTEST) * np.trace(inertia) * np.eye(3) - inertia)
    return _plain(gain * min(1.0, LARGEST / float(np.abs(gain).max())))


def _momentum_gain(known: Values) -> Value:
    return _plain(2.0 * known.bandwidth * np.eye(3))


def _slew_rate_tolerance(known: Values) -> float:
    return _rounded(math.radians(known.number(_GOVERNOR, "slew_tolerance_deg")) * known.bandwidth)


_Weight: TypeAlias = Callable[[Values, Matrix3], Matrix3]
_FROM_TORQUE: Final[dict[str, _Weight]] = {
    "stage_attitude": _stage_attitude,
    "stage_momentum": _stage_momentum,
    "terminal_attitude": _terminal_attitude,
    "terminal_momentum": _terminal_momentum,
}


def _weighing(formula: _Weight) -> Callable[[Values], Value]:
    def default(known: Values) -> Value:
        weight = formula(known, _control_weight(known))
        largest = float(np.abs(weight).max())
        scaled = weight * min(1.0, LARGEST_WEIGHT / largest) if largest > 0.0 else weight
        numbers = _plain(scaled)
        isotropic = numbers == [numbers[0] * (i % 4 == 0) for i in range(9)]
        return numbers[0] if isotropic else numbers

    return default


_FORMULAS: Final[tuple[tuple[str, str, Callable[[Values], Value]], ...]] = (
    (_CONTROLLER, "settling_time", _settling_time),
    (_PLANT, "time_step", _time_step),
    (_PLANT, "duration", _duration),
    (_CONTROLLER, "horizon", _horizon),
    (_CONTROLLER, "weights.stage_torque", _stage_torque),
    *((_CONTROLLER, f"weights.{name}", _weighing(f)) for name, f in _FROM_TORQUE.items()),
    (_CONTROLLER, "torque_penalty", _torque_penalty),
    (_CONTROLLER, "feedback_attitude_gain", _attitude_gain),
    (_CONTROLLER, "feedback_momentum_gain", _momentum_gain),
    (_GOVERNOR, "slew_rate_tolerance", _slew_rate_tolerance),
)


def _weight_of(effort: Matrix3) -> Matrix3:
    """Return E(X) of X = ``effort``: tr(X) I - 2 X, eigenvalues at least `SMALLEST` of the largest.

    The cost of Q = E(X) is h x . (tr(Q) I - Q) x / 2 = h x . X x, for rotation vectors and momenta.
    """
    weight = np.trace(effort) * np.eye(3) - (effort + effort.T)
    values, vectors = np.linalg.eigh(weight)
    if values[0] >= SMALLEST * values[-1]:
        return np.asarray(weight)
    kept = (vectors * np.maximum(values, SMALLEST * values[-1])) @ vectors.T
    return np.asarray(0.5 * (kept + kept.T))


def _plain(matrix: Array) -> list[float]:
    return [_rounded(float(number)) for number in matrix.ravel()]


def _rounded(number: float) -> float:
    """Return 12 digits of a number: it reads well, and libraries of linear algebra agree on it."""
    return float(f"{number:.12g}")


def _within(value: float, lowest: float, highest: float) -> float:
    return min(max(_rounded(value), lowest), highest) if math.isfinite(value) else highest
