"""Distributions of numbers: uniform, normal, log_uniform, each component by itself."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

from spacecraft_gnc.campaign.distributions.distribution import Target
from spacecraft_gnc.campaign.distributions.laws import Law, LogUniform, Normal, Uniform, Whole
from spacecraft_gnc.campaign.distributions.options import Options
from spacecraft_gnc.parameters.parameter import Kind, MatrixRule, Value
from spacecraft_gnc.types import Array

_LISTS: Final = (Kind.DOUBLE_ARRAY, Kind.INTEGER_ARRAY)
_WHOLE: Final = (Kind.INTEGER, Kind.INTEGER_ARRAY)
_NUMBERS: Final = (Kind.DOUBLE, Kind.INTEGER, Kind.DYNAMIC, *_LISTS)
_OPTIONS: Final = ("from", "to", "mean", "std")


@dataclass(frozen=True, slots=True)
class Components:
    """Independent numbers, one for a scalar parameter."""

    laws: tuple[Law, ...]
    is_list: bool

    @property
    def dimensions(self) -> int:
        """One for each number that varies."""
        return sum(_varies(law) for law in self.laws)

    @property
    def size(self) -> None:
        """A continuum: integers do not fill a grid unless a choice lists them."""
        return None

    def value(self, point: Array) -> Value:
        """Return the numbers at a point."""
        rest = iter(point.tolist())
        numbers = [law.number(next(rest) if _varies(law) else 0.0) for law in self.laws]
        return numbers if self.is_list else numbers[0]

    def extremes(self) -> Iterable[Value]:
        """Return the corners at which all numbers are smallest, and largest."""
        for corner in (
            [law.lowest for law in self.laws],
            [law.highest for law in self.laws],
        ):
            yield corner if self.is_list else corner[0]


def _varies(law: Law) -> bool:
    return law.lowest < law.highest


def read_uniform(options: Options, target: Target) -> Components:
    """Return numbers uniform ``from`` ... ``to``; whole ones for a parameter of integers."""
    count = _count(options, target)
    low, high = options.numbers("from", count), options.numbers("to", count)
    if target.spec.kind in _WHOLE:
        return _components(options, target, _whole_numbers(options, low, high))
    _check_order(options, low, high)
    return _components(options, target, list(map(Uniform, low, high)))


def read_log_uniform(options: Options, target: Target) -> Components:
    """Return positive numbers whose logarithms are uniform ``from`` ... ``to``."""
    _check_real(options, target)
    count = _count(options, target)
    low, high = options.numbers("from", count), options.numbers("to", count)
    _check_positive(options, "from", low, "choose uniform, or raise it")
    _check_order(options, low, high)
    return _components(options, target, list(map(LogUniform, low, high)))


def read_normal(options: Options, target: Target) -> Components:
    """Return normal numbers of ``mean`` and ``std``, cut off at ``from`` and ``to`` if given."""
    _check_real(options, target)
    count = _count(options, target)
    mean, deviation = options.numbers("mean", count), options.numbers("std", count)
    low = options.numbers("from", count, -math.inf)
    high = options.numbers("to", count, math.inf)
    _check_positive(options, "std", deviation, "choose constant, or raise it")
    _check_order(options, low, high)
    if not options.is_valid:
        return Components((), is_list=False)
    laws = list(map(Normal.truncated, mean, deviation, low, high))
    if any(law.is_empty for law in laws):
        end = "from" if options.has("from") else "to"
        need = "ends with some probability between them, within 37 std of the mean"
        options.complain(end, options.shown(end), need, "move the ends, or choose uniform")
    return _components(options, target, laws)


def _components(options: Options, target: Target, laws: Sequence[Law]) -> Components:
    is_list = target.spec.kind in _LISTS
    return Components(tuple(laws) if options.is_valid else (), is_list)


def _count(options: Options, target: Target) -> int | None:
    """Return how many numbers a list of the parameter has, None for a scalar; report a misfit."""
    spec = target.spec
    is_list = spec.kind in _LISTS
    if spec.kind not in _NUMBERS or (is_list and spec.matrix is not MatrixRule.NONE):
        what = f"numbers for {target.name}"
        remedy = "choose inertia, or choice" if spec.matrix is MatrixRule.INERTIA else "use choice"
        options.complain("distribution", what, f"a distribution of {spec.requirement}", remedy)
    if not is_list:
        return None
    known = len(target.nominal) if isinstance(target.nominal, list) else 0
    count = spec.length if spec.length > 0 else options.length(_OPTIONS) or known
    if not count:
        need = f"a list for {target.name}, which has no value in the scenario"
        remedy = "write a number for each component"
        options.complain("distribution", "one number for all components", need, remedy)
    return count


def _check_real(options: Options, target: Target) -> None:
    if target.spec.kind in _WHOLE:
        need = f"a distribution of {target.spec.requirement}"
        options.complain("distribution", "real numbers", need, "choose uniform, or choice")


def _whole_numbers(options: Options, low: list[float], high: list[float]) -> list[Law]:
    for name, ends in (("from", low), ("to", high)):
        if any(math.isfinite(end) and not end.is_integer() for end in ends):
            options.complain(name, options.shown(name), "integers", "round it")
    _check_order(options, low, high)
    if not options.is_valid:
        return []
    return [Whole(int(a), int(b)) for a, b in zip(low, high, strict=True)]


def _check_order(options: Options, low: list[float], high: list[float]) -> None:
    if any(a > b for a, b in zip(low, high, strict=True)):
        need = f"at least from ({options.shown('from')})"
        options.complain("to", options.shown("to"), need, "exchange the two")
    elif low == high:
        options.complain("to", options.shown("to"), "more than from", "choose constant")


def _check_positive(options: Options, name: str, numbers: list[float], remedy: str) -> None:
    if any(number <= 0.0 for number in numbers):
        options.complain(name, options.shown(name), "> 0", remedy)
