"""Diagrams of the solver, of where commands came from, and of the governor."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, Final

import numpy as np

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.chart import HELD, Chart, named, one_curve_each, over_time, span
from spacecraft_gnc.drawing.traces import (
    Trace,
    axis,
    figure,
    label,
    limit,
    log_axis,
    packed,
    run_line,
)
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body import series
from spacecraft_gnc.vehicles.rigid_body.flown import Flown

_BINS: Final = 40
_FEW: Final = 8  # iterations that each have a tick
_WIDE: Final = 2.5  # decades beyond which only powers of ten have a tick


def solver_charts(runs: Sequence[Flown], points: int) -> Iterator[Chart]:
    """Yield the diagrams of the solves, where there were any."""
    solved = [run for run in runs if (run.trajectory.status >= 0).any()]
    if solved:
        yield _iterations(runs, points)
        yield _residual(runs, points)
        yield _solve_times(runs)
    yield from _slack(runs, points)
    yield from _curvature(runs, points)
    yield from _radius(runs, points)
    yield from _governor(runs, points)


def _iterations(runs: Sequence[Flown], points: int) -> Chart:
    def counts(run: Flown) -> Array:
        solved = run.trajectory.status >= 0
        return np.where(solved, run.trajectory.iterations, math.nan)

    traces = list(one_curve_each(runs, points, counts, "iterations", **HELD))
    for i, run in enumerate(runs):
        failed = series.unconverged(run.trajectory)
        if failed.any():
            traces.append(_marks(runs, i, run.trajectory.time[failed], counts(run)[failed]))
    few = max(run.metrics["iterations_max"] or 0 for run in runs) <= _FEW
    y = axis("iterations [-]", rangemode="tozero", dtick=1 if few else None)
    note = "Of the solve behind each command."
    return Chart("iterations", "Solver iterations", note, over_time(runs, traces, y))


def _marks(runs: Sequence[Flown], index: int, times: Array, values: Array) -> Trace:
    return {
        "type": "scatter",
        "mode": "markers",
        "x": packed(times),
        "y": packed(values),
        "name": label(named(runs, runs[index], "not converged")),
        "marker": {"symbol": "x", "size": 7, "color": style.LIMIT_COLOR},
    }


def _residual(runs: Sequence[Flown], points: int) -> Chart:
    traces = list(one_curve_each(runs, points, lambda run: run.trajectory.residual, "residual"))
    tolerances = {
        run.scenario.controller.residual_tolerance for run in runs if run.scenario is not None
    }
    traces += [limit(span(runs), (t, t), f"tolerance {t:g}") for t in sorted(tolerances)]
    note = "Euclidean norm of the optimality conditions when the solve ended."
    drawn = over_time(runs, traces, log_axis("residual [-]"))
    return Chart("residual", "Residual", note, drawn, scale="yaxis")


def _slack(runs: Sequence[Flown], points: int) -> Iterator[Chart]:
    known = [run.telemetry.deadline_slack for run in runs]
    unit = style.prefixed("s", *known)
    traces = list(
        one_curve_each(
            runs, points, lambda run: unit.factor * run.telemetry.deadline_slack, "slack", **HELD
        )
    )
    if traces:
        traces.append(limit(span(runs), (0.0, 0.0), "deadline"))
        note = (
            "Wall time left when the solve ended; negative: the deadline was missed. A torque may "
            "still come late: the plant counts those (see the summary)."
        )
        y = axis(f"slack [{unit.label}]")
        yield Chart("slack", "Deadline slack", note, over_time(runs, traces, y))


def _curvature(runs: Sequence[Flown], points: int) -> Iterator[Chart]:
    traces = list(
        one_curve_each(runs, points, lambda run: run.telemetry.min_curvature, "least curvature")
    )
    if traces:
        note = "Smallest eigenvalue of the reduced Hessian; positive: a minimum." + _absent(
            runs, "min_curvature"
        )
        y = axis("curvature [cost per (N m)²]", rangemode="tozero")
        yield Chart(
            "curvature", "Least curvature of the solution", note, over_time(runs, traces, y)
        )


def _radius(runs: Sequence[Flown], points: int) -> Iterator[Chart]:
    traces = list(
        one_curve_each(runs, points, lambda run: run.telemetry.closed_loop_radius, "radius", **HELD)
    )
    if traces:
        traces.append(limit(span(runs), (1.0, 1.0), "stable below 1"))
        note = (
            "Spectral radius of the closed loop linearized at a standstill away from the target; "
            "above 1 it is unstable. Known at standstills only."
        )
        y = axis("spectral radius [-]", rangemode="tozero")
        for item in traces[:-1]:
            item["mode"] = "lines+markers"  # a standstill of one step is a point
            item["marker"] = {"size": 4}
        yield Chart(
            "radius", "Closed-loop radius at a standstill", note, over_time(runs, traces, y)
        )


def _absent(runs: Sequence[Flown], name: str) -> str:
    without = [r.name for r in runs if not np.isfinite(getattr(r.telemetry, name)).any()]
    return f" Not recorded: {', '.join(without)}." if without else ""


def _solve_times(runs: Sequence[Flown]) -> Chart:
    known = [_positive(run.trajectory.solve_time) for run in runs]
    deadlines = {
        value: text
        for run in runs
        for value, text in [series.solve_deadline(run.scenario)]
        if value
    }
    unit = style.prefixed("s", *(values for values in known))
    every = np.concatenate([*known, np.array([*deadlines, *([1e-6] if not deadlines else [])])])
    low, high = math.log10(every.min()), math.log10(every.max())
    edges = np.logspace(low - 0.02, high + 0.02, _BINS + 1)
    traces = [_bars(runs, i, values, edges, unit) for i, values in enumerate(known) if values.size]
    top = max((int(max(item["customdata"])) for item in traces), default=1)
    for value, text in deadlines.items():
        x = unit.factor * value
        traces.append(limit((x, x), (0.0, top), text))
    drawn = figure(
        traces,
        [axis("solves [-]", rangemode="tozero")],
        log_axis(f"wall time of a solve [{unit.label}]", dtick=1 if high - low > _WIDE else "D2"),
    )
    drawn["layout"].update({"barmode": "overlay", "bargap": 0, "hovermode": "closest"})
    note = (
        "Wall clock of the machine that flew; logarithmic bins. In lockstep there is no deadline: "
        "the control period is drawn instead."
    )
    return Chart("solve_time", "Solve-time histogram", note, drawn)


def _bars(
    runs: Sequence[Flown], index: int, values: Array, edges: Array, unit: style.Unit
) -> dict[str, Any]:
    counts, _ = np.histogram(values, edges)
    scaled = unit.factor * edges
    return {
        "type": "bar",
        "x": np.sqrt(scaled[1:] * scaled[:-1]).tolist(),
        "width": np.diff(scaled).tolist(),
        "y": counts.tolist(),
        "customdata": counts.tolist(),
        "name": label("solves" if len(runs) == 1 else runs[index].name),
        "opacity": 1.0 if len(runs) == 1 else 0.6,
        "marker": {"color": run_line(index)["color"]},
        "hovertemplate": f"about %{{x:.3g}} {unit.label}: %{{y}} solves",
    }


def _positive(values: Array) -> Array:
    return np.asarray(values[np.isfinite(values) & (values > 0.0)])


def _governor(runs: Sequence[Flown], points: int) -> Iterator[Chart]:
    def alpha(run: Flown) -> Array:
        governed = series.is_governed(run.trajectory)
        return np.where(governed, run.trajectory.alpha, math.nan)

    def margin(run: Flown) -> Array:
        values = run.trajectory.governor_margin
        return np.where(np.isfinite(values), values, math.nan)

    shares = list(one_curve_each(runs, points, alpha, "alpha", **HELD))
    if shares:
        y = axis("alpha [-]", range=[-0.03, 1.03])
        note = "Share of the way to the target, or to the next waypoint, that the governor allowed."
        yield Chart("alpha", "Governor: share of the way", note, over_time(runs, shares, y))
    margins = list(one_curve_each(runs, points, margin, "margin", **HELD))
    if margins:
        margins.append(limit(span(runs), (0.0, 0.0), "limit"))
        note = (
            "Smallest distance to any constraint over each prediction, in the unit of the "
            "constraint it belongs to (rad, N m or -)."
        )
        y = axis("margin [rad, N m or -]")
        yield Chart("margin", "Governor: predicted margin", note, over_time(runs, margins, y))
