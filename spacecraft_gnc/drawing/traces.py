"""Building blocks of the report's diagrams, in plotly.js form."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.envelope import thin
from spacecraft_gnc.types import Array

Trace = dict[str, Any]
DASHES: Final = ("solid", "dash", "dot", "dashdot")
_HEIGHT: Final = 320  # [px]
_TALL: Final = 740  # [px] two diagrams above each other with what is written about them
_LEGEND_LINE: Final = 19  # [px]
_LEGEND_ENTRIES: Final = 3  # that fit beside each other
_GAP: Final = 0.05  # between rows, share of the height


@dataclass(frozen=True, slots=True)
class Curve:
    """Values over time, with how to call and to draw them."""

    times: Array
    values: Array
    label: str
    line: Mapping[str, Any]
    row: int = 0
    options: Mapping[str, Any] = field(default_factory=dict)


def packed(values: Array) -> dict[str, str]:
    """Return an array as plotly.js reads it: base64 of little-endian doubles, bit for bit."""
    data = np.ascontiguousarray(values, dtype="<f8").tobytes()
    return {"dtype": "f8", "bdata": base64.b64encode(data).decode("ascii")}


def label(text: str) -> str:
    """Return a text that plotly.js shows as it is: its labels understand a little HTML.

    Not ``&quot;``, which it would show.
    """
    return html.escape(text, quote=False)


def component_line(index: int) -> dict[str, Any]:
    """Return the line of a component x, y, z, w."""
    return {"color": style.COMPONENT_COLORS[index % 4], "dash": DASHES[index % 4], "width": 1.7}


def run_line(index: int) -> dict[str, Any]:
    """Return the line of a run beside others."""
    count = len(style.RUN_COLORS)
    return {
        "color": style.RUN_COLORS[index % count],
        "dash": DASHES[(index + index // count) % len(DASHES)],
        "width": 1.7,
    }


def trace(curve: Curve, points: int) -> Trace:
    """Return the trace of a curve, thinned to ``points``."""
    drawn = thin(curve.times, curve.values, points)
    axis = "" if curve.row == 0 else str(curve.row + 1)
    return {
        "type": "scatter",
        "mode": "lines",
        "x": packed(drawn.times),
        "y": packed(drawn.values),
        "name": label(curve.label),
        "line": dict(curve.line),
        "yaxis": f"y{axis}",
        "hovertemplate": "%{y:.6g}",
        **curve.options,
    }


def limit(x: Sequence[float], y: Sequence[float], text: str) -> Trace:
    """Return the straight line of a limit through two points."""
    return {
        "type": "scatter",
        "mode": "lines",
        "x": [float(value) for value in x],
        "y": [float(value) for value in y],
        "name": label(text),
        "line": {"color": style.LIMIT_COLOR, "dash": "dash", "width": 1.3},
        "hoverinfo": "skip",
    }


def axis(title: str, **options: Any) -> dict[str, Any]:
    """Return an axis with the grid and the ticks of every diagram."""
    return {
        "title": {"text": title, "standoff": 8},
        "gridcolor": style.GRID_COLOR,
        "linecolor": style.MUTED,
        "zerolinecolor": style.GRID_COLOR,
        "ticks": "outside",
        "ticklen": 4,
        "tickcolor": style.MUTED,
        "automargin": True,
        "exponentformat": "power",
        **options,
    }


def figure(
    traces: Iterable[Trace], y: Sequence[Mapping[str, Any]], x: Mapping[str, Any]
) -> dict[str, Any]:
    """Return a figure with one diagram for each of ``y``, above each other over one axis ``x``."""
    rows = len(y)
    height = (1.0 - _GAP * (rows - 1)) / rows
    traces = list(traces)
    shown = sum(item.get("showlegend", True) for item in traces)
    legend = _LEGEND_LINE * max(0, shown - _LEGEND_ENTRIES)
    above = 30 if shown < 2 else 58 if shown <= _LEGEND_ENTRIES else 76  # [px] below the tools
    layout: dict[str, Any] = {
        "height": _HEIGHT + legend if rows == 1 else _TALL,
        "margin": {"l": 64, "r": 14, "t": above, "b": 46},
        "font": {"family": "system-ui, sans-serif", "size": 12, "color": style.INK},
        "paper_bgcolor": "#FFFFFF",
        "plot_bgcolor": "#FFFFFF",
        "hovermode": "x unified" if rows == 1 else "x",
        "legend": {"orientation": "h", "x": 0.0, "y": 1.01, "yanchor": "bottom"},
        "xaxis": {**x, "anchor": f"y{rows}" if rows > 1 else "y"},
    }
    for i, options in enumerate(y):
        top = 1.0 - i * (height + _GAP)
        name = "yaxis" if i == 0 else f"yaxis{i + 1}"
        layout[name] = {**options, "domain": [max(0.0, top - height), top]}
    return {"data": traces, "layout": layout}


def log_axis(title: str, **options: Any) -> dict[str, Any]:
    """Return a logarithmic axis."""
    return axis(title, type="log", tickformat="~g", **{"nticks": 4, **options})
