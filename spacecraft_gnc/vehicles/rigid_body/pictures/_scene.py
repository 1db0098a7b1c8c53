"""Scene of an animation: a sphere with a spacecraft for each flight, curves of all below.

What stands still is drawn once; what moves is drawn over it frame by frame, with the functions that
draw the figures for print.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from spacecraft_gnc.drawing import sphere, style
from spacecraft_gnc.drawing.moving import drawn_over
from spacecraft_gnc.drawing.spacecraft import draw_spacecraft
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.pictures import motion as panels
from spacecraft_gnc.vehicles.rigid_body.pictures._curves import curves

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from spacecraft_gnc.vehicles.rigid_body.pictures._animated_run import AnimatedRun

_SIZE: Final = (8.0, 6.4)  # [inch]
_DPI: Final = 100  # 800 pixels wide
_SPHERES: Final = {"left": 0.0, "right": 1.0, "bottom": 0.40, "top": 0.935, "wspace": 0.0}
_CURVES: Final = {"left": 0.068, "right": 0.985, "bottom": 0.075, "top": 0.275, "wspace": 0.22}
_HEADING: Final = 0.965  # share of the height
_NAME: Final = 0.925  # share of the height
_STATE: Final[dict[str, Any]] = {"ha": "center", "va": "center", "fontsize": 10.0}
_MARKS: Final = "target ○\nreference of the governor ◇"


class Scene:
    """The picture of several flights side by side, at any time.

    Parameters
    ----------
    runs
        What is shown.
    title
        Heading.
    """

    def __init__(self, runs: Sequence[AnimatedRun], title: str = "") -> None:
        self._runs = runs
        self._view = _view(runs)
        self._figure = Figure(_SIZE, dpi=_DPI)
        self._canvas = FigureCanvasAgg(self._figure)
        self._write(0.02, title, ha="left", fontweight="bold")
        if any(run.references is not None for run in runs):
            self._figure.text(
                0.98, _NAME, _MARKS, ha="right", va="top", fontsize=8.5, color=style.MUTED
            )
        self._curves = list(curves(runs))
        self._spheres = self._row(len(runs), **_SPHERES)
        self._diagrams = self._row(len(self._curves), **_CURVES)
        for i, (axes, run) in enumerate(zip(self._spheres, runs, strict=True)):
            _draw_sky(axes, self._view, run)
            self._name(i, run)
        for axes, curve in zip(self._diagrams, self._curves, strict=True):
            curve.draw_still(axes)
        self._canvas.draw()  # type: ignore[no-untyped-call]
        self._still = self._canvas.copy_from_bbox(self._figure.bbox)  # type: ignore[no-untyped-call]

    def frame(self, time: float) -> Array:
        """Return the picture (height, width, 3) at a time [s], 8 bits a color."""
        self._canvas.restore_region(self._still)  # type: ignore[no-untyped-call]
        for axes, run in zip(self._spheres, self._runs, strict=True):
            with drawn_over(axes):
                _draw_flight(axes, self._view, run, run.row(time))
        for axes, curve in zip(self._diagrams, self._curves, strict=True):
            with drawn_over(axes):
                curve.draw_flown(axes, time)
        clock = self._write(0.98, f"t = {time:.1f} s", ha="right")
        self._figure.draw_artist(clock)
        clock.remove()
        picture = np.array(self._canvas.buffer_rgba())  # type: ignore[no-untyped-call]
        return np.asarray(picture[:, :, :3])

    def _row(self, count: int, **place: float) -> list[Axes]:
        """Return axes side by side."""
        grid = self._figure.add_gridspec(1, count, **place)
        return [self._figure.add_subplot(grid[0, i]) for i in range(count)]

    def _name(self, place: int, run: AnimatedRun) -> None:
        """Write the name of a flight in the corner beside its sphere."""
        self._figure.legend(
            handles=[Line2D([], [], linewidth=2.2, label=run.name, **run.line)],
            loc="upper left", bbox_to_anchor=(place / len(self._runs) + 0.01, _NAME),
            borderaxespad=0.0, fontsize=10.5,
        )  # fmt: skip

    def _write(self, x: float, text: str, **options: Any) -> Any:
        return self._figure.text(x, _HEADING, text, va="center", fontsize=11.0, **options)


def _view(runs: Sequence[AnimatedRun]) -> sphere.View:
    """Return a view of where the instruments look in flight."""
    middle = np.zeros(3)
    for run in runs:
        path = run.attitudes @ run.instruments[0]
        way = np.linalg.norm(np.diff(path, axis=0), axis=1)
        # A stretch counts by its length, not by the time spent on it.
        middle += np.nansum(way[:, None] * (path[1:] + path[:-1]), axis=0)
    x, y, z = middle / (np.linalg.norm(middle) or 1.0)
    if math.hypot(x, y) < 0.1:  # along z, or nowhere in particular
        return sphere.View()
    elevation = math.degrees(math.atan2(z, math.hypot(x, y)))
    return sphere.View(math.degrees(math.atan2(y, x)), min(max(elevation + 12.0, -50.0), 50.0))


def _draw_sky(axes: Axes, view: sphere.View, run: AnimatedRun) -> None:
    """Draw the sphere with the zones and their names."""
    sphere.draw_sphere(axes, view)
    panels.draw_zones(axes, view, run.zones)
    for zone in run.zones:
        ((x, y),), (depth,) = view.project(zone.inertial_axis[None])
        if depth > 0.0:
            length = np.linalg.norm(zone.inertial_axis)
            axes.text(
                x / length, y / length, zone.name, ha="center", va="center", fontsize=9.5,
                fontweight="bold", zorder=3.1,
            )  # fmt: skip


def _draw_flight(axes: Axes, view: sphere.View, run: AnimatedRun, row: int) -> None:
    """Draw the spacecraft, where its instruments have looked so far, and how it stands."""
    attitude = run.attitudes[row]
    known = bool(np.isfinite(attitude).all())
    for instrument, violated in zip(run.instruments, run.violated, strict=True):
        path = run.attitudes[: row + 1] @ instrument
        sphere.draw_curve(axes, view, path, color=run.line["color"], linewidth=2.0)
        barred = np.where(violated[: row + 1, None], path, math.nan)
        sphere.draw_curve(axes, view, barred, color=style.LIMIT_COLOR, linewidth=4.0)
        _mark(axes, view, run.targets[row] @ instrument, "o", "none")
        if run.references is not None:
            _mark(axes, view, run.references[row] @ instrument, "D", "white")
        if known:
            color = style.LIMIT_COLOR if violated[row] else style.INK
            sphere.draw_arrow(axes, view, path[-1], color=color, dashed=False)
    if known:
        draw_spacecraft(axes, view, attitude, run.instruments[0])
    error = f"{run.error[row]:.2f}° to the target" if known else "not recorded"
    axes.text(0.0, -1.17, error, **_STATE)
    _write_worst(axes, run, row)


def _mark(axes: Axes, view: sphere.View, point: Array, marker: str, fill: str) -> None:
    """Mark a point (3,) of the sphere."""
    if not np.isfinite(point).all():
        return
    ((x, y),), (depth,) = view.project(point[None])
    size = 9.0 if marker == "o" else 6.0
    axes.plot(
        [x], [y], marker, markersize=size, markerfacecolor=fill, markeredgecolor=style.INK,
        alpha=1.0 if depth >= 0.0 else 2.0 * sphere.FAR_ALPHA, zorder=3.3,
    )  # fmt: skip


def _write_worst(axes: Axes, run: AnimatedRun, row: int) -> None:
    """Write how well the zones were kept so far."""
    worst = run.worst(row)
    if worst is None:
        return
    margin, zone = worst
    if margin < 0.0:
        text = f"✕ zone {zone} violated by {-margin:.1f}°"
        axes.text(0.0, -1.32, text, color=style.LIMIT_COLOR, fontweight="bold", **_STATE)
    else:
        axes.text(0.0, -1.32, f"✓ zones kept by {margin:.1f}° or more", **_STATE)
