"""Distributions over a list of values: constant and choice."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import yaml

from spacecraft_gnc.campaign.distributions.distribution import Target
from spacecraft_gnc.campaign.distributions.options import Options
from spacecraft_gnc.parameters.parameter import Kind, ParameterSpec, Value
from spacecraft_gnc.parameters.problems import shown
from spacecraft_gnc.parameters.values import Refusal, admissible
from spacecraft_gnc.types import Array

_MOST: Final = 1_000_000  # values of a linspace
_COUNT: Final = ParameterSpec(
    kind=Kind.INTEGER, default=0, description="", minimum=1, maximum=_MOST
)
_LINSPACE: Final = "[from, to, n], n values evenly spaced"
_WHOLE: Final = (Kind.INTEGER, Kind.INTEGER_ARRAY)


@dataclass(frozen=True, slots=True)
class Choice:
    """One of several values, all equally probable."""

    values: tuple[Value, ...]

    @property
    def dimensions(self) -> int:
        """One, or none where there is nothing to choose."""
        return 0 if len(self.values) == 1 else 1

    @property
    def size(self) -> int:
        """Number of values."""
        return len(self.values)

    def value(self, point: Array) -> Value:
        """Return the value in whose part of [0, 1) the point lies."""
        index = int(point[0] * len(self.values)) if self.dimensions else 0
        return self.values[min(index, len(self.values) - 1)]

    def extremes(self) -> Iterable[Value]:
        """Return nothing: each value was checked when it was read."""
        return ()


def read_constant(options: Options, target: Target) -> Choice:
    """Return a value that never changes."""
    node = options.node("value", target.spec.requirement)
    value = None if node is None else options.converted("value", node, target.spec)
    return Choice(() if value is None else (value,))


def read_choice(options: Options, target: Target) -> Choice:
    """Return a choice of ``values``, or of those of a ``linspace``."""
    if options.has("values") and options.has("linspace"):
        options.complain("linspace", "both", "either values or linspace", "remove one of the two")
        return Choice(())
    if options.has("linspace"):
        return Choice(tuple(_evenly_spaced(options, target)))
    nodes = options.sequence("values", f"a list, each {target.spec.requirement}")
    found = [options.converted("values", node, target.spec) for node in nodes]
    return Choice(tuple(value for value in found if value is not None))


def _evenly_spaced(options: Options, target: Target) -> list[Value]:
    nodes = options.sequence("linspace", _LINSPACE)
    if len(nodes) != 3:
        if nodes:
            options.complain("linspace", f"{len(nodes)} items", _LINSPACE, "write these three")
        return []
    ends = [_end(options, node) for node in nodes[:2]]
    count = options.converted("linspace", nodes[2], _COUNT)
    if count is None or any(end is None for end in ends):
        return []
    first, last = np.array(ends[0]), np.array(ends[1])
    if first.shape != last.shape:
        received = f"{shown(ends[0])} and {shown(ends[1])}"
        options.complain("linspace", received, "two ends of one length", "write as many numbers")
        return []
    spaced = np.linspace(first, last, int(count))  # type: ignore[arg-type]
    try:
        return [admissible(target.spec, _plain(target, row), coerce=True) for row in spaced]
    except Refusal as refusal:
        options.complain("linspace", refusal.received, refusal.requirement, refusal.remedy)
        return []


def _end(options: Options, node: yaml.Node) -> Value | None:
    is_list = isinstance(node, yaml.SequenceNode)
    kind = Kind.DOUBLE_ARRAY if is_list else Kind.DOUBLE
    shape = (-1,) if is_list else ()
    spec = ParameterSpec(kind=kind, default=0.0, description="", shape=shape)
    return options.converted("linspace", node, spec)


def _plain(target: Target, row: Any) -> Value:
    """Return the numbers of a row, whole ones as integers where the parameter takes only those."""
    if target.spec.kind in _WHOLE and (np.rint(row) == row).all():
        row = row.astype(np.int64)
    value: Value = row.tolist()
    return value
