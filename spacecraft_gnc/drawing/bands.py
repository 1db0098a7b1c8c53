"""Bands of a page that show in which of several states each run was, over time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final, TypeVar

from spacecraft_gnc.drawing.chart import Drawn, over_time
from spacecraft_gnc.drawing.sources import Stretch
from spacecraft_gnc.drawing.traces import axis, label

R = TypeVar("R", bound=Drawn)
_HEIGHT: Final = 34  # [px] of a row


def band(
    runs: Sequence[R],
    stretches_of: Callable[[R], Sequence[Stretch]],
    name_of: Callable[[int], str],
    color_of: Callable[[int], str],
) -> dict[str, Any]:
    """Return the figure of a band with one row for each run.

    Parameters
    ----------
    stretches_of
        Returns the stretches of a run.
    name_of, color_of
        Of the states, which are the numbers of the stretches.
    """
    names = [label(run.name) for run in runs]
    bars: dict[int, dict[str, Any]] = {}
    for name, run in zip(names, runs, strict=True):
        for stretch in stretches_of(run):
            new = _bar(name_of(stretch.source), color_of(stretch.source))
            bar = bars.setdefault(stretch.source, new)
            bar["y"].append(name)
            bar["base"].append(stretch.begin)
            bar["x"].append(stretch.end - stretch.begin)
            bar["customdata"].append([stretch.begin, stretch.end, stretch.steps])
    y = axis(
        "",
        autorange="reversed",
        showticklabels=len(runs) > 1,
        ticks="",
        categoryorder="array",
        categoryarray=names,
    )
    drawn = over_time(runs, [bars[state] for state in sorted(bars)], y)
    drawn["layout"].update(
        {
            "barmode": "overlay",
            "showlegend": True,  # of a single state too
            "bargap": 0.25,
            "hovermode": "closest",
            "height": 110 + _HEIGHT * len(runs),
        }
    )
    return drawn


def _bar(name: str, color: str) -> dict[str, Any]:
    return {
        "type": "bar",
        "orientation": "h",
        "name": name,
        "y": [],
        "base": [],
        "x": [],
        "customdata": [],
        "marker": {"color": color, "line": {"width": 0}},
        "hovertemplate": "%{customdata[0]:.6g} s to %{customdata[1]:.6g} s: %{customdata[2]} steps",
    }
