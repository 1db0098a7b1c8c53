"""Events and stretches of time marked in diagrams, of a page and for print."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc.drawing import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LEVELS: Final = 4  # heights of the texts of a page: events may follow each other closely
_SHADE: Final = 0.13  # opacity of a stretch
_CLOSE: Final = 0.025  # of a diagram's width: texts nearer than this cover each other


class Mark(NamedTuple):
    """An event."""

    time: float
    """[s]"""
    text: str
    color: str
    before: bool = False
    """Whether its text stands before its line in print."""


class Span(NamedTuple):
    """A stretch of time."""

    begin: float
    """[s]"""
    end: float
    """[s]"""
    text: str
    color: str
    before: bool = False
    """Whether its text stands before its beginning in print."""


def shade(figure: dict[str, Any], spans: Sequence[Span]) -> None:
    """Shade stretches of time in a diagram of a page; their texts stand at its top."""
    layout = figure["layout"]
    for k, (begin, end, text, color, _) in enumerate(spans):
        layout.setdefault("shapes", []).append({
            "type": "rect", "xref": "x", "yref": "paper", "x0": begin, "x1": end, "y0": 0.0,
            "y1": 1.0, "fillcolor": color, "opacity": _SHADE, "line": {"width": 0},
            "layer": "below",
        })  # fmt: skip
        layout.setdefault("annotations", []).append({
            "xref": "x", "yref": "paper", "x": begin, "y": 0.99 - 0.08 * (k % _LEVELS),
            "text": text, "showarrow": False, "xanchor": "left", "xshift": 3, "yanchor": "top",
            "font": {"size": 11, "color": style.INK},
        })  # fmt: skip


def draw_spans(axes: Axes, spans: Sequence[Span]) -> None:
    """Shade stretches of time in a diagram for print; their texts stand at its top.

    A text that would cover the one before it is left out.
    """
    low, high = axes.get_xlim()
    written = -np.inf
    for begin, end, text, color, before in spans:
        axes.axvspan(begin, end, color=color, alpha=_SHADE, linewidth=0.0)
        axes.axvline(begin, color=color, linewidth=0.7, alpha=0.6)
        if not before and begin - written < _CLOSE * (high - low):
            continue
        written = written if before else begin
        axes.annotate(
            text, (begin, 1.0), xycoords=("data", "axes fraction"), rotation=90.0, color=style.INK,
            xytext=(-2 if before else 2, -3), textcoords="offset points", fontsize=7.0,
            ha="right" if before else "left", va="top",
        )  # fmt: skip


def mark(figure: dict[str, Any], marks: Sequence[Mark]) -> None:
    """Draw a dotted line and the text of each event into a diagram of a page."""
    layout = figure["layout"]
    for k, (time, text, color, _) in enumerate(marks):
        line: dict[str, Any] = {"color": color, "width": 1.2, "dash": "dot"}
        where = {"xref": "x", "yref": "paper", "x0": time, "x1": time}
        shape = {"type": "line", "y0": 0.0, "y1": 1.0, "line": line, **where}
        label = {
            "xref": "x", "yref": "paper", "x": time, "y": 0.01 + 0.08 * (k % _LEVELS),
            "text": text, "showarrow": False, "xanchor": "left", "xshift": 3,
            "yanchor": "bottom", "bgcolor": "rgba(255, 255, 255, 0.8)",
            "font": {"size": 11, "color": color},
        }  # fmt: skip
        layout.setdefault("shapes", []).append(shape)
        layout.setdefault("annotations", []).append(label)


def draw_marks(axes: Axes, marks: Sequence[Mark]) -> None:
    """Draw a dotted line and the text of each event into a diagram for print."""
    for time, text, color, before in marks:
        axes.axvline(time, color=color, linewidth=0.9, linestyle=":")
        axes.annotate(
            text, (time, 0.0), xycoords=("data", "axes fraction"), rotation=90.0,
            xytext=(-2 if before else 2, 4), textcoords="offset points", color=color,
            fontsize=7.0, ha="right" if before else "left", va="bottom",
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5},
        )  # fmt: skip
