"""Limits of actuators: what they give of a control that is asked for, and how often it is less."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from itertools import repeat
from operator import le
from typing import Final, NamedTuple

import numpy as np

from spacecraft_gnc.arrays import listed
from spacecraft_gnc.types import Array, ArrayLike

Cut = Callable[[Array], Array]
"""Returns what is given of a control: the same object where nothing exceeds a limit."""
_ROUNDING: Final = 1e-9
"""Share of a control of which less is no shortfall: a law may be on the limit but for rounding."""


class Shortfall(NamedTuple):
    """A control step on which actuators gave less than asked for."""

    step: int
    asked: Array
    given: Array
    unit: str

    def __str__(self) -> str:
        """Return the step and both controls."""
        asked, given = (listed(np.ravel(control)) for control in (self.asked, self.given))
        return f"step {self.step}: asked for {asked} {self.unit}, given {given} {self.unit}"


class Actuators:
    """Actuators of one plant, which asks them on every control step.

    Parameters
    ----------
    cut : Cut, optional
        None: they give whatever is asked for.
    unit : str
        Of a control, for messages.

    Attributes
    ----------
    shortfalls : int
        Control steps since the start on which they gave less than asked for.
    last : Shortfall or None
        The last one of these.
    """

    def __init__(self, cut: Cut | None, unit: str) -> None:
        self._cut, self._unit = cut, unit
        self.reset()

    def reset(self) -> None:
        """Forget what was asked for."""
        self.shortfalls = 0
        self.last: Shortfall | None = None

    @property
    def are_limited(self) -> bool:
        """Whether there is anything that they do not give."""
        return self._cut is not None

    def given(self, control: Array) -> Array:
        """Return what they give of a control, which is the same object where that is all of it."""
        return control if self._cut is None else self._cut(control)

    def drive(self, step: int, control: Array) -> Array:
        """Return what they give of the control of a step, and count the step where it is less."""
        given = self.given(control)
        if given is not control and _is_less(given, control):
            self.shortfalls += 1
            self.last = Shortfall(step, control, given, self._unit)
        return given


def component_limits(limits: ArrayLike) -> Cut | None:
    """Return what cuts each component of a control to its limit, or to one for all.

    Infinity is no limit; None: no component has one.
    """
    most = np.array(limits, dtype=np.float64)
    if np.isinf(most).all():
        return None

    each: Iterable[float] = most.tolist() if most.ndim else repeat(float(most))

    def cut(control: Array) -> Array:
        if control.ndim == 1 and all(map(le, map(abs, control.tolist()), each)):
            return control  # found without NumPy in a third of the time
        return np.clip(control, -most, most) if (np.abs(control) > most).any() else control

    return cut


def norm_limit(limit: float) -> Cut | None:
    """Return what cuts each row of a control (n, 3) to a norm, in its direction; None: no limit."""
    if math.isinf(limit):
        return None

    def cut(control: Array) -> Array:
        size = np.hypot.reduce(control, axis=1)  # the squares may overflow
        beyond = size > limit
        if not beyond.any():
            return control
        share = np.where(beyond, limit / np.where(beyond, size, 1.0), 1.0)
        return np.asarray(control * share[:, None])

    return cut


def _is_less(given: Array, asked: Array) -> bool:
    """Tell whether more than rounding is missing."""
    with np.errstate(over="ignore"):
        missing = np.abs(asked - given)
    return bool((missing > _ROUNDING * np.abs(asked)).any())
