"""A decoded message: its numbers where the layout says they lie."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from spacecraft_gnc.types import Array

NS_PER_S = 1_000_000_000
Stamp = tuple[int, int]
"""Seconds and nanoseconds."""


def period_ns(period: float) -> int:
    """Return a control period [s] in whole nanoseconds: simulated time never rounds again."""
    return round(period * NS_PER_S)


def stamp_of(step: int, period_in_ns: int) -> Stamp:
    """Return the simulated time t_k of a control step."""
    return divmod(step * period_in_ns, NS_PER_S)


class Refused(Exception):
    """A message that must not reach a core.

    Parameters
    ----------
    reason
        Why, for people.
    kind
        Why, to be counted: ``seal``, ``layout``, ``step``, ``time`` or ``values``. Nodes count
        under two more: ``rate`` and ``request``.
    """

    def __init__(self, reason: str | None, kind: str = "values") -> None:
        super().__init__(reason)
        self.kind = kind


class Message:
    """A decoded message of a signal.

    Parameters
    ----------
    slots
        Its values in order of declaration; strings as bytes.
    places
        Where each field lies among them: one value, or a slice of several.
    """

    __slots__ = ("places", "slots")

    def __init__(self, slots: tuple[Any, ...], places: Mapping[str, Any]) -> None:
        self.slots = slots
        self.places = places

    @property
    def stamp(self) -> Stamp:
        """Time of its header."""
        seconds, nanoseconds = self.slots[self.places["stamp"]]
        return seconds, nanoseconds

    @property
    def step(self) -> int:
        """Control step that it belongs to."""
        step: int = self.slots[self.places["step"]]
        return step

    def __getitem__(self, name: str) -> Any:
        """Return a field: a number, a tuple of numbers, or a text."""
        value = self.slots[self.places[name]]
        if isinstance(value, bytes):
            return value.rstrip(b"\0").decode(errors="replace")
        return value

    def array(self, name: str) -> Array:
        """Return the numbers (n,) of a field."""
        return np.array(self.slots[self.places[name]])
