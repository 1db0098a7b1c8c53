"""Limits exceeded by a flight, with their factors."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Final, NamedTuple

TOLERATED: Final = 1e-3
"""Share of a limit by which a flight may exceed it: penalties let a little through."""


class Exceedance(NamedTuple):
    """A limit that a flight exceeded."""

    limit: str
    """Which one: ``torque``, ``torque -x``, ``momentum``, ``zone NAME``."""
    factor: float
    """Largest value as a multiple of the limit; of a zone, 1 + depth / half-angle."""
    value: float
    """Largest value in the limit's unit; of a zone, how deep the axis was beyond its border."""
    bound: float
    """The limit; of a zone, its half-angle."""
    unit: str

    def __str__(self) -> str:
        """Return which limit, the factor and the numbers behind it."""
        if self.unit == "deg":
            numbers = f"{self.value:.4g} deg beyond the border of a cone of {self.bound:g} deg"
        else:
            numbers = f"{self.value:.4g} {self.unit}, limit {self.bound:g} {self.unit}"
        return f"{self.limit} {self.factor:.4g} times ({numbers})"


def beyond(found: Iterable[Exceedance]) -> tuple[Exceedance, ...]:
    """Return those that are exceeded by more than 0.1 %."""
    return tuple(each for each in found if each.factor > 1.0 + TOLERATED)


def as_dicts(exceeded: Sequence[Exceedance]) -> list[dict[str, Any]]:
    """Return the exceeded limits, each with its line of text, ready for JSON."""
    return [{**each._asdict(), "text": str(each)} for each in exceeded]
