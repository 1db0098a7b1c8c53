"""Figures for print of docking flights."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.axes import (
    component,
    frame,
    legend,
    legend_below,
    limit,
    logarithmic,
    positive,
)
from spacecraft_gnc.drawing.figures import DOUBLE, SINGLE, Draw, Maker, stacked
from spacecraft_gnc.drawing.marks import Mark, draw_marks
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking import flown as series
from spacecraft_gnc.vehicles.docking.flown import Flown
from spacecraft_gnc.vehicles.docking.limits import clearances, margins
from spacecraft_gnc.vehicles.docking.metrics import DOCKED_ANGLE, DOCKED_OFFSET
from spacecraft_gnc.vehicles.docking.planes import approach_figure, snapshots_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from spacecraft_gnc.vehicles.docking.flight import DockingFlight

_OVERVIEW: Final = (6.3, 10.4)  # [inch]
_NEAR: Final = 0.05  # [m] within which margins are drawn to a linear scale
_LEAST: Final = 0.02  # of what is docked: the lowest value that is drawn
_HELD: Final[dict[str, Any]] = {"drawstyle": "steps-post"}


class DockingFigures:
    """Implements `drawing.vehicle.VehicleFigures`."""

    def flight(self, run: Flown, *, title: str = "", error_scale: str = "log") -> dict[str, Maker]:
        """Return what draws each figure of one flight, by name."""
        draw = _diagrams(run, error_scale)
        makers: dict[str, Maker] = {
            "overview": partial(_overview, draw, title),
            "offset": partial(stacked, DOUBLE, draw["distance"], draw["offset"]),
            "attitude": partial(stacked, DOUBLE, draw["angle"], draw["rotation"]),
            "wrench": partial(stacked, DOUBLE, draw["force"], draw["moment"]),
            "reference": partial(stacked, DOUBLE, draw["references"], draw["rotations"]),
            "constraints": partial(stacked, SINGLE, draw["margins"]),
        }
        if np.isfinite(run.trajectory.residual).any():
            makers["governor"] = partial(stacked, DOUBLE, draw["short"], draw["time"])
        makers["approach"] = partial(approach_figure, run)
        if run.scenario is not None:
            makers["snapshots"] = partial(snapshots_figure, run)
        return makers

    def comparison(self, runs: Sequence[Flown], *, error_scale: str = "log") -> dict[str, Maker]:
        """Return what draws the figures of several flights over each other, by name."""
        draw = partial(partial, _of_runs, runs=runs)
        return {
            "comparison_error": partial(
                stacked, DOUBLE,
                draw(values=series.distance, title="Distance of the ports", label="[m]",
                     scale=error_scale),
                draw(values=series.angle_deg, title="Angle between the bodies", label="[deg]",
                     scale=error_scale, named=False),
            ),
            "comparison_wrench": partial(
                stacked, DOUBLE,
                draw(values=_largest_force, title="Largest component of the force", label="[N]",
                     bound="max_force", **_HELD),
                draw(values=_largest_moment, title="Largest component of the moment",
                     label="[N m]", bound="max_moment", named=False, **_HELD),
            ),
            "comparison_constraints": partial(
                stacked, DOUBLE,
                draw(values=margins, title="Line-of-sight margin", label="[m]", scale="margin"),
                draw(values=clearances, title="Clearance", label="[m]", scale="margin",
                     named=False),
            ),
        }  # fmt: skip

    def animate(self, runs: Sequence[Flown], path: Path, *, title: str = "") -> None:
        """Write a moving picture of flights side by side."""
        from spacecraft_gnc.vehicles.docking.animation import save_animation

        save_animation(runs, path, title=title)


FIGURES: Final = DockingFigures()


def _diagrams(run: Flown, scale: str) -> dict[str, Draw]:
    """Return what draws each quantity of a flight into given axes."""
    flight, scenario = run.trajectory, run.scenario
    lines = partial(partial, _lines, times=run.times, marks=series.marks(flight))
    bound = partial(series.limit_of, scenario)
    governor = partial(partial, _one, times=run.times[:-1], marks=series.marks(flight))
    return {
        "distance": partial(
            _one, times=run.times, values=series.distance(flight), title="Distance of the ports",
            unit="m", scale=scale, docked=DOCKED_OFFSET, marks=series.marks(flight),
        ),
        "angle": partial(
            _one, times=run.times, values=series.angle_deg(flight), scale=scale, unit="deg",
            title="Angle between deputy and chief", docked=float(np.degrees(DOCKED_ANGLE)),
            marks=series.marks(flight),
        ),
        "offset": lines(
            values=series.offset(flight), title="Port offset, chief frame", unit="m"
        ),
        "rotation": lines(
            values=series.rotation_deg(flight), title="Rotation vector, deputy to chief",
            unit="deg",
        ),
        "force": lines(
            values=series.force(flight), title="Force, chief frame", unit="N",
            bound=bound("max_force"), **_HELD,
        ),
        "moment": lines(
            values=series.moment(flight), title="Moment, chief frame", unit="N m",
            bound=bound("max_moment"), **_HELD,
        ),
        "references": partial(
            _commands, times=run.times, flown=series.offset(flight), unit="m",
            asked=series.reference_offset(flight), title="Port offset",
        ),
        "rotations": partial(
            _commands, times=run.times, flown=series.rotation_deg(flight), unit="deg",
            asked=series.reference_deg(flight), title="Rotation vector",
        ),
        "margins": partial(_margins, run=run),
        "short": governor(
            values=series.short_of_target(flight), unit="m",
            title="Port offset of the reference less that of the target",
        ),
        "time": governor(
            values=1e3 * flight.solve_time, title="Time of the governor", unit="ms",
        ),
    }  # fmt: skip


def _overview(draw: dict[str, Draw], title: str) -> Figure:
    names = ("distance", "angle", "force", "moment", "margins")
    figure = stacked(_OVERVIEW, *(draw[name] for name in names))
    if title:
        with style.applied():
            figure.suptitle(title, fontsize=12, fontweight="bold")
    return figure


def _lines(
    axes: Axes,
    times: Array,
    values: Array,
    title: str,
    unit: str,
    bound: float = 0.0,
    marks: Sequence[Mark] = (),
    **line: Any,
) -> None:
    """Draw (n, 3) values over time, and their limit: as lines where it is near, in words always."""
    for i, name in enumerate("xyz"):
        axes.plot(times, values[:, i], label=name, **component(i), **line)
    _bounds(axes, values, bound)
    draw_marks(axes, marks)
    legend(axes, 3)
    said = f"{title}, limit {bound:g} {unit}" if bound else title
    frame(axes, times, said, f"[{unit}]")


def _bounds(axes: Axes, values: Array, bound: float) -> None:
    """Draw a limit on both sides where values come near it on one."""
    if bound and np.abs(values[np.isfinite(values)]).max(initial=0.0) > 0.5 * bound:
        for side in (1.0, -1.0):
            limit(axes, side * bound)


def _one(
    axes: Axes,
    times: Array,
    values: Array,
    title: str,
    unit: str,
    scale: str = "linear",
    docked: float = 0.0,
    marks: Sequence[Mark] = (),
) -> None:
    """Draw (n,) values, and below which one it is docked."""
    axes.plot(times, values, color=style.INK)
    if scale == "log":
        logarithmic(axes, values)
        lowest = max(_LEAST * docked, float(positive(values).min(initial=np.inf)))
        axes.set_ylim(bottom=min(lowest, 0.5 * docked))
    if docked:
        axes.axhline(docked, color=style.AXIS_COLORS[2], linewidth=1.0, linestyle="--")
        axes.annotate(
            f"docked: {docked:g} {unit}", (1.0, docked), xycoords=("axes fraction", "data"),
            xytext=(-2, 2), textcoords="offset points", ha="right", va="bottom", fontsize=7.5,
            color=style.AXIS_COLORS[2],
        )  # fmt: skip
    draw_marks(axes, marks)
    frame(axes, times, title, f"[{unit}]")


def _commands(axes: Axes, times: Array, flown: Array, asked: Array, title: str, unit: str) -> None:
    """Draw what was flown (n, 3), and faint behind it the reference (n, 3)."""
    for i, name in enumerate("xyz"):
        color = style.COMPONENT_COLORS[i]
        axes.plot(times, flown[:, i], label=name, color=color)
        axes.plot(times, asked[:, i], color=color, linestyle=(0, (3, 1.5)), linewidth=1.1, **_HELD)
    axes.plot([], [], color=style.INK, linestyle=(0, (3, 1.5)), linewidth=1.1, label="reference")
    legend(axes, 4)
    frame(axes, times, title, f"[{unit}]")


def _margins(axes: Axes, run: Flown) -> None:
    """Draw line-of-sight margin and clearance, and how far down each may go."""
    flight, tolerance = run.trajectory, series.limit_of(run.scenario, "clearance_tolerance")
    colors = style.AXIS_COLORS[2], style.AXIS_COLORS[0]
    for (name, values), color in zip(
        (("line of sight", margins(flight)), ("clearance", clearances(flight))), colors, strict=True
    ):
        axes.plot(run.times, values, label=name, color=color)
    axes.axhspan(-1e3, -tolerance, color=style.LIMIT_COLOR, alpha=0.10, linewidth=0.0)
    axes.axhline(0.0, color=colors[0], linewidth=1.0, linestyle="--")
    if run.scenario is not None:
        axes.axhline(-tolerance, color=colors[1], linewidth=1.0, linestyle="--")
    _margin_scale(axes, np.append(margins(flight), clearances(flight)))
    draw_marks(axes, series.marks(flight))
    legend(axes, 2)
    frame(axes, run.times, "Margins, between the steps too", "[m]")


def _margin_scale(axes: Axes, values: Array) -> None:
    """Scale the axis so that both 20 m and 1 cm can be read."""
    known = values[np.isfinite(values)]
    axes.set_yscale("symlog", linthresh=_NEAR, linscale=0.6)
    low = min(float(known.min(initial=0.0)) * 1.5, -_NEAR)
    axes.set_ylim(low, 1.5 * max(float(known.max(initial=_NEAR)), _NEAR))
    decades = [0.1, 1.0, 10.0, 100.0]
    ticks = [-_NEAR, 0.0, _NEAR, *decades, *(-d for d in decades)]
    axes.set_yticks([tick for tick in ticks if low <= tick <= axes.get_ylim()[1]])
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")


def _least(run: Flown, values: Callable[[DockingFlight], Array]) -> float:
    """Return how small line-of-sight margins or clearances may be [m]."""
    return -series.limit_of(run.scenario, "clearance_tolerance") if values is clearances else 0.0


def _largest_force(flight: DockingFlight) -> Array:
    return np.asarray(np.abs(series.force(flight)).max(axis=1))


def _largest_moment(flight: DockingFlight) -> Array:
    return np.asarray(np.abs(series.moment(flight)).max(axis=1))


def _of_runs(
    axes: Axes,
    runs: Sequence[Flown],
    values: Callable[[DockingFlight], Array],
    title: str,
    label: str,
    scale: str = "linear",
    bound: str = "",
    named: bool = True,
    **line: Any,
) -> None:
    """Draw a value of each flight; ``bound``: name of its limit in the plant."""
    drawn = [values(run.trajectory) for run in runs]
    for i, (run, data) in enumerate(zip(runs, drawn, strict=True)):
        color = style.RUN_COLORS[i % len(style.RUN_COLORS)]
        axes.plot(run.times, data, color=color, label=run.name if named else None, **line)
    if scale == "log":
        logarithmic(axes, np.concatenate(drawn))
    elif scale == "margin":
        _margin_scale(axes, np.concatenate(drawn))
        for least in {_least(run, values) for run in runs}:
            limit(axes, least)
    for most in sorted({series.limit_of(run.scenario, bound) for run in runs} if bound else ()):
        limit(axes, most)
    longest = max(runs, key=lambda run: float(run.times[-1]))
    frame(axes, longest.times, title, label)
    if named:
        legend_below(axes)
