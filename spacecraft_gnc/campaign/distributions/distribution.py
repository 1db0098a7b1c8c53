"""What a distribution is, and the parameter that it is for."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

from spacecraft_gnc.parameters.parameter import ParameterSpec, Value
from spacecraft_gnc.types import Array


class Distribution(Protocol):
    """Values of one parameter."""

    @property
    def dimensions(self) -> int:
        """Numbers of a point of the design that a value is made of."""

    @property
    def size(self) -> int | None:
        """How many values there are, of which a grid takes each; None: a continuum."""

    def value(self, point: Array) -> Value:
        """Return the value at a point (dimensions,) in [0, 1), in its ROS 2 form."""

    def extremes(self) -> Iterable[Value]:
        """Return values, of which the parameter's range holds all only if it holds every value."""


@dataclass(frozen=True, slots=True)
class Target:
    """The parameter that is varied."""

    name: str
    """``section.parameter``, dotted."""
    spec: ParameterSpec
    nominal: Value
    """Value in the scenario; the empty list where that has none."""

    @property
    def is_plugin(self) -> bool:
        """Whether it belongs to another package, which alone knows what it holds."""
        return ".plugin." in self.name
