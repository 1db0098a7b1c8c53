"""Page of plans: torque, momentum and co-states by component, each with its bounds."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, Final, Protocol

import numpy as np

from spacecraft_gnc.drawing import attitude_view, style
from spacecraft_gnc.drawing import representations as forms
from spacecraft_gnc.drawing.chart import (
    HELD,
    Chart,
    Variant,
    components,
    held,
    one_curve_each,
    over_time,
    span,
    times_of,
)
from spacecraft_gnc.drawing.table import NOTHING, Row
from spacecraft_gnc.drawing.traces import Curve, Trace, axis, component_line, limit, run_line, trace
from spacecraft_gnc.drawing.vehicle import FlownRun
from spacecraft_gnc.drawing.view import View
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.planner.plan import AXES, Plan
from spacecraft_gnc.vehicles.rigid_body.planner.rows import (
    active_texts,
    bounds_text,
    proves_a_time,
)

_NOTHING: Final = 1e-12  # [N^2 m^2] cost of a plan that stays where it is, at most


class Planned(FlownRun, Protocol):
    """A plan that a page shows."""

    @property
    def trajectory(self) -> Plan:
        """The plan."""


def _active(run: Planned) -> str:
    return "; ".join(active_texts(run.metrics)) or "none"


def _bounds(name: str) -> Callable[[Planned], str]:
    return lambda run: bounds_text(run.metrics[name]).replace("+-", "±")


def _proven(run: Planned) -> str:
    return f"{run.metrics['shortest_possible']:.6g} s" if proves_a_time(run.metrics) else NOTHING


def _starts(run: Planned) -> str:
    tried, cost = run.metrics["tried"], run.metrics["cost"]
    most = cost * (1.0 + 1e-6) + _NOTHING
    same = sum(one["status"] == "converged" and one["cost"] <= most for one in tried)
    return f"{same} of {len(tried)}"


ROWS: Final = (
    Row("Cost, sum of |u|² / 2 over the steps", "cost", "N² m²", 10),
    Row("Integral of |u|² / 2", "cost_integral", "N² m² s", 10),
    Row("Angle", "angle_deg", "deg", 8),
    Row("Duration", "duration", "s", 8),
    Row("Control steps", "steps"),
    Row("Control period", "period", "s"),
    Row("No torque makes it in less than", "shortest_possible", text=_proven),
    Row("Torque bounds [N m]", text=_bounds("torque_bounds")),
    Row("Momentum bounds [N m s]", text=_bounds("momentum_bounds")),
    Row("Bounds that act", text=_active),
    Row("Largest residual, relative", "residual", "", 3),
    Row("Least eigenvalue of the reduced Hessian, at least", "min_curvature", "", 3),
    Row("Newton steps", "iterations"),
    Row("Starts that led to it", text=_starts),
)


class PlanReport:
    """Implements `drawing.vehicle.VehicleReport` for plans."""

    rows = ROWS

    def telemetry(self, *_: Any) -> None:
        """Return what is told beside a plan: nothing."""

    def warnings(self, _: Planned) -> tuple[str, ...]:
        """Return what a reader should know first: what is no plan is not read."""
        return ()

    def charts(self, runs: Sequence[Planned], points: int) -> Iterator[Chart]:
        """Yield the diagrams."""
        yield _torque(runs, points)
        yield _momentum(runs, points)
        yield _co_momentum(runs, points)
        yield _attitude_co_states(runs, points)
        yield _multipliers(runs, points, "torque", "N m")
        yield _multipliers(runs, points, "momentum", "N m/s")
        error = one_curve_each(runs, points, lambda run: run.trajectory.error_deg, "to the goal")
        drawn = over_time(runs, error, axis("angle [deg]", rangemode="tozero"))
        yield Chart("error", "Angle to the goal", "", drawn)
        yield _attitude(runs, points)

    def scene(self, runs: Sequence[Planned], points: int) -> View:
        """Return the attitudes on the unit sphere."""
        return attitude_view.scene([_motion(run) for run in runs], points)

    def scene_script(self) -> str:
        """Return the code of the view."""
        return attitude_view.script()


def scaled_unit(unit: str, *values: Array) -> style.Unit:
    """Return a unit with the prefix that fits the values; kilograms have theirs."""
    return style.Unit(unit, 1.0) if unit.startswith("kg") else style.prefixed(unit, *values)


def _torque(runs: Sequence[Planned], points: int) -> Chart:
    drawn = _by_component(
        runs,
        points,
        lambda plan: held(plan.solution.torque),
        lambda plan: plan.torque_bounds,
        "N m",
        **HELD,
    )
    note = "Components in the body frame, held over each control period; dashed: bounds."
    return Chart("torque", "Torque", note, drawn, tall=True)


def _momentum(runs: Sequence[Planned], points: int) -> Chart:
    drawn = _by_component(
        runs,
        points,
        lambda plan: plan.solution.momentum,
        lambda plan: plan.momentum_bounds,
        "N m s",
    )
    note = "Components in the body frame; dashed: bounds."
    return Chart("momentum", "Angular momentum", note, drawn, tall=True)


def _co_momentum(runs: Sequence[Planned], points: int) -> Chart:
    drawn = _by_component(
        runs,
        points,
        lambda plan: held(plan.solution.co_momentum),
        lambda plan: plan.saturation,
        "N m",
        beyond="torque saturates beyond",
        **HELD,
    )
    note = (
        "Co-state of the momentum, gamma, which has no bounds of its own: the torque is -gamma "
        "between the dashed lines, and saturates where gamma is beyond one."
    )
    return Chart("co_momentum", "Co-momentum", note, drawn, tall=True)


def _attitude_co_states(runs: Sequence[Planned], points: int) -> Chart:
    drawn = _by_component(
        runs, points, lambda plan: held(plan.attitude_co_states), None, "kg m² N m", **HELD
    )
    note = "Co-state of the attitude in the body frame; in the inertial frame it is constant."
    return Chart("attitude_co_state", "Co-state of the attitude", note, drawn, tall=True)


def _multipliers(runs: Sequence[Planned], points: int, what: str, unit: str) -> Chart:
    def values(plan: Plan) -> Array:
        found: Array = getattr(plan.solution, f"{what}_multipliers")
        return held(found) if len(found) == plan.n_steps else found

    line = HELD if what == "torque" else {}
    drawn = _by_component(runs, points, values, None, unit, **line)
    note = "Positive where the upper bound acts, negative where the lower one does, else zero."
    title = f"Multipliers of the {what} bounds"
    return Chart(f"{what}_multipliers", title, note, drawn, tall=True)


def _by_component(
    runs: Sequence[Planned],
    points: int,
    values: Callable[[Plan], Array],
    bounds: Callable[[Plan], Array] | None,
    unit: str,
    beyond: str = "bound",
    **line: Any,
) -> dict[str, Any]:
    """Return the figure of a vector, one row for each component, with the bounds of every plan."""
    pairs = [bounds(run.trajectory) for run in runs] if bounds else []
    shown = scaled_unit(unit, *(values(run.trajectory) for run in runs), *pairs)
    several = len(runs) > 1
    traces: list[Trace] = []
    for i, run in enumerate(runs):
        data = shown.factor * values(run.trajectory)
        for j, name in enumerate(AXES):
            drawn = run_line(i) if several else {**component_line(j), "dash": "solid"}
            options = {"legendgroup": run.name, "showlegend": j == 0} if several else {}
            text, look = run.name if several else name, {**drawn, **line}
            curve = Curve(times_of(run, data), data[:, j], text, look, row=j, options=options)
            traces.append(trace(curve, points))
    for j in range(3):
        known = {float(value) for pair in pairs for value in pair[:, j] if np.isfinite(value)}
        traces += [_bound(runs, j, shown.factor * value, beyond) for value in sorted(known)]
    return over_time(runs, traces, *(axis(f"{name} [{shown.label}]") for name in AXES))


def _bound(runs: Sequence[Planned], row: int, value: float, text: str) -> Trace:
    line = limit(span(runs), (value, value), f"{text} {value:g}")
    return {**line, "yaxis": f"y{row + 1}" if row else "y", "showlegend": False}


def _attitude(runs: Sequence[Planned], points: int) -> Chart:
    variants = []
    for form in forms.REPRESENTATIONS:
        title = form.title.removeprefix("Attitude as ")
        drawn = components(
            runs,
            points,
            partial(_attitude_values, form),
            form.components,
            title.split(" x,")[0],
            style.Unit(form.unit, 1.0),
        )
        variants.append(Variant(form.name, title, form.convention, drawn))
    return Chart("attitude", "Attitude", variants=tuple(variants), tall=len(runs) > 1)


def _attitude_values(form: forms.Representation, run: Planned) -> Array:
    return forms.values(form, run.trajectory.solution.attitude)


def _motion(run: Planned) -> attitude_view.Motion:
    plan = run.trajectory
    solution = plan.solution
    goals = np.broadcast_to(solution.problem.goal, solution.attitude.shape)
    vectors = {
        "momentum, body [N m s]": solution.momentum,
        "torque, body [N m]": held(solution.torque),
    }
    return attitude_view.Motion(
        name=run.name,
        times=run.times,
        attitudes=solution.attitude,
        references=goals,
        error_deg=plan.error_deg,
        vectors=vectors,
    )
