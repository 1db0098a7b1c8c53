"""Ledger of an audit: each check with its largest deviation and the first step that differs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array

PASSED: Final = "pass"
FAILED: Final = "FAIL"
NOT_APPLICABLE: Final = "not applicable"
BITS: Final = "bit for bit"


class Difference(NamedTuple):
    """Where a recorded number is not what it should be."""

    step: int
    field: str
    """``topic.field[component]``."""


@dataclass(slots=True)
class Check:
    """One line of the table.

    Attributes
    ----------
    name
        What was compared.
    examined
        Steps examined, by field.
    worst
        Largest deviation, in the unit of the field.
    tolerance
        In words, with the unit.
    first
        The first step and field that differ; None where none does.
    note
        What a reader should know beside the verdict; where the check does not apply, why.
    """

    name: str
    tolerance: str
    examined: dict[str, int] = field(default_factory=dict)
    worst: float = 0.0
    first: Difference | None = None
    note: str = ""
    limit: float = 0.0
    """Largest tolerance, where there are several."""
    is_condition: bool = False
    """Whether it is kept or not, without a measure."""

    @property
    def steps(self) -> int:
        """Steps examined."""
        return max(self.examined.values(), default=0)

    def count(self, where: str, steps: int) -> None:
        """Take note that a field was examined at so many steps more."""
        self.examined[where] = self.examined.get(where, 0) + steps

    @property
    def verdict(self) -> str:
        """``pass``, ``FAIL`` or ``not applicable``: nothing examined never passes."""
        if self.first is not None:
            return FAILED
        return PASSED if self.steps else NOT_APPLICABLE

    @property
    def worst_text(self) -> str:
        """Largest deviation in two digits; ``-`` where nothing was measured."""
        return "-" if self.is_condition or not self.steps else f"{self.worst:.2g}"

    def as_dict(self) -> dict[str, Any]:
        """Return the line as a JSON-able mapping."""
        first = None if self.first is None else self.first._asdict()
        return {
            "check": self.name,
            "steps": self.steps,
            "worst": self.worst,
            "tolerance": self.tolerance,
            "verdict": self.verdict,
            "first": first,
            "note": self.note,
        }


@dataclass(slots=True)
class Ledger:
    """Checks in the order in which they were entered; blocks of steps add up in one line."""

    checks: dict[str, Check] = field(default_factory=dict)

    def check(self, name: str, tolerance: str, note: str = "") -> Check:
        """Return the line of that name, made where it is new."""
        found = self.checks.setdefault(name, Check(name, tolerance))
        found.tolerance = tolerance or found.tolerance
        found.note = note or found.note
        return found

    def _bounded(self, name: str, tolerance: Array | float, unit: str) -> Check:
        """Return the line of that name; it shows the largest of its tolerances."""
        line = self.check(name, "")
        line.limit = max(line.limit, float(np.max(tolerance)) if np.size(tolerance) else 0.0)
        line.tolerance = f"{line.limit:.2g} {unit}".rstrip()
        return line

    def skip(self, name: str, why: str) -> None:
        """Enter a check that does not apply, unless steps were examined under that name."""
        if name not in self.checks or not self.checks[name].steps:
            self.check(name, "", why)

    def fail(self, name: str, tolerance: str, step: int, where: str) -> None:
        """Enter a difference that is no number."""
        line = self.check(name, tolerance)
        line.count(where, 1)
        line.worst = math.inf
        _note_first(line, Difference(step, where))

    def compare(
        self,
        name: str,
        steps: NDArray[np.int64],
        recorded: Mapping[str, Array],
        expected: Mapping[str, Array],
        tolerance: Array | float | None = None,
        unit: str = "",
    ) -> None:
        """Compare fields (m, ...) of steps (m,): bit for bit, or to an absolute tolerance."""
        line = self.check(name, BITS) if tolerance is None else self._bounded(name, tolerance, unit)
        for where, values in recorded.items() if len(steps) else ():
            off, wrong = _deviation(values, expected[where], tolerance)
            self._enter(line, steps, where, off, wrong)

    def bound(
        self,
        name: str,
        steps: NDArray[np.int64],
        where: str,
        deviation: Array,
        tolerance: Array | float,
        unit: str = "",
    ) -> None:
        """Require deviations (m,) or (m, n) of steps (m,) to keep a bound; NaN keeps none.

        There may be one bound, one for each step, or one for each deviation.
        """
        line = self._bounded(name, tolerance, unit)
        if not len(steps):
            return
        off = np.abs(deviation).reshape(len(steps), -1)
        limits = np.asarray(tolerance)
        wrong = ~(off <= (limits if limits.ndim > 1 else limits.reshape(-1, 1)))
        self._enter(line, steps, where, off, wrong)

    def require(
        self, name: str, tolerance: str, steps: NDArray[np.int64], where: str,
        kept: NDArray[np.bool_],
    ) -> None:  # fmt: skip
        """Require a condition of steps (m,)."""
        line = self.check(name, tolerance)
        line.is_condition = True
        wrong = ~kept.reshape(-1, 1)
        self._enter(line, steps, where, wrong.astype(float), wrong)

    @property
    def first(self) -> tuple[Check, Difference] | None:
        """The earliest difference of all, of the check that comes first in the table."""
        failed = [(check, check.first) for check in self.checks.values() if check.first is not None]
        return min(failed, key=lambda item: item[1].step) if failed else None

    @staticmethod
    def _enter(
        line: Check, steps: NDArray[np.int64], where: str, off: Array, wrong: NDArray[np.bool_]
    ) -> None:
        line.count(where, len(steps))
        if off.size:
            largest = float(np.max(np.where(np.isnan(off), math.inf, off)))
            line.worst = max(line.worst, largest)
        rows = np.flatnonzero(wrong.any(axis=1))
        if rows.size:
            row = rows[np.argmin(steps[rows])]
            place = f"[{int(np.flatnonzero(wrong[row])[0])}]" if wrong.shape[1] > 1 else ""
            _note_first(line, Difference(int(steps[row]), f"{where}{place}"))


def as_absolute(tolerance: float | None, recorded: Array) -> float | None:
    """Return a stated tolerance in a field's unit: a share of its largest finite magnitude."""
    if tolerance is None:
        return None
    finite = np.abs(recorded[np.isfinite(recorded)])
    return tolerance * max(float(np.max(finite, initial=0.0)), 1e-300)


def _note_first(line: Check, found: Difference) -> None:
    if line.first is None or found.step < line.first.step:
        line.first = found


def _deviation(
    values: Array, expected: Array, tolerance: Array | float | None
) -> tuple[Array, NDArray[np.bool_]]:
    recorded = np.ascontiguousarray(values, dtype=np.float64).reshape(len(values), -1)
    wanted = np.ascontiguousarray(expected, dtype=np.float64).reshape(recorded.shape)
    with np.errstate(invalid="ignore", over="ignore"):
        off = np.where(recorded == wanted, 0.0, np.abs(recorded - wanted))  # inf - inf is no number
    if tolerance is None:
        return off, recorded.view(np.int64) != wanted.view(np.int64)
    return off, ~(off <= np.asarray(tolerance).reshape(-1, 1))
