"""Panels of planned flights: what was flown over what was planned, bounds and co-states."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.axes import component, frame, legend, logarithmic
from spacecraft_gnc.drawing.axes import limit as draw_limit
from spacecraft_gnc.drawing.chart import held
from spacecraft_gnc.drawing.marks import draw_marks
from spacecraft_gnc.vehicles.rigid_body import series
from spacecraft_gnc.vehicles.rigid_body.pictures import motion as panels
from spacecraft_gnc.vehicles.rigid_body.planner import series as plan_series
from spacecraft_gnc.vehicles.rigid_body.planner.plan import AXES
from spacecraft_gnc.vehicles.rigid_body.planner.recorded import as_flown

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.vehicles.rigid_body.telemetry import Telemetry


_PLANNED_BOUND: Final = "planned bound"


def momentum(axes: Axes, trajectory: Flight, bounds: plan_series.Bounds | None) -> None:
    """Draw the components of the momentum, the planned ones as bands beneath, and the bounds."""
    panels.momentum(axes, trajectory)
    unit = style.prefixed("N m s", series.momenta(trajectory))
    times = series.state_times(trajectory)
    for i in range(3):
        planned = unit.factor * plan_series.planned_momenta(trajectory)[:, i]
        axes.plot(times, planned, **_band(i))
    _draw_bounds(axes, bounds, 2, unit)
    _finish(axes, trajectory)


def torque(axes: Axes, trajectory: Flight, bounds: plan_series.Bounds | None) -> None:
    """Draw the components of the torque, the planned ones as bands beneath, and the bounds."""
    panels.torque_components(axes, trajectory)
    unit = style.prefixed("N m", trajectory.torque)
    times = series.state_times(trajectory)
    for i in range(3):
        planned = unit.factor * held(trajectory.plan_torque)[:, i]
        axes.step(times, planned, where="post", **_band(i))
    _draw_bounds(axes, bounds, 0, unit)
    _finish(axes, trajectory)


def error(axes: Axes, trajectory: Flight) -> None:
    """Draw the angle from the planned attitude."""
    values = plan_series.drawn_error_deg(trajectory)
    axes.plot(trajectory.time, values, color=style.INK)
    logarithmic(axes, values)
    title = "Error off the plan"
    if not np.nanmax(values, initial=0.0) > plan_series.LEAST_DEG:
        title += f": none, less than {plan_series.LEAST_DEG:g} deg"
        axes.set_ylim(0.01 * plan_series.LEAST_DEG, 1e3 * plan_series.LEAST_DEG)
    frame(axes, series.state_times(trajectory), title, "angle [deg]")
    draw_marks(axes, plan_series.plan_marks(trajectory))


def co_momentum(axes: Axes, trajectory: Flight, telemetry: Telemetry) -> None:
    """Draw the co-momenta of the plans."""
    _costates(axes, trajectory, telemetry, "co_momentum")
    frame(axes, series.state_times(trajectory), "Co-momentum of the plan", "co-momentum [N m]")


def torque_multipliers(axes: Axes, trajectory: Flight, telemetry: Telemetry) -> None:
    """Draw the multipliers of the bounds on the torque."""
    _costates(axes, trajectory, telemetry, "torque_multipliers")
    title = "Multipliers of the torque bounds"
    frame(axes, series.state_times(trajectory), title, "multiplier [N m]")


def momentum_multipliers(axes: Axes, trajectory: Flight, telemetry: Telemetry) -> None:
    """Draw the multipliers of the bounds on the momentum."""
    _costates(axes, trajectory, telemetry, "momentum_multipliers")
    title = "Multipliers of the momentum bounds"
    frame(axes, series.state_times(trajectory), title, "multiplier [N m/s]")


def _costates(axes: Axes, trajectory: Flight, telemetry: Telemetry, name: str) -> None:
    steps, values = as_flown(telemetry.plans, name)
    times = trajectory.time[0] + trajectory.period * steps
    for i, label in enumerate(AXES):
        axes.step(times, values[:, i], where="post", label=label, **component(i))
    legend(axes, 3)
    draw_marks(axes, plan_series.plan_marks(trajectory))


def _finish(axes: Axes, trajectory: Flight) -> None:
    """Draw the lines of events, whose texts stand in the error's panel, and say what is what."""
    draw_marks(axes, [mark._replace(text="") for mark in plan_series.plan_marks(trajectory)])
    shown = axes.get_legend()
    band = axes.plot([], [], label="planned", **_band(0) | {"color": style.MUTED})
    bounds = [line for line in axes.lines if line.get_label() == _PLANNED_BOUND]
    axes.legend(  # in the margin below the lower bounds
        handles=[*band, *bounds], loc="lower left", ncols=2, fontsize=7.0,
        borderaxespad=0.4, borderpad=0.0, handlelength=1.6, columnspacing=1.0,
    )  # fmt: skip
    if shown is not None:
        axes.add_artist(shown)


def _band(index: int) -> dict[str, Any]:
    """Return the look of a planned component beneath the flown one."""
    return {"color": style.COMPONENT_COLORS[index], "linewidth": 5.0, "alpha": 0.28, "zorder": 1.5}


def _draw_bounds(axes: Axes, bounds: plan_series.Bounds | None, row: int, unit: style.Unit) -> None:
    if bounds is None:
        return
    for bound in plan_series.drawn_bounds(bounds, row, unit):
        is_named = not bound.is_real and bound.value > 0.0 and bool(bound.text)
        label = _PLANNED_BOUND if is_named else None
        draw_limit(axes, bound.value, label, width=1.1 if bound.is_real else 0.7)
        if bound.is_real:
            axes.annotate(
                bound.text, (1.0, bound.value), xycoords=("axes fraction", "data"),
                xytext=(-2, 2), textcoords="offset points", ha="right", va="bottom",
                fontsize=7.5, color=style.LIMIT_COLOR,
            )  # fmt: skip
    low, high = axes.get_ylim()
    spread = np.array([low, high, *(b.value for b in plan_series.drawn_bounds(bounds, row, unit))])
    margin = 0.08 * (spread.max() - spread.min())
    axes.set_ylim(spread.min() - margin, spread.max() + margin)
