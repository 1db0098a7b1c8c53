"""Diagrams of the motion: attitude, momentum, torque, pointing zones."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.drawing import representations as forms
from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.chart import (
    HELD,
    Chart,
    Variant,
    components,
    held,
    named,
    one_curve_each,
    over_time,
    span,
    times_of,
)
from spacecraft_gnc.drawing.traces import (
    DASHES,
    Curve,
    Trace,
    axis,
    limit,
    log_axis,
    run_line,
    trace,
)
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body import series
from spacecraft_gnc.vehicles.rigid_body.flown import Flown
from spacecraft_gnc.vehicles.rigid_body.report import plan

if TYPE_CHECKING:
    from spacecraft_gnc.loop.flight import Flight


def motion_charts(runs: Sequence[Flown], points: int) -> Iterator[Chart]:
    """Yield the diagrams of what the spacecraft did."""
    yield _attitude_error(runs, points)
    if any(series.is_moving(run.trajectory) for run in runs):
        yield _tracking(runs, points)
    yield _attitude(runs, points)
    yield _momentum(runs, points)
    yield _torque(runs, points)
    yield _torque_norm(runs, points)
    if any(series.is_disturbed(run.trajectory) for run in runs):
        yield _external_torque(runs, points)
    margins = list(_zone_margins(runs, points))
    if margins:
        border = limit(span(runs), (0.0, 0.0), "border of the zone")
        yield Chart(
            "zones",
            "Pointing-zone margin",
            "Angle left to the border of each zone; negative: violated.",
            over_time(runs, [*margins, border], axis("angle to the border [deg]")),
        )


def _attitude_error(runs: Sequence[Flown], points: int) -> Chart:
    def settling(run: Flown) -> Array:
        return series.settling_error_deg(run.trajectory)

    traces = list(one_curve_each(runs, points, settling, "angle to the target"))
    for i, run in enumerate(runs):
        if series.targets(run.trajectory) is not None:
            error = series.attitude_error_deg(run.trajectory)
            text = named(runs, run, "to the reference")
            line = {**run_line(i), "dash": "dot", "width": 1.1}
            traces.append(trace(Curve(times_of(run, error), error, text, line), points))
    return Chart(
        "error",
        "Attitude error",
        "Angle from the attitude to the target (to the reference where no governor shapes it).",
        over_time(runs, traces, log_axis("angle [deg]")),
        scale="yaxis",
    )


def _tracking(runs: Sequence[Flown], points: int) -> Chart:
    """Return the angle from the first reference to each reference and attitude, over time."""
    traces = list(one_curve_each(runs, points, _turned(series.attitudes), "attitude"))
    for i, run in enumerate(runs):
        angle = _turned(series.references)(run)
        line = {**run_line(i), "dash": "dot", "width": 4.0}
        text = named(runs, run, "reference")
        traces.append(trace(Curve(times_of(run, angle), angle, text, line), points))
    note = "Angle to the first reference, of the attitude and of the moving reference."
    return Chart("tracking", "Tracking", note, over_time(runs, traces, axis("angle [deg]")))


def _turned(attitudes: Callable[[Flight], Array]) -> Callable[[Flown], Array]:
    def angle(run: Flown) -> Array:
        first = run.trajectory.reference[:1]
        turned = attitudes(run.trajectory)
        return np.degrees(lie.angles_between(np.broadcast_to(first, turned.shape), turned))

    return angle


def _attitude(runs: Sequence[Flown], points: int) -> Chart:
    variants = []
    for form in forms.REPRESENTATIONS:
        drawn = components(
            runs,
            points,
            partial(_attitude_values, form),
            form.components,
            form.title.removeprefix("Attitude as ").split(" x,")[0],
            style.Unit(form.unit, 1.0),
        )
        note = form.convention + (_gimbal_lock(runs) if form is forms.ROLL_PITCH_YAW else "")
        variants.append(Variant(form.name, form.title.removeprefix("Attitude as "), note, drawn))
    return Chart("attitude", "Attitude", variants=tuple(variants), tall=len(runs) > 1)


def _attitude_values(form: forms.Representation, run: Flown) -> Array:
    return forms.values(form, series.attitudes(run.trajectory))


def _gimbal_lock(runs: Sequence[Flown]) -> str:
    """Return how many states lie near gimbal lock."""
    counts = {
        run.name: int(np.count_nonzero(forms.near_gimbal_lock(series.attitudes(run.trajectory))))
        for run in runs
    }
    near = [f"{name}: {count}" for name, count in counts.items() if count]
    where = f"within {forms.GIMBAL_LOCK_DEG:g} deg of gimbal lock"
    return f" States {where}: {', '.join(near) or 'none'}."


def _momentum(runs: Sequence[Flown], points: int) -> Chart:
    unit = style.prefixed("N m s", *(series.momenta(run.trajectory) for run in runs))
    drawn = components(
        runs, points, lambda run: series.momenta(run.trajectory), "xyz", "momentum", unit,
        plan.beneath_momentum(runs, points, unit),
    )  # fmt: skip
    note = f"Components in the body frame.{plan.note(runs)}"
    return Chart("momentum", "Angular momentum", note, drawn, tall=len(runs) > 1)


def _torque(runs: Sequence[Flown], points: int) -> Chart:
    unit = style.prefixed("N m", *(run.trajectory.torque for run in runs))
    drawn = components(
        runs, points, lambda run: held(run.trajectory.torque), "xyz", "torque", unit,
        plan.beneath_torque(runs, points, unit), **HELD,
    )  # fmt: skip
    note = f"Components in the body frame, held over each control period.{plan.note(runs)}"
    return Chart("torque", "Torque", note, drawn, tall=len(runs) > 1)


def _torque_norm(runs: Sequence[Flown], points: int) -> Chart:
    limits = [series.torque_limit(run.trajectory, run.scenario) for run in runs]
    norms = [series.torque_norm(run.trajectory) for run in runs]
    unit = style.prefixed("N m", *norms, np.array(limits))
    traces = list(
        one_curve_each(
            runs,
            points,
            lambda run: held(unit.factor * series.torque_norm(run.trajectory)),
            "|u|",
            **HELD,
        )
    )
    for value in sorted(set(limits) - {0.0}):
        scaled = unit.factor * value
        traces.append(limit(span(runs), (scaled, scaled), f"limit {scaled:g} {unit.label}"))
    y = axis(f"|torque| [{unit.label}]", rangemode="tozero")
    title = "Torque norm and limit" if any(limits) else "Torque norm"
    return Chart("torque_norm", title, plan.norm_note(runs), over_time(runs, traces, y))


def _external_torque(runs: Sequence[Flown], points: int) -> Chart:
    def values(run: Flown) -> Array:
        return held(run.trajectory.external_torque)

    unit = style.prefixed("N m", *(run.trajectory.external_torque for run in runs))
    drawn = components(runs, points, values, "xyz", "torque", unit, **HELD)
    note = "Sum of the disturbances in the body frame, which the controller does not know."
    return Chart("external_torque", "External torque", note, drawn, tall=len(runs) > 1)


def _zone_margins(runs: Sequence[Flown], points: int) -> Iterator[Trace]:
    for i, run in enumerate(runs):
        zones = run.scenario.controller.zones if run.scenario is not None else ()
        for j, zone in enumerate(zones):
            margin = series.zone_margin_deg(run.trajectory, zone)
            text = named(runs, run, f"{zone.name} ({zone.kind})")
            line = {**run_line(j if len(runs) == 1 else i), "dash": DASHES[j % len(DASHES)]}
            yield trace(Curve(times_of(run, margin), margin, text, line), points)
