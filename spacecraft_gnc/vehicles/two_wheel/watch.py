"""Diagrams of the watch over the wheels: residuals, modes, and when a wheel was lost."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from spacecraft_gnc.drawing.chart import Chart, named, over_time
from spacecraft_gnc.drawing.marks import mark
from spacecraft_gnc.drawing.traces import (
    DASHES,
    Curve,
    Trace,
    component_line,
    log_axis,
    run_line,
    trace,
)
from spacecraft_gnc.vehicles.two_wheel import flown as series
from spacecraft_gnc.vehicles.two_wheel.flown import Flown

_LEAST: Final = 1e-16
"""[rad/s] that a residual of 0 is drawn at."""


def watch_charts(runs: Sequence[Flown], points: int) -> Iterator[Chart]:
    """Yield the diagram of the residuals, where a run watches its wheels."""
    traces = [curve for i, run in enumerate(runs) for curve in _residuals(runs, i, run, points)]
    if traces:
        yield Chart(
            "residual",
            "Residuals of the wheels",
            "Change of speed over a control step less the one commanded"
            + ("; dotted: the largest that a healthy wheel can have." if len(runs) == 1 else "."),
            over_time(runs, traces, log_axis("residual [rad/s]")),
            scale="yaxis",
        )


def _residuals(runs: Sequence[Flown], i: int, run: Flown, points: int) -> Iterator[Trace]:
    watch = run.telemetry.watch
    if watch is None:
        return
    times = run.times[:-1]
    for j, wheel in enumerate(series.wheel_names(run.trajectory)):
        alone = len(runs) == 1
        line = component_line(j) if alone else run_line(i)
        line = {**line, "dash": "solid" if alone else DASHES[j % len(DASHES)]}
        size = np.maximum(np.abs(watch.residual[:, j]), _LEAST)
        yield trace(Curve(times, size, named(runs, run, wheel), line), points)
        if not alone:
            continue
        faint = {**line, "dash": "dot", "width": 1.0}
        hidden = {"showlegend": False, "hoverinfo": "skip"}
        yield trace(Curve(times, watch.threshold[:, j], "", faint, options=hidden), points)


def mark_losses(chart: Chart, runs: Sequence[Flown]) -> None:
    """Mark in a diagram over time of one run when wheels were lost and excluded."""
    if len(runs) == 1:
        mark(chart.figure, series.marks(runs[0].trajectory))
