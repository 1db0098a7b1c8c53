"""Diagrams that show several flights in one, in the style of the figures of one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.lines import Line2D

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.axes import frame, plain_numbers
from spacecraft_gnc.types import Array

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

WIDE: Final[dict[str, Any]] = {"linewidth": 4.0, "alpha": 0.3, "solid_capstyle": "butt"}
"""What is compared with: a broad pale line, which a line that agrees with it runs along."""
THIN: Final[dict[str, Any]] = {"linewidth": 1.2}
LINES: Final[Sequence[dict[str, Any]]] = (
    {"color": style.INK, "linestyle": "-"},
    {"color": style.AXIS_COLORS[1], "linestyle": (0, (7, 2))},
    {"color": style.AXIS_COLORS[0], "linestyle": (0, (3, 1.2))},
    {"color": style.AXIS_COLORS[2], "linestyle": (0, (1.2, 1.0))},
    {"color": "#CC79A7", "linestyle": (0, (4, 1.2, 1, 1.2))},
)
"""Looks of lines that are told apart by their legend."""
_BELOW = 4.4  # [font size] from a diagram to its legend: tick labels and axis label lie between
_DECADE = 10.0  # spread of the times from which a linear scale hides the small ones


def components(
    axes: Axes,
    times: Array,
    flights: Mapping[str, tuple[Array, dict[str, Any]]],
    *,
    title: str,
    symbol: str,
    unit: str,
) -> None:
    """Draw the x, y and z of several flights: colors tell the axes, strokes the flights.

    Parameters
    ----------
    times
        (n,) [s].
    flights
        By name: (n, 3) values and the look of their lines.
    symbol, unit
        Of the quantity, such as ``u`` and ``N m``.
    """
    scaled = style.prefixed(unit, *(values for values, _ in flights.values()))
    for values, look in flights.values():
        for i, color in enumerate(style.AXIS_COLORS):
            axes.plot(times, scaled.factor * values[:, i], color=color, **look)
    handles = [Line2D([], [], color=color) for color in style.AXIS_COLORS]
    handles += [Line2D([], [], color=style.INK, **look) for _, look in flights.values()]
    labels = [f"${symbol}_{axis}$" for axis in "xyz"] + list(flights)
    frame(axes, times, title, f"{title.split(',', maxsplit=1)[0].lower()} [{scaled.label}]")
    key(axes, handles, labels)


def key(axes: Axes, handles: Sequence[Artist], labels: Sequence[str]) -> None:
    """Put a legend of given lines under a diagram, where no data can lie."""
    axes.legend(
        handles,
        labels,
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        ncols=len(labels),
        borderaxespad=_BELOW,
        handlelength=1.6,
        columnspacing=0.9,
        handletextpad=0.5,
    )


def lines(
    axes: Axes,
    times: Array,
    series: Mapping[str, Array],
    *,
    title: str,
    ylabel: str,
    floor: float | None = None,
    with_key: bool = True,
    looks: Sequence[dict[str, Any]] = LINES,
) -> None:
    """Draw several series over time.

    Parameters
    ----------
    series
        By name, (n,) each; may end early.
    floor
        Given: the scale is logarithmic, and ends there.
    with_key
        Whether to put the legend below.
    looks
        Of the lines, in turn.
    """
    for (name, values), look in zip(series.items(), looks, strict=False):
        shown = values if floor is None else np.maximum(values, floor)
        axes.plot(times[: len(shown)], shown, label=name, **THIN, **look)
    frame(axes, times, title, ylabel)
    if floor is not None:
        axes.set_yscale("log")
        axes.set_ylim(bottom=floor)
        plain_numbers(axes.yaxis)
    if with_key:
        key(axes, *axes.get_legend_handles_labels())


def step_times(axes: Axes, times: Array, series: Mapping[str, Array], *, title: str) -> None:
    """Draw the wall time [s] of every step, (n,) by name."""
    for (name, values), look in zip(series.items(), LINES, strict=False):
        axes.plot(
            times[: len(values)], 1e6 * values, ".", markersize=2.5, color=look["color"], label=name
        )
    frame(axes, times, title, "wall time [µs]")
    known = np.concatenate(list(series.values()))
    if known.max() > _DECADE * known.min():
        axes.set_yscale("log")
        plain_numbers(axes.yaxis)
    else:
        axes.set_ylim(bottom=0.0)
    handles = [
        Line2D([], [], marker="o", markersize=5, linestyle="none", color=look["color"])
        for look in LINES[: len(series)]
    ]
    key(axes, handles, list(series))
