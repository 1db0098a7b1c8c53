"""Laws of one real number: the inverse of a cumulative distribution, u in [0, 1) to a number."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist
from typing import Final, Protocol

_LEAST: Final = 2.0**-54
_MOST: Final = 1.0 - 2.0**-53
"""Probabilities of a normal number stay within these: what is drawn has 53 bits."""
_STANDARD: Final = NormalDist()


class Law(Protocol):
    """One real number; rises with u."""

    def number(self, u: float) -> float:
        """Return the number below which one lies with probability ``u``."""

    @property
    def lowest(self) -> float:
        """Smallest number that can come out."""

    @property
    def highest(self) -> float:
        """Largest number that can come out."""


@dataclass(frozen=True, slots=True)
class Uniform:
    """Uniform from ``lowest`` to ``highest``."""

    lowest: float
    highest: float

    def number(self, u: float) -> float:
        """Return the number at the share ``u`` of the way."""
        number = (1.0 - u) * self.lowest + u * self.highest
        return min(max(number, self.lowest), self.highest)


@dataclass(frozen=True, slots=True)
class Whole:
    """Whole numbers from ``lowest`` to ``highest``, all equally probable."""

    lowest: int
    highest: int

    def number(self, u: float) -> int:
        """Return the one in whose part of [0, 1) ``u`` lies."""
        return min(self.lowest + int(u * (self.highest - self.lowest + 1)), self.highest)


@dataclass(frozen=True, slots=True)
class LogUniform:
    """A positive number whose logarithm is uniform."""

    lowest: float
    highest: float

    def number(self, u: float) -> float:
        """Return the number at the share ``u`` of the way, on a logarithmic scale."""
        first, last = math.log(self.lowest), math.log(self.highest)
        number = math.exp((1.0 - u) * first + u * last)
        return min(max(number, self.lowest), self.highest)


@dataclass(frozen=True, slots=True)
class Normal:
    """Normal, cut off below ``low`` and above ``high``; build it with `truncated`."""

    mean: float
    deviation: float
    low: float
    high: float
    first: float
    """Probabilities between which the standard normal number lies, of its mirror image where ..."""
    last: float
    is_mirrored: bool
    """... all of it lies above the mean: the lower tail has the digits that the upper one lacks."""

    @classmethod
    def truncated(
        cls, mean: float, deviation: float, low: float = -math.inf, high: float = math.inf
    ) -> Normal:
        """Return the law of a mean and a standard deviation, both before it is cut off."""
        ends = (low - mean) / deviation, (high - mean) / deviation
        is_mirrored = ends[0] > 0.0
        if is_mirrored:
            ends = -ends[1], -ends[0]
        first, last = (0.5 * math.erfc(-end / math.sqrt(2.0)) for end in ends)
        return cls(mean, deviation, low, high, first, last, is_mirrored)

    @property
    def is_empty(self) -> bool:
        """Whether there is no probability between the ends that double precision could tell."""
        return not self.last > self.first

    def number(self, u: float) -> float:
        """Return the number below which one lies with probability ``u``, between the ends."""
        share = min(max(1.0 - u if self.is_mirrored else u, _LEAST), _MOST)
        probability = min(self.first + share * (self.last - self.first), _MOST)
        standard = _STANDARD.inv_cdf(probability)
        number = self.mean + self.deviation * (-standard if self.is_mirrored else standard)
        return min(max(number, self.low), self.high)

    @property
    def lowest(self) -> float:
        """The end below, or what is left of the tail there."""
        return self.number(0.0)

    @property
    def highest(self) -> float:
        """The end above, likewise."""
        return self.number(1.0)
