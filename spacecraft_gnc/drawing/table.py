"""Rows of a table that compares runs, and the format of their numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final, NamedTuple

NOTHING: Final = "-"
"""It does not apply."""
_EXPONENT_FROM: Final = 1e12
_LARGEST_SHARE: Final = 2.0  # of the first run: what is farther off is told as a factor
_LEAST_FACTOR: Final = 0.01  # likewise


class Row(NamedTuple):
    """A metric: how to call it, its unit, and what it means where there is none."""

    label: str
    key: str = ""
    """Of the metric."""
    unit: str = ""
    digits: int = 5
    factor: float = 1.0
    absent: Callable[[Any], str] = lambda _: NOTHING
    """Of a run without the metric: what stands there."""
    text: Callable[[Any], str] | None = None
    """Of a run: what stands there, in place of a metric; with a key, `NOTHING` hides the row."""

    def is_shown(self, runs: Sequence[Any]) -> bool:
        """Tell whether any of the runs has something to say."""
        is_always = self.text is not None and not self.key
        return is_always or any(self.value(run) != NOTHING for run in runs)

    def value(self, run: Any) -> str:
        """Return what stands there for a run."""
        if self.text is not None:
            return self.text(run)
        value = run.metrics[self.key]
        return self.absent(run) if value is None else rounded(self.factor * value, self.digits)

    def difference(self, run: Any, first: Any) -> str:
        """Return the difference to the first run, and its share or factor where that says more."""
        if self.text is not None:
            return ""
        value, base = run.metrics[self.key], first.metrics[self.key]
        return "" if value is None or base is None else difference(value, base, self.factor)


def rounded(value: float, digits: int, sign: str = "") -> str:
    """Return a number with so many digits, and every one before the point: counts are exact."""
    if 10.0**digits - 0.5 <= abs(value) < _EXPONENT_FROM:
        return f"{value:{sign}.0f}"
    return f"{value:{sign}.{digits}g}"


def difference(value: float, first: float, factor: float = 1.0) -> str:
    """Return the difference to a first value, with its share or factor where that says more."""
    if value == first:
        return "same"
    text = rounded(factor * (value - first), 3, "+")
    if first:
        share, times = (value - first) / abs(first), value / first
        if times > 0.0 and not _LEAST_FACTOR <= times <= 1.0 + _LARGEST_SHARE:
            text += f", {rounded(times, 3)} times"
        elif abs(share) <= _LARGEST_SHARE:
            text += f", {rounded(100.0 * share, 3, '+')} %"
    return text
