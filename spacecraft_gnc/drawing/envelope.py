"""Decimation of long series that keeps their extremes."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array

POINTS: Final = 3000
"""Points that all runs of a report may spend on one curve: keeps the file below 10 MB."""
FEWEST: Final = 200


class Thinned(NamedTuple):
    """Times and values of a curve as it is drawn."""

    times: Array
    values: Array


def budget(runs: int) -> int:
    """Return the points that each of ``runs`` may spend on one curve."""
    return max(FEWEST, POINTS // max(1, runs))


def per_interval(n: int, points: int) -> int:
    """Return how many samples one interval of the envelope holds; 1: every sample is drawn."""
    return 1 if n <= points else -(-n // (points // 2))


def thin(times: Array, values: Array, points: int) -> Thinned:
    """Return at most ``points`` samples: the least and the greatest value of each interval.

    Parameters
    ----------
    times, values
        (n,) samples. An interval without a number stays a gap.
    points
        If n is not greater, all samples are returned.
    """
    width = per_interval(len(times), points)
    if width == 1:
        return Thinned(times, values)
    rows = _in_rows(np.asarray(values, dtype=np.float64), width)
    known = np.isfinite(rows)
    low = np.argmin(np.where(known, rows, np.inf), axis=1)
    high = np.argmax(np.where(known, rows, -np.inf), axis=1)
    inside = np.sort(np.column_stack([low, high]), axis=1)
    chosen = (np.arange(len(rows))[:, None] * width + inside).ravel()
    chosen = np.minimum(chosen, len(times) - 1)
    return Thinned(times[chosen], np.asarray(values, dtype=np.float64)[chosen])


def strided(n: int, points: int) -> NDArray[np.int64]:
    """Return indices of at most ``points`` + 1 of ``n`` samples, the first and the last among them.

    For values with no order, such as attitudes.
    """
    stride = max(1, -(-n // points))
    return np.unique(np.append(np.arange(0, n, stride), n - 1))


def _in_rows(values: Array, width: int) -> Array:
    """Return values as (intervals, width), the last interval filled with NaN."""
    missing = -len(values) % width
    return np.append(values, np.full(missing, np.nan)).reshape(-1, width)
