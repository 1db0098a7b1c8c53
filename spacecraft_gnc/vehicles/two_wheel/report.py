"""Report of flights of a spacecraft with wheels."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from spacecraft_gnc.drawing import attitude_view, style
from spacecraft_gnc.drawing.chart import (
    HELD,
    Chart,
    components,
    held,
    named,
    one_curve_each,
    over_time,
    span,
    times_of,
)
from spacecraft_gnc.drawing.table import NOTHING, Row
from spacecraft_gnc.drawing.traces import (
    DASHES,
    Curve,
    Trace,
    axis,
    component_line,
    limit,
    log_axis,
    run_line,
    trace,
)
from spacecraft_gnc.drawing.view import View
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.two_wheel import flown as series
from spacecraft_gnc.vehicles.two_wheel.flown import Flown
from spacecraft_gnc.vehicles.two_wheel.summary import (
    alarm_texts,
    counts,
    direction,
    lost_texts,
    states,
)
from spacecraft_gnc.vehicles.two_wheel.telemetry import Telemetry, telemetry
from spacecraft_gnc.vehicles.two_wheel.watch import mark_losses, watch_charts

if TYPE_CHECKING:
    from spacecraft_gnc.recording.bag import Bag
    from spacecraft_gnc.vehicles.two_wheel.flight import WheelFlight
    from spacecraft_gnc.vehicles.two_wheel.scenario import Scenario

_COUNTED: Final = {
    "missing_steps": "steps without a state or a command (gaps in the curves)",
    "fallback_steps": "steps flown on a fallback command",
    "missed_deadlines": "commands that came after their deadline",
}


def _never(run: Flown) -> str:
    return "never" if run.metrics["final_error_deg"] is not None else "unknown"


def _none(run: Flown) -> str:
    return "unknown" if run.scenario is None else "none"


def _counted(name: str) -> Callable[[Flown], str]:
    """Return what tells a metric that counts by name."""
    return lambda run: counts(run.metrics[name]) or NOTHING


def _axis(run: Flown) -> str:
    axis = run.metrics["remaining_axis"]
    return NOTHING if axis is None else direction(axis)


ROWS: Final = (
    Row("Control steps", "steps"),
    Row("Control period", "period", "s"),
    Row("Duration", "duration", "s", 8),
    Row("Error at the end", "final_error_deg", "deg", absent=lambda _: "unknown"),
    Row("Below 0.01 rad and 0.001 rad/s for good from", "settle_time", "s", absent=_never),
    Row("Largest wheel speed", "max_wheel_speed", "rad/s", 8),
    Row("Limit of the wheel speed", "max_wheel_speed_limit", "rad/s", absent=_none),
    Row("Largest wheel acceleration", "max_wheel_acceleration", "rad/s²", 8),
    Row("Limit of the acceleration", "max_wheel_acceleration_limit", "rad/s²", absent=_none),
    Row("Drift of the total momentum", "momentum_drift", "N m s"),
    Row("Wheels lost", text=lambda run: "; ".join(lost_texts(run.metrics)) or NOTHING),
    Row("False alarms", text=lambda run: "; ".join(alarm_texts(run.metrics)) or NOTHING),
    Row("Plans by their end", text=_counted("plans")),
    Row("Flown", text=_counted("modes")),
    Row("Rest", text=lambda run: run.metrics["rest"] or "unknown"),
    Row("Rotation that remains", "remaining_rate", "rad/s"),
    Row("Axis of that rotation, body frame", text=_axis),
    Row("Attitude held (axis, where it turns) off the target", "pointing_loss_deg", "deg"),
    Row("Deadlines missed", "missed_deadlines"),
    Row("Steps on a fallback command", "fallback_steps"),
    Row("Incomplete steps", "missing_steps"),
    Row("Command from", text=_counted("sources")),
)


class WheelReport:
    """Implements `drawing.vehicle.VehicleReport`."""

    rows = ROWS

    def telemetry(
        self,
        flight: WheelFlight,
        scenario: Scenario | None,
        bag: Bag | None,
        namespace: str | None = None,
    ) -> Telemetry:
        """Return what a flight tells beside its arrays."""
        is_free = scenario is not None and scenario.plant.mode == "free_run"
        return telemetry(flight, bag, namespace, is_free=is_free)

    def warnings(self, run: Flown) -> Iterator[str]:
        """Yield what a reader should know before trusting the curves."""
        for key, what in _COUNTED.items():
            if run.metrics[key]:
                yield f"{what}: {run.metrics[key]}"

    def charts(self, runs: Sequence[Flown], points: int) -> Iterator[Chart]:
        """Yield the diagrams."""
        for chart in self._charts(runs, points):
            mark_losses(chart, runs)
            yield chart

    def _charts(self, runs: Sequence[Flown], points: int) -> Iterator[Chart]:
        yield _error(runs, points)
        yield from watch_charts(runs, points)
        for values in _VECTORS:
            yield _vector(runs, points, *values)
        for name, (title, of, unit, line) in _WHEELS.items():
            yield _wheels(runs, points, name, title, of, unit, **line)

    def scene(self, runs: Sequence[Flown], points: int) -> View:
        """Return the attitudes on the unit sphere."""
        return attitude_view.scene([_motion(run) for run in runs], points)

    def scene_script(self) -> str:
        """Return the code of the view."""
        return attitude_view.script()


REPORT: Final = WheelReport()


def _accelerations(flight: WheelFlight) -> Array:
    return held(flight.wheel_acceleration)


def _momentum(flight: WheelFlight) -> Array:
    return held(flight.total_momentum)


_VECTORS: Final = (
    (
        "euler",
        "Attitude",
        series.euler_deg,
        "deg",
        ("roll", "pitch", "yaw"),
        "3-2-1 Euler angles: R = Rz(yaw) Ry(pitch) Rx(roll).",
    ),
    ("rate", "Rate of the bus", series.rate, "rad/s", "xyz", "Components in the body frame."),
    (
        "momentum",
        "Total momentum",
        _momentum,
        "N m s",
        "XYZ",
        "Of bus and wheels, inertial frame: constant.",
    ),
)
_WHEELS: Final[dict[str, Any]] = {
    "wheel_speed": ("Wheel speeds", series.wheel_speed, "rad/s", {}),
    "wheel_acceleration": ("Wheel accelerations", _accelerations, "rad/s²", HELD),
}


def _error(runs: Sequence[Flown], points: int) -> Chart:
    traces = one_curve_each(
        runs, points, lambda run: series.error_deg(run.trajectory), "angle to the target"
    )
    return Chart(
        "error",
        "Attitude error",
        "Angle from the attitude to the target.",
        over_time(runs, traces, log_axis("angle [deg]")),
        scale="yaxis",
    )


def _vector(
    runs: Sequence[Flown],
    points: int,
    name: str,
    title: str,
    values: Callable[[WheelFlight], Array],
    unit: str,
    names: Sequence[str],
    note: str,
) -> Chart:
    prefixed = (
        style.Unit(unit, 1.0)
        if unit == "deg"
        else style.prefixed(unit, *(values(run.trajectory) for run in runs))
    )
    drawn = components(
        runs, points, lambda run: values(run.trajectory), names, title.lower(), prefixed
    )
    return Chart(name, title, note, drawn, tall=len(runs) > 1)


def _wheels(
    runs: Sequence[Flown],
    points: int,
    name: str,
    title: str,
    values: Callable[[WheelFlight], Array],
    unit: str,
    **line: Any,
) -> Chart:
    """Return a diagram with a curve for each wheel of each run, and the limits."""
    traces: list[Trace] = []
    for i, run in enumerate(runs):
        data = values(run.trajectory)
        for j, wheel in enumerate(series.wheel_names(run.trajectory)):
            look = component_line(j) if len(runs) == 1 else run_line(i)
            look = {**look, "dash": DASHES[j % len(DASHES)], **line}
            curve = Curve(times_of(run, data), data[:, j], named(runs, run, wheel), look)
            traces.append(trace(curve, points))
    for bound in sorted({series.limit_of(run.scenario, f"max_{name}") for run in runs} - {0.0}):
        traces += [
            limit(span(runs), (side, side), f"limit {side:g} {unit}") for side in (bound, -bound)
        ]
    note = "Relative to the bus" + (", held over each control period." if line else ".")
    return Chart(name, title, note, over_time(runs, traces, axis(f"{title.lower()} [{unit}]")))


def _motion(run: Flown) -> attitude_view.Motion:
    flight = run.trajectory
    return attitude_view.Motion(
        name=run.name,
        times=run.times,
        attitudes=states(flight)[1],
        references=np.concatenate([flight.reference, flight.reference[-1:]]),
        error_deg=series.error_deg(flight),
        vectors={
            "rate, body [rad/s]": series.rate(flight),
            "wheel speeds [rad/s]": series.wheel_speed(flight),
        },
        notes={"wheel speeds [rad/s]": series.beliefs(flight)},
        rotors=series.rotors(run),
    )
