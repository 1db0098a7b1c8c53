"""Diagram of the report that shows the paths of the craft in the orbital plane."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Final

from spacecraft_gnc.drawing.chart import Chart
from spacecraft_gnc.drawing.envelope import strided
from spacecraft_gnc.drawing.traces import Trace, axis, figure, label, packed, run_line
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation import flown as series
from spacecraft_gnc.vehicles.formation.flown import KM, Flown

_HEIGHT: Final = 480  # [px]
_NOTE: Final = (
    "Circles: starts; dots: ends; diamonds: commanded places at the end; dashed: natural ellipse. "
    "Along the track to the right, outward up."
)


def path_chart(runs: Sequence[Flown], points: int) -> Chart:
    """Return the paths of all craft, in the colors of the craft or else of the runs."""
    traces = [item for ring in _rings(runs) for item in ring]
    for number, run in enumerate(runs):
        traces += _paths(run, points, number if len(runs) > 1 else None)
    along = axis("y along the track [km]", zeroline=True)
    radial = axis("x radial [km]", zeroline=True, scaleanchor="x", scaleratio=1.0)
    drawn = figure(traces, [radial], along)
    drawn["layout"] |= {"hovermode": "closest", "height": _HEIGHT}
    return Chart("paths", "Paths in the orbital plane, Hill's frame", _NOTE, drawn, wide=True)


def _rings(runs: Sequence[Flown]) -> Iterator[list[Trace]]:
    """Yield the natural ellipse of every size that occurs."""
    known = {run.scenario.plant.radial_semi_axis: run for run in runs if run.scenario is not None}
    for _, run in sorted(known.items()):
        line = {"color": series.ELLIPSE_COLOR, "dash": "dash", "width": 1.5}
        ring = _trace(series.ellipse(run.scenario), "natural ellipse", line=line)
        yield [{**ring, "hoverinfo": "skip"}]


def _paths(run: Flown, points: int, number: int | None) -> Iterator[Trace]:
    at, places = series.positions(run.trajectory), series.held_places(run)
    chosen = strided(len(at), points)
    for i, name in enumerate(series.craft_names(run)):
        several = number is not None
        line = (
            {"color": series.craft_color(i), "width": 1.7} if number is None else run_line(number)
        )
        shown: dict[str, Any] = (
            {"legendgroup": run.name, "showlegend": i == 0} if several else {"legendgroup": name}
        )
        text = run.name if several else name
        yield _trace(at[chosen, i], text, line=line, **shown)
        for points_of, symbol in (
            (at[:1, i], "circle-open"), (at[-1:, i], "circle"), (places[-1:, i], "diamond-open"),
        ):  # fmt: skip
            marker = {"symbol": symbol, "size": 9, "color": line["color"]}
            yield _trace(points_of, text, mode="markers", marker=marker,
                         **{**shown, "showlegend": False})  # fmt: skip


def _trace(position: Array, text: str, **options: Any) -> Trace:
    """Return points (k, 3) [m] as the diagram draws them [km]."""
    return {
        "type": "scatter",
        "mode": "lines",
        "x": packed(KM * position[:, 1]),
        "y": packed(KM * position[:, 0]),
        "name": label(text),
        "hovertemplate": "y %{x:.5g} km, x %{y:.5g} km",
        **options,
    }
