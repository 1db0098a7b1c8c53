"""Data of a campaign's report: its table read column by column, and kept as codes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from spacecraft_gnc.campaign import statistics as stats
from spacecraft_gnc.campaign.columns import numbers
from spacecraft_gnc.campaign.flyer import FAILED, HEAD, PASSED
from spacecraft_gnc.campaign.report.failures import (
    Group,
    Worst,
    groups,
    without_numbers,
    word_counts,
    worst_runs,
)
from spacecraft_gnc.campaign.report.features import Feature, features
from spacecraft_gnc.campaign.statistics import Binning, Coded
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.types import Array

if TYPE_CHECKING:
    from spacecraft_gnc.campaign.results import Campaign


@dataclass(frozen=True, slots=True)
class Column:
    """A number of each run, or a word, that is not the same in all runs.

    Attributes
    ----------
    name
        What the page calls it.
    source
        Column of the table that it is from.
    coded
        Bin of each run.
    quantiles
        `statistics.LEVELS` of its numbers; None of words.
    missing
        Runs without a value.
    """

    name: str
    source: str
    coded: Coded
    quantiles: Array | None
    missing: int


@dataclass(frozen=True, slots=True)
class Data:
    """What the report of a campaign shows.

    Attributes
    ----------
    statuses
        Runs by status.
    passed
        (n,) whether each run passed.
    parameters, metrics
        Columns that vary.
    undrawn
        What is told of the columns that no diagram shows, by name: their one value, mostly.
    words
        Counts of the texts of each metric that has few different ones, # for numbers.
    groups, worst
        Runs that did not pass, by reason, and the worst ones of each metric of the criterion.
    """

    statuses: dict[str, int]
    passed: NDArray[np.bool_]
    parameters: tuple[Column, ...]
    metrics: tuple[Column, ...]
    undrawn: dict[str, str]
    words: dict[str, dict[str, int]]
    groups: tuple[Group, ...]
    worst: tuple[Worst, ...]

    @property
    def runs(self) -> int:
        """Runs in the table."""
        return len(self.passed)

    @property
    def successes(self) -> int:
        """Runs that passed."""
        return self.statuses.get(PASSED, 0)

    @property
    def flown(self) -> int:
        """Runs that were flown to their end."""
        return self.successes + self.statuses.get(FAILED, 0)


def read_data(campaign: Campaign, progress: Callable[[int, int], None] | None = None) -> Data:
    """Read the table of a campaign, column by column.

    Parameters
    ----------
    campaign
        With at least one row.
    progress
        Called with what is done and in all.

    Raises
    ------
    RecordingError
        If it holds no row.
    """
    if not campaign.done:
        raise RecordingError(
            f"{campaign.folder}: received a campaign without results; required at least one run "
            "that is done; let gnc campaign go on"
        )
    head = campaign.table(["status", "passed"])
    passed = np.asarray(head["passed"].to_numpy(), dtype=np.bool_)
    found = _Columns()
    varied = campaign.spec.variations.names
    names = [name for name in campaign.schema.names if name not in HEAD]
    for i, name in enumerate(names):
        if progress is not None:
            progress(i, len(names))
        found.add(name, campaign.table([name])[name], is_parameter=name in varied)
    criterion = campaign.spec.variations.criterion
    return Data(
        statuses=word_counts(head["status"]),
        passed=passed,
        parameters=tuple(found.parameters),
        metrics=tuple(sorted(found.metrics, key=lambda each: each.source not in criterion.names)),
        undrawn=found.undrawn,
        words=found.words,
        groups=tuple(groups(campaign)),
        worst=tuple(worst_runs(campaign)),
    )


class _Columns:
    """What the columns read so far came to."""

    def __init__(self) -> None:
        self.parameters: list[Column] = []
        self.metrics: list[Column] = []
        self.undrawn: dict[str, str] = {}
        self.words: dict[str, dict[str, int]] = {}

    def add(self, name: str, column: Any, *, is_parameter: bool) -> None:
        """Add a column of the table."""
        values = numbers(column)
        if values is not None:
            for feature in features(name, values):
                self._add_numbers(feature, name, is_parameter=is_parameter)
            return
        column = texts(column) if is_parameter else without_numbers(texts(column))
        counts = word_counts(column)
        missing = len(column) - sum(counts.values())
        if not counts:
            self.undrawn[name] = f"more than {stats.MOST_CATEGORIES} different texts"
        elif len(counts) == 1 and not missing:
            self.undrawn[name] = next(iter(counts))
        elif is_parameter:
            coded = _coded_words(column, sorted(counts))
            self.parameters.append(Column(name, name, coded, None, missing))
        else:
            self.words[name] = counts

    def _add_numbers(self, feature: Feature, source: str, *, is_parameter: bool) -> None:
        quantiles, binning = stats.quantiles(feature.values), stats.binning(feature.values)
        if quantiles is None:
            self.undrawn[feature.name] = "no value in any run"
        elif binning is None:
            self.undrawn[feature.name] = f"{quantiles[0]:.9g}"
        else:
            coded = Coded(binning.codes(feature.values), binning)
            missing = int(np.count_nonzero(coded.codes == stats.MISSING))
            column = Column(feature.name, source, coded, quantiles, missing)
            (self.parameters if is_parameter else self.metrics).append(column)


def _coded_words(column: Any, labels: list[str]) -> Coded:
    codes = np.full(len(column), stats.MISSING, dtype=np.uint8)
    for i, label in enumerate(labels):
        codes[np.asarray(pc.equal(column, label).fill_null(False))] = i
    return Coded(codes, Binning.of_categories(tuple(labels)))


def texts(column: Any) -> Any:
    """Return an Arrow column of any type as one of texts."""
    if pa.types.is_string(column.type) or pa.types.is_large_string(column.type):
        return column
    chunks = (chunk.to_pylist() for chunk in column.chunks)
    return pa.chunked_array(
        [[None if value is None else str(value) for value in chunk] for chunk in chunks],
        type=pa.string(),
    )
