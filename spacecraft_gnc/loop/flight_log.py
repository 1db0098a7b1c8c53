"""The arrays of a flight, filled step by step."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from operator import attrgetter
from typing import Any, Generic, NamedTuple, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.loop.flight import Column, End, Flight, Moment, Step

_Kind = TypeVar("_Kind", bound=Flight)


class FlightLog(Generic[_Kind]):
    """Preallocated arrays of a flight of ``n`` control steps of ``period`` [s].

    Attributes
    ----------
    add : callable (k, step)
        Store control step k, before the plant makes it.
    add_outcome : callable (k, plant)
        Store what the plant tells of control step k, which it has made.
    """

    def __init__(self, kind: type[_Kind], n: int, period: float) -> None:
        self._kind, self._period = kind, period
        self._plan = _plan_of(cast("Any", kind))  # mypy takes no class of a dataclass as hashable
        self._time = np.asarray(period * np.arange(n), dtype=np.float64)
        self._rows = {name: _Rows(each, n) for name, each in self._plan.rows}
        targets = {name: rows.target for name, rows in self._rows.items()}
        self.add: Callable[[int, Step], None] = self._plan.of_start(targets)
        self.add_outcome: Callable[[int, Any], None] = self._plan.of_outcome(targets)

    def hold(self, first: int, step: Step, plant: Any, varying: Mapping[str, NDArray[Any]]) -> None:
        """Store control steps from ``first`` on that were flown at once.

        Parameters
        ----------
        first
            Number of the first.
        step, plant
            As for `add` and `add_outcome`: what holds for all of them.
        varying
            Columns of which each step has its own value, by name; a row for each step.
        """
        steps = slice(first, first + len(next(iter(varying.values()))))
        self._plan.of_start(self._rows)(steps, step)
        self._plan.of_outcome(self._rows)(steps, plant)
        for name, values in varying.items():
            self._rows[name][steps] = values

    def finish(self, end: End) -> _Kind:
        """Close the record with what is known at the end of the last step."""
        rows = {name: rows.array for name, rows in self._rows.items()}
        finals = {name: _value(each, end) for name, each in self._plan.finals}
        return self._kind(period=self._period, time=self._time, **rows, **finals)


def _value(column: Column, end: End) -> Any:
    read = column.read
    return attrgetter(read)(end) if isinstance(read, str) else read(end)


_Named = list[tuple[str, Column]]


class _Plan(NamedTuple):
    """How flights of one class are logged."""

    rows: _Named
    finals: _Named
    of_start: Callable[[dict[str, Any]], Any]
    of_outcome: Callable[[dict[str, Any]], Any]


@cache
def _plan_of(kind: type[Flight]) -> _Plan:
    of: dict[Moment, _Named] = {moment: [] for moment in Moment}
    for name, each in kind.columns():
        of[each.moment].append((name, each))
    start, outcome = of[Moment.START], of[Moment.OUTCOME]
    return _Plan(start + outcome, of[Moment.END], _writer_maker(start), _writer_maker(outcome))


def _writer_maker(chosen: _Named) -> Callable[[dict[str, Any]], Any]:
    """Return what makes, of the rows by name, the function that stores columns of one moment.

    It is compiled from source, one statement for each column, like the methods of a dataclass: a
    loop over the columns takes longer than the plant's step.
    """
    owners = dict.fromkeys(column.of for _, column in chosen)
    given: dict[str, Any] = {f"of_{i}": of for i, of in enumerate(owners) if of is not None}
    lines = [f"{name}_rows = targets[{name!r}]" for name, _ in chosen]
    lines.append("def write(k, step):")
    for i, of in enumerate(owners):
        lines.append(f"  source = {'step' if of is None else f'of_{i}(step)'}")
        lines.append("  if source is not None:")
        for name, column in chosen:
            if column.of is of:
                lines.append(f"    value = {_expression(name, column, given)}")
                lines.append(f"    if value is not None: {name}_rows[k] = value")
    body = "\n".join(f"  {line}" for line in [*lines, "  return", "return write"])
    exec(f"def make(targets):\n{body}", given)  # noqa: S102 - of the names of attributes alone
    return given["make"]  # type: ignore[no-any-return]


def _expression(name: str, column: Column, given: dict[str, Any]) -> str:
    if isinstance(column.read, str):
        if not all(map(str.isidentifier, column.read.split("."))):
            raise ParameterError(
                f"column {name}: received {column.read!r}; required a dotted attribute such as "
                "'state.attitude'; give a function for anything else"
            )
        return f"source.{column.read}"
    given[f"read_{name}"] = column.read
    return f"read_{name}(source)"


class _Rows:
    """Array of one column; one of a length that is not known yet is made by the first value."""

    def __init__(self, column: Column, n: int) -> None:
        self._column, self._n = column, n
        self._is_open = -1 in column.shape
        self.array = self._made(tuple(max(size, 0) for size in column.shape))

    @property
    def target(self) -> Any:
        """What takes the value of step k at index k."""
        if self._is_open:
            return self
        # A number goes into a memoryview in half the time.
        is_number = self.array.ndim == 1 and self.array.dtype == np.float64
        return memoryview(self.array.data) if is_number else self.array

    def __setitem__(self, k: int | slice, value: Any) -> None:
        if self._is_open:
            self.array, self._is_open = self._made(np.shape(value)), False
        self.array[k] = value

    def _made(self, shape: tuple[int, ...]) -> NDArray[Any]:
        array: NDArray[Any] = np.empty((self._n, *shape), self._column.type)
        array.fill(self._column.missing)
        return array
