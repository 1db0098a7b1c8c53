"""Diagrams of planned flights: what was planned, its bounds and its co-states."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Final

import numpy as np

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.bands import band
from spacecraft_gnc.drawing.chart import (
    HELD,
    Chart,
    Variant,
    held,
    one_curve_each,
    over_time,
    span,
)
from spacecraft_gnc.drawing.marks import mark
from spacecraft_gnc.drawing.sources import Stretch
from spacecraft_gnc.drawing.traces import (
    Curve,
    Trace,
    axis,
    component_line,
    limit,
    log_axis,
    run_line,
    trace,
)
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.flown import Flown
from spacecraft_gnc.vehicles.rigid_body.planner import series as plan_series
from spacecraft_gnc.vehicles.rigid_body.planner.plan import AXES
from spacecraft_gnc.vehicles.rigid_body.planner.recorded import as_flown

_FAINT: Final = {"width": 5.0}
_NOTE: Final = " Broad and faint: as planned. Dotted: bounds of the plan, less its reserve."
_NORM_NOTE: Final = "The bounds of a plan are on components, not on this norm: see the torque."
_COSTATES: Final = (
    (
        "co_momentum",
        "co-momentum",
        "N m",
        "Of each plan as long as it was flown; its negative is the torque where no bound acts.",
    ),
    (
        "torque_multipliers",
        "multipliers of the torque bounds",
        "N m",
        "Zero where no bound on the torque acts; positive at an upper, negative at a lower one.",
    ),
    (
        "momentum_multipliers",
        "multipliers of the momentum bounds",
        "N m/s",
        "Zero where no bound on the momentum acts; positive at an upper, negative at a lower one.",
    ),
)


def note(runs: Sequence[Flown]) -> str:
    """Return what is said of the planned curves; empty where there are none."""
    return _NOTE if _planned_alone(runs) else ""


def norm_note(runs: Sequence[Flown]) -> str:
    """Return what is said of the norm of a torque with bounds on its components."""
    return _NORM_NOTE if any(plan_series.is_planned(run.trajectory) for run in runs) else ""


def beneath_torque(runs: Sequence[Flown], points: int, unit: style.Unit) -> Iterator[Trace]:
    """Yield the planned torque of one planned run, and the bounds."""
    if _planned_alone(runs):
        yield from _planned(runs[0], held(runs[0].trajectory.plan_torque), points, unit, **HELD)
        yield from _bounds(runs[0], 0, unit)


def beneath_momentum(runs: Sequence[Flown], points: int, unit: style.Unit) -> Iterator[Trace]:
    """Yield the planned momentum of one planned run, and the bounds."""
    if _planned_alone(runs):
        planned = plan_series.planned_momenta(runs[0].trajectory)
        yield from _planned(runs[0], planned, points, unit)
        yield from _bounds(runs[0], 2, unit)


def plan_charts(runs: Sequence[Flown], points: int) -> Iterator[Chart]:
    """Yield the diagrams that only planned flights have."""
    traces = list(
        one_curve_each(
            runs, points, lambda run: plan_series.drawn_error_deg(run.trajectory), "off the plan"
        )
    )
    if traces:
        yield Chart(
            "plan_error",
            "Error off the plan",
            "Angle from the planned attitude of each step to the attitude; "
            f"{plan_series.LEAST_DEG:g} deg stands for less.",
            over_time(runs, traces, log_axis("angle [deg]")),
            scale="yaxis",
        )
    variants = tuple(
        Variant(name, label, text, drawn)
        for name, label, unit, text in _COSTATES
        if (drawn := _costates(runs, points, name, label, unit))
    )
    if variants:
        is_tall = len(runs) > 1
        yield Chart("costates", "Co-states of the plan", variants=variants, tall=is_tall)
    planned = [run for run in runs if plan_series.is_planned(run.trajectory)]
    if planned:
        yield _phases(planned)


def _phases(runs: Sequence[Flown]) -> Chart:
    def of(run: Flown) -> list[Stretch]:
        return plan_series.phase_stretches(run.trajectory, run.times)

    drawn = band(runs, of, plan_series.phase_name, plan_series.phase_color)
    note = "What becomes of the plan: another one is sought where the spacecraft is too far off it."
    return Chart("phases", "Phases of the plan", note, drawn, wide=True)


def mark_plans(chart: Chart, runs: Sequence[Flown]) -> None:
    """Mark in a diagram over time of one run when plans were sought, taken, and ended."""
    if chart.wide or not _planned_alone(runs):
        return
    marks = plan_series.plan_marks(runs[0].trajectory)
    for figure in [chart.figure, *(variant.figure for variant in chart.variants)]:
        if figure and _is_over_time(figure):
            mark(figure, marks)


def _is_over_time(figure: dict[str, Any]) -> bool:
    return str(figure["layout"]["xaxis"]["title"]["text"]).startswith("time ")


def _planned_alone(runs: Sequence[Flown]) -> bool:
    return len(runs) == 1 and plan_series.is_planned(runs[0].trajectory)


def _planned(
    run: Flown, values: Array, points: int, unit: style.Unit, **line: Any
) -> Iterator[Trace]:
    for i, name in enumerate(AXES):
        look = {"color": style.COMPONENT_COLORS[i], **_FAINT, **line}
        options = {"opacity": 0.28, "showlegend": False}
        data = unit.factor * values[:, i]
        yield trace(Curve(run.times, data, f"{name}, planned", look, options=options), points)


def _bounds(run: Flown, row: int, unit: style.Unit) -> Iterator[Trace]:
    bounds = plan_series.bounds_of(run.scenario)
    for bound in [] if bounds is None else plan_series.drawn_bounds(bounds, row, unit):
        drawn = limit(span([run]), (bound.value, bound.value), bound.text)
        if not bound.is_real:
            drawn["line"] = {**drawn["line"], "dash": "dot", "width": 1.0}
        yield {**drawn, "showlegend": bool(bound.text) and bound.is_real}


def _costates(
    runs: Sequence[Flown], points: int, name: str, label: str, unit: str
) -> dict[str, Any] | None:
    """Return the figure of a co-state of the plans; None where none was recorded, or it is zero.

    One diagram for one run, else one for each component.
    """
    several = len(runs) > 1
    traces: list[Trace] = []
    size = 0.0
    for i, run in enumerate(runs):
        if not run.telemetry.plans:
            continue
        steps, values = as_flown(run.telemetry.plans, name)
        size = max(size, float(np.nanmax(np.abs(values))))
        times = run.times[0] + run.trajectory.period * steps
        for j, component in enumerate(AXES):
            look = {**(run_line(i) if several else component_line(j)), **HELD}
            options = {"legendgroup": run.name, "showlegend": j == 0} if several else {}
            text, row = (run.name, j) if several else (component, 0)
            curve = Curve(times, values[:, j], text, look, row=row, options=options)
            traces.append(trace(curve, points))
    if size == 0.0:
        return None
    texts = [f"{component} [{unit}]" for component in AXES] if several else [f"{label} [{unit}]"]
    return over_time(runs, traces, *(axis(text) for text in texts))
