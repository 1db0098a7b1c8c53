"""Figures for print of flights in formation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.axes import frame, legend, legend_below, limit, logarithmic, positive
from spacecraft_gnc.drawing.figures import DOUBLE, Draw, Maker, stacked
from spacecraft_gnc.drawing.marks import draw_marks, draw_spans
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation import flown as series
from spacecraft_gnc.vehicles.formation.events import marks, spans
from spacecraft_gnc.vehicles.formation.flown import KM, Flown
from spacecraft_gnc.vehicles.formation.limits import all_separations, communication_angles
from spacecraft_gnc.vehicles.formation.planes import paths_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_OVERVIEW: Final = (6.3, 10.4)  # [inch]
_TRIPLE: Final = (6.3, 7.4)  # [inch]
_HELD: Final[dict[str, Any]] = {"drawstyle": "steps-post"}
_ROOM: Final = 1.12  # of an axis that has to show a limit
_SMALLEST: Final = 0.02  # of the error that counts as formed: the lowest one that has to be shown
_MOST_NAMES: Final = 6  # that fit beside a title


class FormationFigures:
    """Implements `drawing.vehicle.VehicleFigures`."""

    def flight(self, run: Flown, *, title: str = "", error_scale: str = "log") -> dict[str, Maker]:
        """Return what draws each figure of one flight, by name."""
        draw = _diagrams(run, error_scale)
        makers: dict[str, Maker] = {
            "overview": partial(_overview, draw, title),
            "constraints": partial(
                stacked, _TRIPLE, draw["separation"], draw["delta_v"], draw["angle"]
            ),
            "paths": partial(paths_figure, run),
            "error": partial(stacked, DOUBLE, draw["error"], draw["spent"]),
        }
        if series.governor_chose(run.trajectory):
            makers["shifts"] = partial(stacked, DOUBLE, draw["shifts"], draw["cost"])
            makers["governor"] = partial(
                stacked, _TRIPLE, draw["admissible"], draw["margin"], draw["time"]
            )
        return makers

    def comparison(self, runs: Sequence[Flown], *, error_scale: str = "log") -> dict[str, Maker]:
        """Return what draws the figures of several flights over each other, by name."""
        draw = partial(partial, _of_runs, runs=runs)
        return {
            "comparison_error": partial(
                stacked, DOUBLE,
                draw(values=series.farthest, label="[m]",
                     title="Distance of the farthest craft from its place", scale=error_scale),
                draw(values=lambda run: series.spent(run).sum(axis=1), label="[m/s]",
                     title="Delta-v spent by all craft", named=False),
            ),
            "comparison_constraints": partial(
                stacked, _TRIPLE,
                draw(values=lambda run: KM * series.nearest(run.trajectory), label="[km]",
                     title="Least separation", bound=_separation_limit),
                draw(values=lambda run: series.widest(series.delta_v(run.trajectory)),
                     label="[m/s]", title="Largest delta-v", bound=_delta_v_limit, named=False,
                     **_HELD),
                draw(values=lambda run: series.widest(communication_angles(run.trajectory)),
                     label="[deg]", title="Largest communication angle", bound=_angle_limit,
                     named=False),
            ),
        }  # fmt: skip

    def animate(self, runs: Sequence[Flown], path: Path, *, title: str = "") -> None:
        """Write a moving picture of flights side by side."""
        from spacecraft_gnc.vehicles.formation.animation import save_animation

        save_animation(runs, path, title=title)


FIGURES: Final = FormationFigures()


def _separation_limit(run: Flown) -> float:
    return KM * series.limit_of(run.scenario, "min_separation")


def _delta_v_limit(run: Flown) -> float:
    return series.limit_of(run.scenario, "max_delta_v")


def _angle_limit(run: Flown) -> float:
    return series.angle_limit(run.scenario)


def _diagrams(run: Flown, scale: str) -> dict[str, Draw]:
    """Return what draws each quantity of a flight into given axes."""
    flight = run.trajectory
    of_craft = partial(partial, _lines, run, series.craft_names(run), series.craft_color)
    of_pairs = partial(partial, _lines, run, series.pair_names(run), series.pair_color)
    of_all = partial(partial, _lines, run)
    formed = 0.0 if run.scenario is None else run.scenario.governor.formed_error
    return {
        "separation": of_pairs(
            values=KM * all_separations(flight), title="Separation", unit="km",
            bound=_separation_limit(run), kind="at least",
        ),
        "delta_v": of_craft(
            values=series.delta_v(flight), title="Size of delta-v", unit="m/s",
            bound=_delta_v_limit(run), **_HELD,
        ),
        "angle": of_pairs(
            values=communication_angles(flight), title="Communication angle", unit="deg",
            bound=_angle_limit(run),
        ),
        "error": partial(_error, run, scale=scale, formed=formed),
        "spent": of_craft(values=series.spent(run), title="Delta-v spent", unit="m/s"),
        "shifts": of_craft(
            values=series.shifts(flight), title="Time shift", unit="control steps", **_HELD
        ),
        "cost": of_all(
            ["W, of the shifts", "Omega, of errors and delta-v"],
            lambda i: (style.AXIS_COLORS[1], style.INK)[i],
            values=np.column_stack([flight.shift_cost, flight.state_cost]), title="Cost",
            unit="-", scale="log", **_HELD,
        ),
        "admissible": of_all(
            ["all", "admissible"],
            lambda i: (style.MUTED, style.AXIS_COLORS[0])[i],
            values=np.column_stack([flight.iterations, series.admissible(flight)]),
            title="Candidates", unit="-", scale="log", **_HELD,
        ),
        "margin": of_all(
            ["margin"], lambda _: style.INK, values=series.room_percent(flight)[:, None],
            title="Least room along the prediction", unit="% of the limit", **_HELD,
        ),
        "time": of_all(
            ["time"], lambda _: style.INK, values=1e3 * flight.solve_time[:, None],
            title="Time of the governor", unit="ms", scale="log",
        ),
    }  # fmt: skip


def _overview(draw: dict[str, Draw], title: str) -> Figure:
    names = ("separation", "delta_v", "angle", "shifts", "error")
    figure = stacked(_OVERVIEW, *(draw[name] for name in names))
    if title:
        with style.applied():
            figure.suptitle(title, fontsize=12, fontweight="bold")
    return figure


def _lines(
    run: Flown,
    names: Sequence[str],
    color: Callable[[int], str],
    axes: Axes,
    values: Array,
    title: str,
    unit: str,
    bound: float = 0.0,
    kind: str = "limit",
    scale: str = "linear",
    **line: Any,
) -> None:
    """Draw values (n, k) or (n + 1, k) over time with their limit, which is always seen."""
    for i, name in enumerate(names):
        dashes = style.COMPONENT_STYLES[i % len(style.COMPONENT_STYLES)]
        axes.plot(
            run.times[: len(values)], values[:, i], label=name, color=color(i), linestyle=dashes,
            **line,
        )  # fmt: skip
    if bound:
        limit(axes, bound)
        axes.set_ylim(0.0, _ROOM * max(bound, float(np.nanmax(values, initial=0.0))))
        _beside(axes, bound, f"{kind} {bound:g} {unit}", style.LIMIT_COLOR)
    if scale == "log":
        logarithmic(axes, values)
    draw_spans(axes, spans(run))
    draw_marks(axes, marks(run))
    if len(names) > 1:
        legend(axes, min(len(names), _MOST_NAMES))
    frame(axes, run.times, title, f"[{unit}]")


def _beside(axes: Axes, value: float, text: str, color: str) -> None:
    """Write what a line across the diagram means, above its right end."""
    axes.annotate(
        text, (1.0, value), xycoords=("axes fraction", "data"), xytext=(-2, 2), color=color,
        textcoords="offset points", ha="right", va="bottom", fontsize=7.5,
    )  # fmt: skip


def _error(run: Flown, axes: Axes, scale: str, formed: float) -> None:
    """Draw how far the craft are from their places, and below which distance they are formed."""
    values = series.errors(run)
    _lines(
        run, series.craft_names(run), series.craft_color, axes, values,
        "Distance from the commanded place", "m", scale=scale,
    )  # fmt: skip
    if scale == "log" and formed:
        lowest = max(_SMALLEST * formed, float(positive(values.ravel()).min(initial=np.inf)))
        axes.set_ylim(bottom=min(lowest, _SMALLEST * formed))
    if formed:
        axes.axhline(formed, color=style.AXIS_COLORS[2], linewidth=1.0, linestyle="--")
        _beside(axes, formed, f"formed: {formed:g} m", style.AXIS_COLORS[2])


def _of_runs(
    axes: Axes,
    runs: Sequence[Flown],
    values: Callable[[Flown], Array],
    title: str,
    label: str,
    scale: str = "linear",
    bound: Callable[[Flown], float] = lambda _: 0.0,
    named: bool = True,
    **line: Any,
) -> None:
    """Draw a value of each flight, and the limits of all of them."""
    drawn = [values(run) for run in runs]
    for i, (run, data) in enumerate(zip(runs, drawn, strict=True)):
        color = style.RUN_COLORS[i % len(style.RUN_COLORS)]
        axes.plot(
            run.times[: len(data)], data, color=color, label=run.name if named else None, **line
        )
    if scale == "log":
        logarithmic(axes, np.concatenate(drawn))
    for side in sorted({bound(run) for run in runs} - {0.0}):
        limit(axes, side)
        axes.set_ylim(bottom=0.0, top=max(axes.get_ylim()[1], _ROOM * side))
    longest = max(runs, key=lambda run: float(run.times[-1]))
    frame(axes, longest.times, title, label)
    if named:
        legend_below(axes)
