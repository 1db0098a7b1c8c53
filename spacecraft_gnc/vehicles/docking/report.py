"""Report of docking flights."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from spacecraft_gnc.drawing import bodies_view, style
from spacecraft_gnc.drawing.bands import band
from spacecraft_gnc.drawing.chart import (
    HELD,
    Chart,
    Variant,
    components,
    one_curve_each,
    over_time,
    span,
    times_of,
)
from spacecraft_gnc.drawing.marks import mark
from spacecraft_gnc.drawing.sources import Stretch
from spacecraft_gnc.drawing.traces import (
    Curve,
    axis,
    component_line,
    limit,
    log_axis,
    run_line,
    trace,
)
from spacecraft_gnc.drawing.view import View
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking import flown as series
from spacecraft_gnc.vehicles.docking.decision import Answer, Phase
from spacecraft_gnc.vehicles.docking.flown import Flown
from spacecraft_gnc.vehicles.docking.limits import clearances, margins
from spacecraft_gnc.vehicles.docking.rows import ROWS
from spacecraft_gnc.vehicles.docking.space import view_of
from spacecraft_gnc.vehicles.docking.summary import answer_name, phase_name
from spacecraft_gnc.vehicles.docking.telemetry import Telemetry, telemetry

if TYPE_CHECKING:
    from spacecraft_gnc.recording.bag import Bag
    from spacecraft_gnc.vehicles.docking.flight import DockingFlight
    from spacecraft_gnc.vehicles.docking.scenario import Scenario

_NEAR: Final = (-0.08, 0.25)
"""[m] of a distance that is looked at closely."""
_COUNTED: Final = {
    "missing_steps": "steps without a state or a command (gaps in the curves)",
    "inadmissible_steps": "steps without an admissible reference",
    "fallback_steps": "steps flown on a fallback command",
    "missed_deadlines": "commands that came after their deadline",
}
_PHASE_COLORS: Final = {
    Phase.DOCKING: style.AXIS_COLORS[2],
    Phase.ABORTING: style.AXIS_COLORS[1],
    Phase.HOLDING: style.RUN_COLORS[5],
}
_ANSWER_COLORS: Final = {
    Answer.OPTIMAL: style.AXIS_COLORS[2],
    Answer.INFEASIBLE: style.LIMIT_COLOR,
    Answer.NOT_SOLVED: style.INK,
    Answer.LEAST_VIOLATION: style.AXIS_COLORS[1],
    Answer.PASSED: style.RUN_COLORS[5],
}


class DockingReport:
    """Implements `drawing.vehicle.VehicleReport`."""

    rows = ROWS

    def telemetry(
        self,
        flight: DockingFlight,
        scenario: Scenario | None,
        bag: Bag | None,
        namespace: str | None = None,
    ) -> Telemetry:
        """Return what a flight tells beside its arrays."""
        is_free = scenario is not None and scenario.plant.mode == "free_run"
        return telemetry(flight, bag, namespace, is_free=is_free)

    def warnings(self, run: Flown) -> Iterator[str]:
        """Yield what a reader should know before trusting the curves."""
        for each in run.metrics["limits_exceeded"]:
            yield f"constraint broken: {each['text']}"
        if run.metrics["thruster_lost"] and run.metrics["thruster_loss_detected_at"] is None:
            yield f"thruster {run.metrics['thruster_lost']} was lost, which was not noticed"
        for alarm in run.metrics["false_alarms"]:
            yield f"thruster {alarm['thruster']} was wrongly taken for lost at {alarm['at']:g} s"
        for key, what in _COUNTED.items():
            if run.metrics[key]:
                yield f"{what}: {run.metrics[key]}"

    def charts(self, runs: Sequence[Flown], points: int) -> Iterator[Chart]:
        """Yield the diagrams; those of one run show what happened."""
        for chart in _charts(runs, points):
            if len(runs) == 1 and not chart.wide:
                for figure in (chart.figure, *(variant.figure for variant in chart.variants)):
                    if figure:
                        mark(figure, series.marks(runs[0].trajectory))
            yield chart

    def scene(self, runs: Sequence[Flown], points: int) -> View:
        """Return both bodies in space."""
        return view_of(runs, points)

    def scene_script(self) -> str:
        """Return the code of the view."""
        return bodies_view.script()


REPORT: Final = DockingReport()


def _charts(runs: Sequence[Flown], points: int) -> Iterator[Chart]:
    yield _single(
        runs, points, "distance", "Distance of the ports", series.distance, "m",
        "Docked below 2 cm and 1 deg, for good.", log_axis,
    )  # fmt: skip
    yield _single(
        runs, points, "angle", "Angle between deputy and chief", series.angle_deg, "deg",
        "Of the rotation from one to the other.", log_axis,
    )  # fmt: skip
    yield _vector(
        runs, points, "force", "Force", series.force, "N", bound="max_force",
        note="Commanded about the deputy's center of mass, chief frame, held over each step.",
    )  # fmt: skip
    yield _vector(
        runs, points, "moment", "Moment", series.moment, "N m", bound="max_moment",
        note="Commanded, chief frame, held over each step.",
    )  # fmt: skip
    yield _pursuit(
        runs, points, "offset", "Port offset", series.offset, series.reference_offset, "m"
    )
    yield _pursuit(
        runs, points, "rotation", "Rotation vector", series.rotation_deg, series.reference_deg,
        "deg",
    )  # fmt: skip
    yield _close(
        runs, points, "sight", "Line-of-sight margin", margins, "m",
        "Least over each control step, between the steps too; below zero: out of sight.",
        bound=lambda _: 0.0,
    )  # fmt: skip
    yield _close(
        runs, points, "clearance", "Clearance", clearances, "m",
        "Least distance of a vertex of the deputy from the plane of the docking face, likewise.",
        bound=lambda run: -series.limit_of(run.scenario, "clearance_tolerance"),
    )  # fmt: skip
    if any(np.isfinite(run.trajectory.residual).any() for run in runs):
        yield from _governor(runs, points)
    if any((run.trajectory.phase != Phase.DOCKING).any() for run in runs):
        yield _band(runs, "phase", "Phase", lambda f: f.phase, phase_name, _PHASE_COLORS)
    if any((run.trajectory.status != run.trajectory.status[0]).any() for run in runs):
        yield _band(
            runs, "answer", "Governor's answer", lambda f: f.status, answer_name, _ANSWER_COLORS
        )


def _governor(runs: Sequence[Flown], points: int) -> Iterator[Chart]:
    yield _single(
        runs, points, "slack", "Slack of the admissible set", series.slack_percent, "%",
        "Smallest of a row, as a share of its room; below zero: outside.", axis,
        bound=lambda _: 0.0,
    )  # fmt: skip
    yield _single(
        runs, points, "solve_time", "Time of the governor", lambda f: 1e3 * f.solve_time, "ms",
        "Wall time of each decision.", log_axis,
    )  # fmt: skip


def _single(
    runs: Sequence[Flown],
    points: int,
    name: str,
    title: str,
    values: Callable[[DockingFlight], Array],
    unit: str,
    note: str,
    scale: Callable[[str], dict[str, Any]],
    bound: Callable[[Flown], float] | None = None,
) -> Chart:
    """Return a diagram with one curve of each run, and the bounds of all of them."""
    traces = list(one_curve_each(runs, points, lambda run: values(run.trajectory), title))
    traces += [
        limit(span(runs), (side, side), f"at least {side:g} {unit}")
        for side in sorted({bound(run) for run in runs} if bound else ())
    ]
    drawn = over_time(runs, traces, scale(f"{title.lower()} [{unit}]"))
    return Chart(name, title, note, drawn, scale="yaxis" if scale is log_axis else "")


def _close(
    runs: Sequence[Flown],
    points: int,
    name: str,
    title: str,
    values: Callable[[DockingFlight], Array],
    unit: str,
    note: str,
    bound: Callable[[Flown], float],
) -> Chart:
    """Return a diagram of a distance whose last centimeters can be looked at too."""
    whole = _single(runs, points, name, title, values, unit, note, axis, bound)
    near = _single(runs, points, name, title, values, unit, note, _near_axis, bound)
    forms = (("whole", "whole", whole), ("near", "the last centimeters", near))
    variants = tuple(Variant(form, text, note, chart.figure) for form, text, chart in forms)
    return Chart(name, title, note, variants=variants)


def _near_axis(title: str) -> dict[str, Any]:
    return axis(title, range=_NEAR)


def _vector(
    runs: Sequence[Flown],
    points: int,
    name: str,
    title: str,
    values: Callable[[DockingFlight], Array],
    unit: str,
    note: str,
    bound: str,
) -> Chart:
    """Return a diagram of commands with their limits."""
    prefixed = style.prefixed(unit, *(values(run.trajectory) for run in runs))
    limits = {series.limit_of(run.scenario, bound) for run in runs} - {0.0}
    beneath = [
        limit(span(runs), (side, side), f"limit {side:g} {prefixed.label}")
        for most in sorted(limits)
        for side in (prefixed.factor * most, -prefixed.factor * most)
    ]
    drawn = components(
        runs, points, lambda run: values(run.trajectory), "xyz", title.lower(), prefixed,
        beneath if len(runs) == 1 else (), **HELD,
    )  # fmt: skip
    return Chart(name, title, note, drawn, tall=len(runs) > 1)


def _pursuit(
    runs: Sequence[Flown],
    points: int,
    name: str,
    title: str,
    values: Callable[[DockingFlight], Array],
    asked: Callable[[DockingFlight], Array],
    unit: str,
) -> Chart:
    """Return a diagram of what was flown, and dotted what the governor asked for."""
    several, traces = len(runs) > 1, []
    for i, run in enumerate(runs):
        parts = zip(values(run.trajectory).T, asked(run.trajectory).T, "xyz", strict=True)
        for j, (flown, reference, part) in enumerate(parts):
            line = {**(run_line(i) if several else component_line(j)), "dash": "solid"}
            shown = {"legendgroup": run.name, "showlegend": j == 0} if several else {}
            text, row = (run.name, j) if several else (part, 0)
            curve = Curve(times_of(run, flown), flown, text, line, row=row, options=shown)
            dotted = {**line, **HELD, "dash": "dot", "width": 1.3}
            hidden = {**shown, "showlegend": False}
            asked_for = Curve(curve.times, reference, f"{text}, reference", dotted, row, hidden)
            traces += [trace(curve, points), trace(asked_for, points)]
    labels = [f"{part} [{unit}]" for part in "xyz"] if several else [f"{title.lower()} [{unit}]"]
    drawn = over_time(runs, traces, *(axis(text) for text in labels))
    return Chart(name, title, "Dotted: the governor's reference.", drawn, tall=several)


def _band(
    runs: Sequence[Flown],
    name: str,
    title: str,
    values: Callable[[DockingFlight], Array],
    name_of: Callable[[int], str],
    colors: dict[Any, str],
) -> Chart:
    """Return the band of the states of each run over time."""

    def stretches_of(run: Flown) -> list[Stretch]:
        return list(_stretches(values(run.trajectory), run.times))

    drawn = band(runs, stretches_of, name_of, lambda state: colors.get(state, style.MUTED))
    return Chart(name, title, "", drawn, wide=True)


def _stretches(states: Array, times: Array) -> Iterator[Stretch]:
    """Yield the stretches of one state of the steps (n,); times (n + 1,) [s]."""
    begins = np.flatnonzero(np.append(True, states[1:] != states[:-1]))
    for begin, end in zip(begins, np.append(begins[1:], len(states)), strict=True):
        yield Stretch(int(states[begin]), float(times[begin]), float(times[end]), int(end - begin))
