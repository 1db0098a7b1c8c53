"""Diagrams of a campaign: distributions, success rates, densities of pairs."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Any, Final

import numpy as np

from spacecraft_gnc.campaign import statistics as stats
from spacecraft_gnc.campaign.report.data import Column, Data
from spacecraft_gnc.campaign.statistics import Binning, Coded, Counts
from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.chart import Chart
from spacecraft_gnc.drawing.traces import Trace, axis, figure, label, log_axis, packed

MOST_CHARTS: Final = 48
"""Metrics whose distributions are drawn."""
MOST_PARAMETERS: Final = 30
"""Parameters, or components of them, that are drawn."""
MOST_PAIRS: Final = 300
"""Pairs of a parameter and a metric, and of two parameters: keeps the page below 10 MB."""
FOR_RATES: Final = 3
"""Bins of a histogram that a success rate is of, and of a map of success rates."""
FOR_DENSITY: Final = 2
_NARROW: Final = 1e-3
_LINE: Final = 40  # letters of a line of an axis title


def ranked(data: Data) -> list[tuple[Column, float]]:
    """Return the parameters and what share of success each explains, most first."""
    shares = [
        stats.explained(stats.tally(each.coded.merged(FOR_RATES), data.passed))
        for each in data.parameters
    ]
    pairs = zip(data.parameters, shares, strict=True)
    return sorted(pairs, key=lambda each: -each[1])[:MOST_PARAMETERS]


def distribution_charts(data: Data) -> Iterator[Chart]:
    """Yield the histogram of each metric, of passed and of other runs."""
    for i, metric in enumerate(data.metrics[:MOST_CHARTS]):
        counts = stats.tally(metric.coded, data.passed)
        binning = metric.coded.binning
        bars = [_bars(binning, counts[:, stats.PASSED], "passed", style.PASSED_COLOR)]
        if data.successes < data.runs:
            bars.append(_bars(binning, counts[:, stats.OTHERS], "not passed", style.FAILED_COLOR))
        top = float(np.log10(max(counts.max(), 1)))
        runs = log_axis("runs", range=[-0.3, 1.06 * top + 0.1])
        drawn = figure(bars, [runs], value_axis(metric.name, binning))
        drawn["layout"] |= {"barmode": "overlay", "bargap": 0.0, "showlegend": True}
        yield Chart(f"metric-{i}", metric.name, distribution_note(metric), drawn, scale="yaxis")


def distribution_note(metric: Column) -> str:
    """Return quantiles of a metric, and what its histogram leaves out."""
    q = metric.quantiles
    parts = []
    if q is not None:
        parts.append(f"median {q[3]:.4g}, 5 % to 95 %: {q[1]:.4g} to {q[5]:.4g}")
        outside = metric.coded.outside()
        if outside:
            parts.append(
                f"{outside:,} outside the drawn range, of {q[0]:.4g} to {q[-1]:.4g} in all"
            )
    if metric.missing:
        parts.append(f"no value in {metric.missing:,}")
    return "; ".join(parts)


def _bars(binning: Binning, counts: Any, name: str, color: str) -> Trace:
    low, high = binning.edges[:-1], binning.edges[1:]
    return {
        "type": "bar",
        "name": name,
        "x": packed(0.5 * (low + high)),  # on a logarithmic axis, too, bars end at x +- width / 2
        "y": counts.tolist(),
        "width": packed((high - low) * (0.8 if binning.labels else 1.0)),
        "marker": {"color": color, "opacity": 0.62, "line": {"width": 0}},
        "hovertemplate": "%{y}",
    }


def value_axis(name: str, binning: Binning) -> dict[str, Any]:
    """Return the axis of a column's values."""
    title = "<br>".join(label(line) for line in textwrap.wrap(name, _LINE))
    if binning.labels:
        ticks = [label(text) for text in binning.labels]
        span = [-0.5, binning.size - 0.5]
        return axis(title, tickvals=list(range(binning.size)), ticktext=ticks, range=span)
    ends = binning.edges[[0, -1]]
    if binning.is_log:
        return log_axis(title, range=np.log10(ends).tolist(), hoverformat=".4g", nticks=6)
    options: dict[str, Any] = {"range": ends.tolist(), "hoverformat": ".4g", "nticks": 5}
    if np.ptp(ends) < _NARROW * np.abs(ends).max():  # numbers of many digits: no room for more
        ticks = (ends[0] + np.ptp(ends) * np.array([0.2, 0.8])).tolist()
        told = [f"{tick:.10g}" for tick in ticks]
        options |= {"tickvals": ticks, "ticktext": told, "hoverformat": ".10g"}
    return axis(title, tickangle=0, **options)


def rate_charts(parameters: Sequence[tuple[Column, float]], data: Data) -> Iterator[Chart]:
    """Yield the success rate over each parameter, with its intervals."""
    for i, (parameter, share) in enumerate(parameters):
        coded = parameter.coded.merged(FOR_RATES)
        drawn = _rates(parameter.name, coded, stats.tally(coded, data.passed))
        told = "less than 0.01 %" if share < 1e-4 else f"{100.0 * share:.3g} %"
        note = f"explains {told} of the variance of success"
        yield Chart(f"rate-{i}", parameter.name, note, drawn)


def _rates(name: str, coded: Coded, counts: Counts) -> dict[str, Any]:
    totals = counts.sum(axis=1)
    there = totals > 0
    successes, totals = counts[there, stats.PASSED], totals[there]
    rates = successes / totals
    low, high = stats.clopper_pearson_bounds(successes, totals)
    points = {
        "type": "scatter",
        "mode": "markers" if coded.binning.labels else "lines+markers",
        "x": packed(coded.binning.centers[there]),
        "y": packed(100.0 * rates),
        "error_y": {
            "array": packed(100.0 * (high - rates)),
            "arrayminus": packed(100.0 * (rates - low)),
            "thickness": 1.2,
            "width": 3,
        },
        "customdata": np.column_stack([successes, totals]).tolist(),
        "hovertemplate": "%{y:.4g} %, %{customdata[0]} of %{customdata[1]}<extra></extra>",
        "line": {"color": style.PASSED_COLOR, "width": 1.4},
        "marker": {"size": 6},
    }
    span = _span_of_rates(100.0 * float(low.min()), 100.0 * float(high.max()))
    y = axis("runs that passed [%]", range=span)
    return figure([points], [y], value_axis(name, coded.binning))


def _span_of_rates(low: float, high: float) -> list[float]:
    """Return the range of an axis of success rates [%], with a margin that stays near 0 to 100."""
    margin = 0.05 * (high - low) + 1e-9
    return [max(low - margin, -2.0), min(high + margin, 102.0)]


def density_pairs(parameters: Sequence[tuple[Column, float]], data: Data) -> dict[str, Any]:
    """Return the runs by each parameter and each metric, as the script of the page draws them."""
    xs = [each for each, _ in parameters]
    ys = list(data.metrics[: max(1, MOST_PAIRS // max(1, len(xs)))])
    x_coded, y_coded = ([each.coded.merged(FOR_DENSITY) for each in some] for some in (xs, ys))
    cells = {
        f"{i},{j}": _cells(stats.tally_pair(x, y, data.passed))
        for i, x in enumerate(x_coded)
        for j, y in enumerate(y_coded)
    }
    return {
        "name": "density",
        "x": _columns(xs, x_coded),
        "y": _columns(ys, y_coded),
        "cells": cells,
        "colors": scale(style.DENSITY_COLORS),
        "layout": _pair_layout(),
    }


def rate_pairs(parameters: Sequence[tuple[Column, float]], data: Data) -> dict[str, Any]:
    """Return the runs by each two parameters, likewise."""
    xs = [each for each, _ in parameters]
    while len(xs) * (len(xs) - 1) > 2 * MOST_PAIRS:
        xs.pop()
    coded = [each.coded.merged(FOR_RATES) for each in xs]
    cells = {
        f"{i},{j}": _cells(stats.tally_pair(coded[i], coded[j], data.passed))
        for i, j in combinations(range(len(xs)), 2)
    }
    columns = _columns(xs, coded)
    return {
        "name": "rates",
        "x": columns,
        "y": columns,
        "cells": cells,
        "enough": stats.ENOUGH,
        "colors": scale(style.RATE_COLORS),
        "layout": _pair_layout(),
    }


def _cells(counts: Counts) -> list[list[int]]:
    """Return the counts of the other and of the passed runs, each row by row: y, then x."""
    return [counts[:, :, k].T.ravel().tolist() for k in (stats.OTHERS, stats.PASSED)]


def _columns(columns: Sequence[Column], coded: Sequence[Coded]) -> list[dict[str, Any]]:
    return [
        {
            "label": column.name,
            "axis": value_axis(column.name, each.binning),
            "edges": each.binning.edges.tolist(),
        }
        for column, each in zip(columns, coded, strict=True)
    ]


def _pair_layout() -> dict[str, Any]:
    """Return the layout of a map, without the axes."""
    layout = figure([], [{}], {})["layout"]
    own = {"height": 460, "hovermode": "closest", "margin": {"l": 70, "r": 10, "t": 34, "b": 60}}
    return {**layout, **own}


def scale(colors: Sequence[str]) -> list[tuple[float, str]]:
    """Return a color scale as plotly.js takes it."""
    return [(i / (len(colors) - 1), color) for i, color in enumerate(colors)]
