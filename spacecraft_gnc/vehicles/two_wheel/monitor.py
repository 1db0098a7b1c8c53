"""Watch over reaction wheels: a residual test of the change of speed against the one commanded.

A healthy wheel whose acceleration u is held over the period T, with friction on its relative speed
nu, obeys

    nu' = u - (c nu + tau sign nu) / Js,    |u| <= U,    |nu| <= N.

For a held u this is an autonomous scalar equation, so that nu is monotone over the period and lies
between its two ends. What friction takes of the change of speed is therefore at most
T (c max(|nu_k|, |nu_k+1|) + tau) / Js, and cutting both at the speed limit brings them no further
apart. A residual

    r = nu_k+1 - cut(nu_k + T u)

beyond that bound plus the rounding of the sums cannot come from a wheel that works: with true
bounds on c and tau there is no false alarm, in however many steps (docs/wheel_loss.md).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.arguments import as_count, as_limit, require_positive
from spacecraft_gnc.arrays import as_finite, listed
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.types import Array, ArrayLike, read_only
from spacecraft_gnc.vehicles.two_wheel.state import WheelState

_EPSILON: Final = float(np.finfo(np.float64).eps)
_ROUNDINGS: Final = 4.0
"""Roundings of a speed in one integrator step: a product, a sum, and what friction adds."""


@dataclass(frozen=True, slots=True, eq=False)
class ResidualTest:
    """Residuals of the wheels over one control period, and the bound that a healthy one keeps.

    Attributes
    ----------
    period : float
        Control period T [s].
    wheel_inertias : (m,) array
        Js [kg m^2].
    viscous_friction, coulomb_friction : (m,) arrays
        Upper bounds of c [N m s] and tau [N m].
    max_speed, max_acceleration : float
        Limits at which the wheels saturate [rad/s], [rad/s^2]; 0: none.
    substeps : int
        Sums in which the speed is made over a period; each one may round.

    Raises
    ------
    ShapeError, ParameterError
        If a number is negative, or not one for each wheel.
    """

    period: float
    wheel_inertias: ArrayLike
    viscous_friction: ArrayLike
    coulomb_friction: ArrayLike
    max_speed: float = 0.0
    max_acceleration: float = 0.0
    substeps: int = 1
    slope: Array = field(init=False, repr=False)
    """(m,) T c / Js [-]: bound per speed."""
    offset: Array = field(init=False, repr=False)
    """(m,) T tau / Js [rad/s]."""

    def __post_init__(self) -> None:
        period = require_positive("period", self.period)
        axial = as_finite("wheel_inertias", self.wheel_inertias, np.shape(self.wheel_inertias), "")
        checked: dict[str, Any] = {"period": period, "wheel_inertias": axial}
        for name, bound in (("viscous_friction", "slope"), ("coulomb_friction", "offset")):
            value = as_finite(name, getattr(self, name), axial.shape, "one number for each wheel")
            if value.min(initial=0.0) < 0.0:
                raise ParameterError(
                    f"{name}: received {listed(value)}; required numbers >= 0; give 0 for none"
                )
            checked |= {name: value, bound: read_only(period * value / axial)}
        for name in ("max_speed", "max_acceleration"):
            checked[name] = as_limit(name, getattr(self, name))
        checked["substeps"] = as_count("substeps", self.substeps)
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    def commanded(self, before: Array, told: Array) -> Array:
        """Return the speeds (..., m) that commands ``told`` lead to, within the limits."""
        most = self.max_acceleration or math.inf
        after = before + self.period * np.clip(told, -most, most)
        top = np.maximum(np.abs(before), self.max_speed or math.inf)
        return np.asarray(np.clip(after, -top, top))

    def residual(self, before: Array, told: Array, after: Array) -> Array:
        """Return what the speeds (..., m) ``after`` a step are off those commanded [rad/s]."""
        return np.asarray(after - self.commanded(before, told))

    def threshold(self, before: Array, told: Array, after: Array) -> Array:
        """Return the largest residual (..., m) of a healthy wheel [rad/s]."""
        fastest = np.maximum(np.abs(before), np.abs(after))
        most = self.max_acceleration or math.inf
        reached = fastest + self.period * np.minimum(np.abs(told), most)
        rounding = _ROUNDINGS * _EPSILON * (self.substeps + 1) * reached
        return np.asarray(self.slope * fastest + self.offset + rounding)


class Reading(NamedTuple):
    """What the monitor found at the start of a step."""

    healthy: NDArray[np.bool_]
    """(m,) whether each wheel counts as answering from now on."""
    residual: Array
    """(m,) [rad/s]; NaN: the step before is not known."""
    threshold: Array
    """(m,) [rad/s]; NaN likewise."""
    response: Array
    """(m,) change of speed over the one commanded, -1 to 2 [-]; NaN: none was commanded."""
    deceleration: Array
    """(m,) fall of the speed's size over the last step [rad/s^2]; NaN: not known."""


class WheelMonitor:
    """Exclude the wheels whose change of speed friction cannot explain.

    Parameters
    ----------
    test : ResidualTest

    Notes
    -----
    A wheel that is excluded stays so until `reset`. Of a step whose state, or that before, was
    missed, nothing is concluded. The command is that which the wheels were told over the step
    (`WheelState.applied`), whoever gave it: a command that came too late is no failure of a wheel.
    """

    def __init__(self, test: ResidualTest) -> None:
        self.test = test
        self.reset()

    def reset(self) -> None:
        """Count every wheel as answering, and forget the last state."""
        self._before: WheelState | None = None
        self._healthy = np.ones(len(self.test.offset), dtype=bool)

    def memory(self) -> tuple[Any, ...]:
        """Return the last state, and which wheels count as answering."""
        return self._before, self._healthy

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on as the monitor did whose `memory` it is."""
        before, self._healthy = memory
        self._before = None if before is None else WheelState(*before)

    def observe(self, state: WheelState) -> Reading:
        """Compare the speeds of ``state`` with those of the step before and with its command."""
        before, self._before = self._before, state
        unknown = np.full(len(self._healthy), math.nan)
        if before is None or state.applied is None or state.step != before.step + 1:
            return Reading(self._healthy.copy(), unknown, unknown, unknown, unknown)
        speeds = before.wheel_speed, state.applied, state.wheel_speed
        residual, threshold = self.test.residual(*speeds), self.test.threshold(*speeds)
        known = np.isfinite(residual) & np.isfinite(threshold)
        if not known.all():
            return Reading(self._healthy.copy(), unknown, unknown, unknown, unknown)
        self._healthy &= np.abs(residual) <= threshold
        change = self.test.commanded(*speeds[:2]) - before.wheel_speed
        told = np.abs(change) > threshold
        share = np.divide(speeds[2] - speeds[0], change, out=unknown.copy(), where=told)
        slowed = (np.abs(speeds[0]) - np.abs(speeds[2])) / self.test.period
        response = np.clip(share, -1.0, 2.0)
        return Reading(self._healthy.copy(), residual, threshold, response, slowed)
