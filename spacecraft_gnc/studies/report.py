"""Result of a reproduction: figures beside the paper's, checks with a verdict, pictures."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc.types import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

GAP: Final = "  "
NONE: Final = "-"


class Check(NamedTuple):
    """One figure that has to come out."""

    quantity: str
    expected: float
    ours: float
    tolerance: float
    """Largest difference that passes."""
    unit: str = ""

    @property
    def difference(self) -> float:
        """Ours less the expected one."""
        return self.ours - self.expected

    @property
    def ok(self) -> bool:
        """Whether the difference is within the tolerance; never where a number is NaN."""
        return abs(self.difference) <= self.tolerance

    def cells(self) -> list[str]:
        """Return the cells of its row in `CHECK_HEADER`."""
        return [
            f"{self.quantity} [{self.unit}]" if self.unit else self.quantity,
            f"{self.expected:.10g}",
            f"{self.ours:.10g}",
            f"{self.difference:.1e}" if self.difference else "0",
            f"{self.tolerance:.1g}",
            "ok" if self.ok else "NOT OK",
        ]


CHECK_HEADER: Final = ("", "expected", "ours", "difference", "tolerance", "verdict")


class Table(NamedTuple):
    """Texts in rows and columns, the paper's beside ours."""

    title: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    notes: Sequence[str] = ()
    """Lines below it: what was left out, failed or is not comparable."""


@dataclass(frozen=True, slots=True)
class Report:
    """The outcome of one paper's cases.

    Attributes
    ----------
    name, title : str
        Name for the command line; authors, year and subject.
    tables : sequence of Table
    checks : sequence of Check
    values : dict
        The numbers behind the tables, for JSON.
    flown : tuple
        What the pictures are drawn from: the arguments of ``figures`` in the module NAME_figures.
    """

    name: str
    title: str
    tables: Sequence[Table]
    checks: Sequence[Check]
    values: dict[str, Any]
    flown: tuple[Any, ...] = field(repr=False)

    def draw(self) -> Iterator[tuple[str, Figure]]:
        """Return the names and figures, drawn when they are asked for."""
        drawing = importlib.import_module(f"{__package__}.{self.name}_figures")
        drawn: Iterator[tuple[str, Figure]] = drawing.figures(*self.flown)
        return drawn

    @property
    def failed(self) -> list[Check]:
        """Checks that did not come out."""
        return [check for check in self.checks if not check.ok]

    def to_dict(self) -> dict[str, Any]:
        """Return everything but the pictures, ready for JSON."""
        checks = [
            {**check._asdict(), "difference": check.difference, "ok": check.ok}
            for check in self.checks
        ]
        tables = [table._asdict() for table in self.tables]
        return {
            "title": self.title,
            "ok": not self.failed,
            "checks": checks,
            "tables": tables,
            "values": self.values,
        }

    def lines(self) -> Iterator[str]:
        """Yield the lines of the report as text."""
        yield self.title
        for table in self.tables:
            yield from ("", *table_lines(table))
        rows = [check.cells() for check in self.checks]
        yield from ("", *table_lines(Table("Checks", CHECK_HEADER, rows)))
        passed = len(self.checks) - len(self.failed)
        yield from ("", f"{passed} of {len(self.checks)} checks passed")


def table_lines(table: Table) -> Iterator[str]:
    """Yield title, header, rows and notes in aligned columns: the first to the left."""
    grid = [list(table.header), *map(list, table.rows)]
    widths = [max(len(row[i]) for row in grid) for i in range(len(grid[0]))]
    yield table.title
    for row in grid:
        first, *rest = (f"{cell:>{width}}" for cell, width in zip(row, widths, strict=True))
        yield (GAP + GAP.join([first.strip().ljust(widths[0]), *rest])).rstrip()
    for note in table.notes:
        yield f"{GAP}{note}"


def seconds(value: float) -> str:
    """Return a time [s] as text, in the unit that suits it."""
    if not np.isfinite(value):
        return NONE
    for unit, scale in (("s", 1.0), ("ms", 1e-3)):
        if value >= scale:
            return f"{value / scale:.4g} {unit}"
    return f"{value * 1e6:.3g} us"


def times(row: Array) -> dict[str, float]:
    """Return total, longest, shortest, mean and median of the (n,) step times [s]."""
    return {
        "total": float(row.sum()),
        "max": float(row.max()),
        "min": float(row.min()),
        "mean": float(row.mean()),
        "median": float(np.median(row)),
    }
