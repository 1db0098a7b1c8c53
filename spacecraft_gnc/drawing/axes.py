"""Labels, scales and legends shared by the figures for print."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.ticker import FuncFormatter

from spacecraft_gnc.drawing import style
from spacecraft_gnc.types import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis

TIME_LABEL: Final = "time [s]"


def frame(axes: Axes, times: Array, title: str, ylabel: str) -> None:
    """Set title, labels and the range of time."""
    axes.set(title=title, xlabel=TIME_LABEL, ylabel=ylabel)
    axes.set_xlim(times[0], times[-1])


def component(index: int) -> dict[str, Any]:
    """Return the look of the line of a component x, y, z, w."""
    return {"color": style.COMPONENT_COLORS[index], "linestyle": style.COMPONENT_STYLES[index]}


def limit(axes: Axes, value: float, label: str | None = None, width: float = 1.1) -> None:
    """Draw the dashed line of a limit."""
    axes.axhline(value, label=label, color=style.LIMIT_COLOR, linewidth=width, linestyle="--")


def positive(values: Array) -> Array:
    """Return those of the (n,) values that a logarithmic scale can show."""
    return np.asarray(values[np.isfinite(values) & (values > 0.0)])


def plain_numbers(axis: Axis) -> None:
    """Write the ticks of a logarithmic scale as 0.1, 1, 10."""
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def logarithmic(axes: Axes, values: Array) -> None:
    """Make the scale logarithmic if any of the values can be shown there."""
    if positive(values).size:
        axes.set_yscale("log")


def legend(axes: Axes, columns: int, **options: Any) -> None:
    """Put the legend above the diagram, right of its title, where no data can lie."""
    axes.legend(
        loc="lower right",
        bbox_to_anchor=(1.0, 1.0),
        ncols=columns,
        borderaxespad=0.25,
        handlelength=2.2,
        columnspacing=1.2,
        **options,
    )


def legend_below(axes: Axes) -> None:
    """Put the legend below the figure: names of runs may be long."""
    axes.figure.legend(loc="outside lower center", ncols=3, handlelength=2.4)
