"""Statistics of campaigns: success rates with their intervals, quantiles, histograms by bins."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.types import Array

CONFIDENCE: Final = 0.95
"""Of the intervals of a report."""
LEVELS: Final = (0.0, 0.05, 0.25, 0.5, 0.75, 0.95, 1.0)
"""Quantiles that a report tells of a column."""
MOST_BINS: Final = 60
"""A multiple of what bins are merged by, so that no merged one is smaller than the others."""
MOST_CATEGORIES: Final = 12
"""A column with no more different values, each of several runs, has one bin for each."""
ENOUGH: Final = 10
"""Runs of a cell whose success rate counts for the span of a map's colors."""
BELOW, ABOVE, MISSING = 253, 254, 255
"""Codes of a value outside the bins, and of none."""

_LARGEST: Final = 1e300  # the difference of two values is still a number
_LOG_FROM: Final = 300.0  # ratio of the quantiles 0.99 and 0.01; a uniform column reaches 99
_TAIL: Final = 0.005  # share of the values at each end that may lie far off
_STEP: Final = 6
Codes: TypeAlias = "NDArray[np.uint8]"
OTHERS, PASSED = 0, 1
"""Last index of the counts of `tally`: runs that did not pass, and those that did."""
Counts: TypeAlias = "NDArray[np.int64]"


class Interval(NamedTuple):
    """Bounds of a probability."""

    low: float
    high: float


def clopper_pearson(successes: int, trials: int, confidence: float = CONFIDENCE) -> Interval:
    """Return the exact confidence interval of a probability, from independent trials.

    Parameters
    ----------
    successes, trials
        Counts, 0 <= successes <= trials. Of no trial nothing is known: 0 to 1.
    confidence
        Probability, in (0, 1), that the interval covers at least.

    Raises
    ------
    ParameterError
        If a count or the confidence lies outside its range.

    Notes
    -----
    The lower bound p solves P(X >= successes) = (1 - confidence) / 2 for X binomial with
    ``trials`` and p, the upper one P(X <= successes) = (1 - confidence) / 2.

    **Source**: Clopper and Pearson (1934), "The use of confidence or fiducial limits illustrated
    in the case of the binomial", as quantiles of beta distributions.
    """
    low, high = clopper_pearson_bounds(successes, trials, confidence)
    return Interval(float(low), float(high))


def clopper_pearson_bounds(
    successes: ArrayLike, trials: ArrayLike, confidence: float = CONFIDENCE
) -> tuple[Array, Array]:
    """Return the bounds of `clopper_pearson` for arrays (...) of counts."""
    from scipy.stats import beta  # here: its import takes longer than a report of small campaigns

    k, n = np.broadcast_arrays(np.asarray(successes, float), np.asarray(trials, float))
    if not 0.0 < confidence < 1.0:
        raise ParameterError(
            f"confidence: received {confidence!r}; required a probability between 0 and 1; use 0.95"
        )
    if not np.all((k >= 0) & (k <= n)):
        raise ParameterError(
            f"successes: received {successes!r} of {trials!r}; required counts from 0 to the trials"
        )
    tail = 0.5 * (1.0 - confidence)
    with np.errstate(invalid="ignore"):  # a beta distribution has positive parameters
        low = np.where(k > 0, beta.ppf(tail, k, n - k + 1), 0.0)
        high = np.where(k < n, beta.isf(tail, k + 1, n - k), 1.0)
    return low, high


@dataclass(frozen=True, slots=True)
class Binning:
    """Division of the values of a column into bins.

    Attributes
    ----------
    edges
        (bins + 1,) in ascending order; of categories the numbers -0.5, 0.5, ...
    is_log
        Whether the bins are equally wide on a logarithmic scale.
    labels
        Of categories, one for each bin; empty where bins are intervals.
    categories
        (bins,) value of each numeric category, in ascending order.
    """

    edges: Array
    is_log: bool = False
    labels: tuple[str, ...] = ()
    categories: Array | None = None

    @classmethod
    def of_categories(cls, labels: tuple[str, ...], categories: Array | None = None) -> Binning:
        """Return the division into categories, one bin for each."""
        edges = np.linspace(-0.5, len(labels) - 0.5, len(labels) + 1)
        return cls(edges, labels=labels, categories=categories)

    @property
    def size(self) -> int:
        """Bins."""
        return len(self.edges) - 1

    @property
    def centers(self) -> Array:
        """(bins,) middles, geometric ones of a logarithmic division."""
        low, high = self.edges[:-1], self.edges[1:]
        return np.asarray(np.sqrt(low) * np.sqrt(high) if self.is_log else 0.5 * (low + high))

    def codes(self, values: Array) -> Codes:
        """Return the number of the bin of each of the (n,) values, or why it has none.

        An edge belongs to the bin above it, the last one to the last bin, as with numpy.histogram.
        """
        if self.categories is not None:
            index = np.searchsorted(self.categories, values)
        else:
            index = np.searchsorted(self.edges, values, side="right") - 1
            index[values == self.edges[-1]] = self.size - 1
        codes = np.where(index < 0, BELOW, np.minimum(index, ABOVE))
        codes[index >= self.size] = ABOVE
        codes[~_is_number(values)] = MISSING
        return codes.astype(np.uint8)


@dataclass(frozen=True, slots=True)
class Coded:
    """A column in one byte a run: the bin that its value lies in."""

    codes: Codes
    binning: Binning

    def merged(self, factor: int) -> Coded:
        """Return the column in bins ``factor`` times as wide; categories stay."""
        if self.binning.labels:
            return self
        binning = Binning(self.binning.edges[::factor], self.binning.is_log)
        merged = np.where(self.codes < self.binning.size, self.codes // factor, self.codes)
        return Coded(merged.astype(np.uint8), binning)

    def outside(self) -> int:
        """Return how many values lie outside the bins."""
        return int(np.count_nonzero((self.codes == BELOW) | (self.codes == ABOVE)))


def quantiles(values: Array) -> Array | None:
    """Return the quantiles `LEVELS` of the numbers among (n,) values; None: there is no number."""
    known = values[_is_number(values)]
    return np.quantile(known, LEVELS) if known.size else None


def binning(values: Array) -> Binning | None:
    """Return the division that shows how (n,) values are distributed; None: they are all the same.

    Few different values become categories. Else the bins are equally wide, on a logarithmic scale
    where the values are positive and spread over decades; at each end `_TAIL` of the values may
    lie outside them, where they would leave the rest in a few bins.
    """
    ordered = np.sort(values[_is_number(values)])
    if not ordered.size or ordered[0] == ordered[-1]:
        return None
    distinct = ordered[np.append(True, np.diff(ordered) != 0.0)]
    if len(distinct) <= MOST_CATEGORIES and 2 * len(distinct) <= len(ordered):
        labels = tuple(f"{value:.6g}" for value in distinct)
        return Binning.of_categories(labels, distinct)
    first, last = ordered[len(ordered) // 100], ordered[-1 - len(ordered) // 100]
    is_log = bool(first > 0.0 and last > _LOG_FROM * first)
    return _intervals(ordered[ordered > 0.0] if is_log else ordered, is_log)


def _intervals(ordered: Array, is_log: bool) -> Binning | None:
    scaled = np.log10(ordered) if is_log else ordered
    tail = int(_TAIL * len(scaled))
    first, last = scaled[tail], scaled[-1 - tail]
    low, high = scaled[0], scaled[-1]
    if last > first:
        low, high = max(low, 2.0 * first - last), min(high, 2.0 * last - first)
    edges = np.linspace(low, high, bins_for(len(scaled)) + 1)
    if is_log:
        edges = 10.0**edges
    if low == scaled[0]:
        edges[0] = ordered[0]  # exactly: a logarithm rounds
    if high == scaled[-1]:
        edges[-1] = ordered[-1]
    return Binning(edges, is_log) if np.all(np.diff(edges) > 0.0) else None


def bins_for(runs: int) -> int:
    """Return the bins of a histogram of so many values: twice their cube root (Rice's rule)."""
    wanted = round(2.0 * runs ** (1.0 / 3.0) / _STEP) * _STEP
    return int(min(max(wanted, 2 * _STEP), MOST_BINS))


def _is_number(values: Array) -> NDArray[np.bool_]:
    return np.abs(values) < _LARGEST


def tally(column: Coded, passed: NDArray[np.bool_]) -> Counts:
    """Return (bins, 2) counts of the runs that did not pass, and of those that did."""
    size = column.binning.size
    keys = 2 * np.minimum(column.codes, size).astype(np.int64) + passed
    return np.bincount(keys, minlength=2 * (size + 1)).reshape(-1, 2)[:size]


def tally_pair(x: Coded, y: Coded, passed: NDArray[np.bool_]) -> Counts:
    """Return (bins of x, bins of y, 2) counts of the runs that did not pass, and that did."""
    width, height = x.binning.size + 1, y.binning.size + 1  # the last one: in no bin
    keys = np.minimum(x.codes, width - 1).astype(np.int64)
    keys *= height
    keys += np.minimum(y.codes, height - 1)
    keys *= 2
    keys += passed
    counts = np.bincount(keys, minlength=2 * width * height)
    return counts.reshape(width, height, 2)[:-1, :-1]


def explained(counts: Counts) -> float:
    """Return the share of the variance of success that the bins of a column explain.

    Parameters
    ----------
    counts
        (bins, 2) as `tally` gives them.

    Returns
    -------
    float
        0: success does not depend on the column, or no more than chance has it; 1: it depends on
        nothing else. The adjusted correlation ratio (Kelley 1935, "epsilon squared").
    """
    totals = counts.sum(axis=1)
    runs, bins = int(totals.sum()), int(np.count_nonzero(totals))
    if runs <= bins:
        return 0.0
    share = counts[:, PASSED].sum() / runs
    total = runs * share * (1.0 - share)
    if total == 0.0:
        return 0.0
    rates = counts[:, PASSED] / np.maximum(totals, 1)
    within = float(np.sum(totals * rates * (1.0 - rates)))
    return max(0.0, float(1.0 - within * (runs - 1) / (total * (runs - bins))))
