"""Figures of a campaign for print."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.colors import LinearSegmentedColormap, LogNorm
from matplotlib.figure import Figure

from spacecraft_gnc.campaign import statistics as stats
from spacecraft_gnc.campaign.report.charts import FOR_DENSITY, FOR_RATES, ranked
from spacecraft_gnc.campaign.report.data import Column, Data
from spacecraft_gnc.campaign.statistics import Binning, Coded, Counts
from spacecraft_gnc.drawing import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from spacecraft_gnc.drawing.figures import Maker

MOST_PANELS: Final = 8
"""Diagrams of a figure."""
_WIDTH, _HEIGHT = 6.3, 2.4  # [inch] of a figure, and of a row of diagrams
_MAP: Final = (6.3, 4.6)
_LINE: Final = 30  # letters of a title
_DENSITY: Final = LinearSegmentedColormap.from_list("density", style.DENSITY_COLORS)
_RATES: Final = LinearSegmentedColormap.from_list("rates", style.RATE_COLORS)


def campaign_figures(data: Data) -> dict[str, Maker]:
    """Return what draws each figure of a campaign, by name.

    ``distributions``: the first metrics, those of the criterion foremost; ``success``: the success
    rate over the parameters on which it depends most; ``success_map``: over two of them;
    ``density``: runs by the first parameter and each metric. Left out is what has no content.
    """
    parameters = [column for column, _ in ranked(data)]
    metrics = data.metrics[:MOST_PANELS]
    made: dict[str, Maker] = {}
    if metrics:
        made["distributions"] = partial(
            _panels, [partial(_distribution, column=each, data=data) for each in metrics]
        )
    if parameters:
        some = parameters[:MOST_PANELS]
        made["success"] = partial(
            _panels, [partial(_success, column=each, data=data) for each in some]
        )
    if len(parameters) > 1:
        made["success_map"] = partial(_success_map, parameters[0], parameters[1], data)
    if parameters and metrics:
        draw = [partial(_density, x=parameters[0], y=each, data=data) for each in metrics]
        made["density"] = partial(_panels, draw)
    return made


def _panels(draw: Sequence[Callable[[Axes], None]]) -> Figure:
    """Return a figure with two diagrams in a row."""
    columns = min(2, len(draw))
    rows = math.ceil(len(draw) / columns)
    with style.applied():
        figure = Figure((_WIDTH, rows * _HEIGHT), layout="constrained")
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for panel, draw_panel in zip(panels, draw, strict=False):
            draw_panel(panel)
        for panel in panels[len(draw) :]:
            panel.remove()
        handles, labels = panels[0].get_legend_handles_labels()
        if handles:
            figure.legend(handles, labels, loc="outside lower center", ncols=2)
        return figure


def _distribution(axes: Axes, column: Column, data: Data) -> None:
    counts = stats.tally(column.coded, data.passed)
    binning = column.coded.binning
    for k, name, color in (
        (stats.PASSED, "passed", style.PASSED_COLOR),
        (stats.OTHERS, "not passed", style.FAILED_COLOR),
    ):
        if counts[:, k].any():
            axes.stairs(counts[:, k], binning.edges, fill=True, color=color, alpha=0.6, label=name)
    axes.set_yscale("log")
    axes.set(ylim=(0.5, None), ylabel="runs")
    _name(axes, column.name)
    _scale(axes, "x", binning)


def _success(axes: Axes, column: Column, data: Data) -> None:
    coded = column.coded.merged(FOR_RATES)
    counts = stats.tally(coded, data.passed)
    totals = counts.sum(axis=1)
    there = totals > 0
    rates = counts[there, stats.PASSED] / totals[there]
    low, high = stats.clopper_pearson_bounds(counts[there, stats.PASSED], totals[there])
    axes.errorbar(
        coded.binning.centers[there],
        100.0 * rates,
        yerr=100.0 * np.maximum([rates - low, high - rates], 0.0),
        color=style.PASSED_COLOR,
        fmt="o" if coded.binning.labels else "o-",
        markersize=3.5,
        capsize=2.0,
        elinewidth=0.9,
    )
    axes.set_ylabel("passed [%]")
    _name(axes, column.name)
    _scale(axes, "x", coded.binning)


def _success_map(x: Column, y: Column, data: Data) -> Figure:
    with style.applied():
        figure = Figure(_MAP, layout="constrained")
        axes = figure.subplots()
        coded, counts = _pair(x, y, data, FOR_RATES)
        totals = counts.sum(axis=2)
        rates = np.ma.masked_invalid(np.where(totals, 0.0, np.nan))
        rates += 100.0 * counts[:, :, stats.PASSED] / np.maximum(totals, 1)
        sure = rates[totals >= stats.ENOUGH]
        span = {"vmin": sure.min(), "vmax": sure.max()} if sure.size else {}
        mesh = _mesh(axes, coded, rates, cmap=_RATES, **span)
        figure.colorbar(mesh, ax=axes, label="passed [%]")
        axes.set(title="Success rate", xlabel=_plain(x.name), ylabel=_plain(y.name))
        return figure


def _density(axes: Axes, x: Column, y: Column, data: Data) -> None:
    coded, counts = _pair(x, y, data, FOR_DENSITY)
    runs = np.ma.masked_equal(counts.sum(axis=2), 0)
    mesh = _mesh(axes, coded, runs, cmap=_DENSITY, norm=LogNorm(1, max(2, int(runs.max()))))
    axes.figure.colorbar(mesh, ax=axes, label="runs")
    axes.set_xlabel(_plain(x.name))
    _name(axes, y.name)


def _pair(x: Column, y: Column, data: Data, factor: int) -> tuple[tuple[Coded, Coded], Counts]:
    coded = x.coded.merged(factor), y.coded.merged(factor)
    return coded, stats.tally_pair(*coded, data.passed)


def _mesh(axes: Axes, coded: tuple[Coded, Coded], values: Any, **look: Any) -> Any:
    x, y = (each.binning for each in coded)
    axes.grid(visible=False)
    mesh = axes.pcolormesh(x.edges, y.edges, values.T, rasterized=True, **look)
    _scale(axes, "x", x)
    _scale(axes, "y", y)
    return mesh


def _scale(axes: Axes, which: str, binning: Binning) -> None:
    """Make an axis that of a column's values."""
    axis = axes.xaxis if which == "x" else axes.yaxis
    if binning.labels:
        axis.set_ticks(range(binning.size), [_plain(text) for text in binning.labels])
    elif binning.is_log:
        axes.set(**{f"{which}scale": "log"})
    axes.set(**{f"{which}lim": binning.edges[[0, -1]]})


def _name(axes: Axes, name: str) -> None:
    axes.set_title("\n".join(textwrap.wrap(_plain(name), _LINE)), fontsize=9.0)


def _plain(text: str) -> str:
    """Return a text that matplotlib takes for no formula."""
    return text.replace("$", r"\$")
