"""Figures for print of flights of a spacecraft with wheels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.axes import component, frame, legend, legend_below, limit, logarithmic
from spacecraft_gnc.drawing.chart import held
from spacecraft_gnc.drawing.figures import DOUBLE, SINGLE, Draw, Maker, stacked
from spacecraft_gnc.drawing.marks import Mark, draw_marks
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.two_wheel import flown as series
from spacecraft_gnc.vehicles.two_wheel.flown import Flown

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from spacecraft_gnc.vehicles.two_wheel.flight import WheelFlight
    from spacecraft_gnc.vehicles.two_wheel.resolved import Resolved

_OVERVIEW: Final = (6.3, 9.6)  # [inch]


class WheelFigures:
    """Implements `drawing.vehicle.VehicleFigures`."""

    def flight(self, run: Flown, *, title: str = "", error_scale: str = "log") -> dict[str, Maker]:
        """Return what draws each figure of one flight, by name."""
        draw = _diagrams(run, error_scale)
        return {
            "overview": partial(_overview, draw, title),
            "attitude": partial(stacked, DOUBLE, draw["error"], draw["euler"]),
            "rate": partial(stacked, SINGLE, draw["rate"]),
            "wheels": partial(stacked, DOUBLE, draw["speed"], draw["acceleration"]),
            "momentum": partial(stacked, SINGLE, draw["momentum"]),
        }

    def comparison(self, runs: Sequence[Flown], *, error_scale: str = "log") -> dict[str, Maker]:
        """Return what draws the figures of several flights over each other, by name."""
        return {
            "comparison_error": partial(
                stacked, SINGLE, partial(_errors, runs=runs, scale=error_scale)
            ),
            "comparison_wheels": partial(stacked, SINGLE, partial(_largest_speeds, runs=runs)),
        }

    def animate(self, runs: Sequence[Flown], path: Path, *, title: str = "") -> None:
        """Write a moving picture of flights side by side."""
        from spacecraft_gnc.vehicles.two_wheel.animation import save_animation

        save_animation(runs, path, title=title)


FIGURES: Final = WheelFigures()


def replay_figure(resolved: Resolved, names: tuple[str, str], title: str) -> Figure:
    """Return the commands as flown and as replayed, and their difference."""
    wheels = [f"wheel {i + 1}" for i in range(resolved.recorded.shape[1])]
    lines = partial(partial, _lines, times=resolved.times, names=wheels, unit="rad/s²")
    figure = stacked(
        _OVERVIEW,
        lines(values=resolved.recorded, title=f"As flown, {names[0]}"),
        lines(values=resolved.replayed, title=f"Replayed, {names[1]}"),
        lines(values=resolved.replayed - resolved.recorded, title="Difference"),
    )
    with style.applied():
        figure.suptitle(title, fontsize=12, fontweight="bold")
    return figure


def _diagrams(run: Flown, scale: str) -> dict[str, Draw]:
    """Return what draws each quantity of a flight into given axes."""
    flight, scenario, names = run.trajectory, run.scenario, series.wheel_names(run.trajectory)
    lines = partial(partial, _lines, times=run.times, marks=series.marks(flight))
    return {
        "error": partial(_errors, runs=[run], scale=scale),
        "euler": lines(
            values=series.euler_deg(flight), names=("roll", "pitch", "yaw"),
            title="Attitude, 3-2-1 Euler angles", unit="deg",
        ),
        "rate": lines(
            values=series.rate(flight), names="xyz", title="Rate of the bus, body frame",
            unit="rad/s",
        ),
        "speed": lines(
            values=series.wheel_speed(flight), names=names, title="Wheel speeds", unit="rad/s",
            bound=series.limit_of(scenario, "max_wheel_speed"),
        ),
        "acceleration": lines(
            values=held(flight.wheel_acceleration), names=names, title="Wheel accelerations",
            unit="rad/s²", bound=series.limit_of(scenario, "max_wheel_acceleration"),
            drawstyle="steps-post",
        ),
        "momentum": lines(
            values=held(flight.total_momentum), names="XYZ",
            title="Total momentum, inertial frame", unit="N m s",
        ),
    }  # fmt: skip


def _overview(draw: dict[str, Draw], title: str) -> Figure:
    names = ("error", "euler", "speed", "acceleration")
    figure = stacked(_OVERVIEW, *(draw[name] for name in names))
    if title:
        with style.applied():
            figure.suptitle(title, fontsize=12, fontweight="bold")
    return figure


def _lines(
    axes: Axes,
    times: Array,
    values: Array,
    names: Sequence[str],
    title: str,
    unit: str,
    bound: float = 0.0,
    marks: Sequence[Mark] = (),
    **line: Any,
) -> None:
    """Draw (n, m) values over time, and their limit on both sides where it is near."""
    for i, name in enumerate(names):
        axes.plot(times, values[:, i], label=name, **component(i % 4), **line)
    largest = float(np.nanmax(np.abs(values), initial=0.0))
    if bound and largest > 0.5 * bound:
        limit(axes, bound)
        limit(axes, -bound)
    draw_marks(axes, marks)
    legend(axes, min(len(names), 4))
    frame(axes, times, title, f"[{unit}]")


def _errors(axes: Axes, runs: Sequence[Flown], scale: str) -> None:
    """Draw the angle to the target of each flight."""
    _of_runs(axes, runs, series.error_deg, "Attitude error", "angle to the target [deg]")
    if scale == "log":
        logarithmic(axes, np.concatenate([series.error_deg(run.trajectory) for run in runs]))


def _largest_speeds(axes: Axes, runs: Sequence[Flown]) -> None:
    """Draw the speed of the fastest wheel of each flight."""
    _of_runs(axes, runs, _fastest, "Fastest wheel", "speed [rad/s]")


def _fastest(flight: WheelFlight) -> Array:
    return np.asarray(np.abs(series.wheel_speed(flight)).max(axis=1))


def _of_runs(
    axes: Axes,
    runs: Sequence[Flown],
    values: Callable[[WheelFlight], Array],
    title: str,
    label: str,
) -> None:
    for i, run in enumerate(runs):
        color = style.RUN_COLORS[i % len(style.RUN_COLORS)] if len(runs) > 1 else style.INK
        axes.plot(run.times, values(run.trajectory), color=color, label=run.name)
    longest = max(runs, key=lambda run: float(run.times[-1]))
    frame(axes, longest.times, title, label)
    if len(runs) > 1:
        legend_below(axes)
