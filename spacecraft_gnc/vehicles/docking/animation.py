"""Moving picture of docking flights: both bodies in space, their distance and the force."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from spacecraft_gnc.drawing import axes as parts
from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.moving import drawn_over, frame_times, require_few, write_gif
from spacecraft_gnc.drawing.sphere import View
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking import flown as series
from spacecraft_gnc.vehicles.docking.flown import Flown
from spacecraft_gnc.vehicles.docking.limits import clearances, margins
from spacecraft_gnc.vehicles.docking.planes import draw_pair

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SIZE: Final = (8.0, 6.4)  # [inch]
_DPI: Final = 100  # 800 pixels wide
_SPACES: Final = {"left": 0.01, "right": 0.99, "bottom": 0.42, "top": 0.9, "wspace": 0.02}
_CURVES: Final = {"left": 0.075, "right": 0.965, "bottom": 0.08, "top": 0.29, "wspace": 0.2}
_TO_COME: Final = 0.22  # opacity of what has not been flown yet
_WORDS: Final[dict[str, Any]] = {"ha": "center", "va": "center", "fontsize": 10.0}
_VIEW: Final = View(azimuth_deg=-62.0, elevation_deg=24.0)
_Curve = tuple[Array, Array, dict[str, Any]]


def save_animation(runs: Sequence[Flown], path: Path, *, title: str = "") -> None:
    """Write the moving picture of flights side by side, three at the most.

    Raises
    ------
    ParameterError
        If there are more flights.
    RecordingError
        If the file cannot be written; nothing is left then.
    """
    require_few(runs)
    with style.applied():
        write_gif(Scene(runs, title).frame, frame_times(runs), path)


class Scene:
    """The picture of several flights side by side, at any time.

    Parameters
    ----------
    runs
        What is shown.
    title
        Heading.
    """

    def __init__(self, runs: Sequence[Flown], title: str = "") -> None:
        self._runs = runs
        self._figure = Figure(_SIZE, dpi=_DPI)
        self._canvas = FigureCanvasAgg(self._figure)
        self._write(0.02, title, ha="left", fontweight="bold")
        self._spaces = self._row(len(runs), **_SPACES)
        distances, *forces = self._row(1 + len(runs), **_CURVES)
        self._curves: list[tuple[Axes, list[_Curve]]] = [(distances, _distances(runs))]
        for axes in self._spaces:
            axes.set_axis_off()
        for run, axes in zip(runs, self._spaces, strict=True):
            if len(runs) > 1:
                color = style.RUN_COLORS[self._runs.index(run)]
                axes.set_title(run.name, color=color, fontsize=10.0, loc="center")
        _still(distances, self._curves[0][1], "Distance of the ports [m]")
        parts.logarithmic(distances, np.concatenate([curve[1] for curve in self._curves[0][1]]))
        for run, axes in zip(runs, forces, strict=True):
            curves = _forces(run)
            self._curves.append((axes, curves))
            _still(axes, curves, "Force [N]")
            for side in (-1.0, 1.0):
                if most := series.limit_of(run.scenario, "max_force"):
                    parts.limit(axes, side * most)
            for event in series.events(run.trajectory):
                color = style.LIMIT_COLOR if event.is_bad else style.INK
                axes.axvline(event.time, color=color, linewidth=0.9, linestyle=":")
        self._canvas.draw()  # type: ignore[no-untyped-call]
        self._still = self._canvas.copy_from_bbox(self._figure.bbox)  # type: ignore[no-untyped-call]

    def frame(self, time: float) -> Array:
        """Return the picture (height, width, 3) at a time [s], 8 bits a color."""
        self._canvas.restore_region(self._still)  # type: ignore[no-untyped-call]
        for axes, run in zip(self._spaces, self._runs, strict=True):
            with drawn_over(axes):
                draw_pair(axes, run, _row_at(run.times, time), _VIEW)
                _tell(axes, run, _row_at(run.times, time))
        for axes, curves in self._curves:
            with drawn_over(axes):
                for times, values, line in curves:
                    row = _row_at(times, time)
                    axes.plot(times[: row + 1], values[: row + 1], **line)
                    axes.plot(times[row], values[row], "o", markersize=4.0, color=line["color"])
        clock = self._write(0.98, f"t = {time:.0f} s", ha="right")
        self._figure.draw_artist(clock)
        clock.remove()
        picture = np.array(self._canvas.buffer_rgba())  # type: ignore[no-untyped-call]
        return np.asarray(picture[:, :, :3])

    def _row(self, count: int, **place: float) -> list[Axes]:
        """Return axes side by side."""
        grid = self._figure.add_gridspec(1, count, **place)
        return [self._figure.add_subplot(grid[0, i]) for i in range(count)]

    def _write(self, x: float, text: str, **options: Any) -> Any:
        return self._figure.text(x, 0.965, text, va="center", fontsize=11.0, **options)


def _row_at(times: Array, time: float) -> int:
    """Return the row of the last state at a time [s]."""
    return max(int(np.searchsorted(times, time + 1e-9, side="right")) - 1, 0)


def _distances(runs: Sequence[Flown]) -> list[_Curve]:
    """Return the curve of the distance of each flight."""
    colors = style.RUN_COLORS if len(runs) > 1 else (style.INK,)
    return [
        (run.times, series.distance(run.trajectory), {"color": color})
        for run, color in zip(runs, colors, strict=False)
    ]


def _forces(run: Flown) -> list[_Curve]:
    """Return the curve of each component of the force."""
    components = series.force(run.trajectory).T
    line = {"drawstyle": "steps-post"}
    return [
        (run.times, values, {**parts.component(i), **line}) for i, values in enumerate(components)
    ]


def _still(axes: Axes, curves: Sequence[_Curve], title: str) -> None:
    """Draw what is to come faintly, with the frame of the diagram."""
    for times, values, line in curves:
        axes.plot(times, values, alpha=_TO_COME, **line)
    axes.set_title(title, fontsize=9.0)
    axes.set_xlabel(parts.TIME_LABEL, labelpad=1.0)
    axes.set_xlim(0.0, max(times[-1] for times, _, _ in curves))


def _tell(axes: Axes, run: Flown, row: int) -> None:
    """Write how it stands, and what happened last."""
    apart = series.distance(run.trajectory)[row]
    angle = series.angle_deg(run.trajectory)[row]
    text = f"{apart:.3g} m, {angle:.3g}°" if np.isfinite(apart) else "not recorded"
    axes.text(0.5, -0.03, text, transform=axes.transAxes, **_WORDS)
    axes.text(0.5, -0.10, _news(run, row), transform=axes.transAxes, color=style.LIMIT_COLOR,
              **_WORDS)  # fmt: skip


def _news(run: Flown, row: int) -> str:
    """Return which constraints are broken, or else what happened last."""
    tolerance = series.limit_of(run.scenario, "clearance_tolerance")
    broken = [
        text
        for text, margin, least in (
            ("out of the line of sight", margins(run.trajectory)[row], 0.0),
            ("beyond the docking face", clearances(run.trajectory)[row], -tolerance),
        )
        if margin < least
    ]
    past = [event for event in series.events(run.trajectory) if event.time <= run.times[row]]
    last = f"{past[-1].time:g} s: {past[-1].text}" if past else ""
    return ", ".join(broken) or last
