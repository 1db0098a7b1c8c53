"""Moving picture of flights with wheels: the bus with its wheels, its error and their speeds."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from spacecraft_gnc.drawing import axes as parts
from spacecraft_gnc.drawing import sphere, style
from spacecraft_gnc.drawing.attitude_view import Rotors
from spacecraft_gnc.drawing.geometry import rim
from spacecraft_gnc.drawing.moving import drawn_over, frame_times, require_few, write_gif
from spacecraft_gnc.drawing.spacecraft import draw_spacecraft
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.two_wheel import flown as series
from spacecraft_gnc.vehicles.two_wheel.flown import Flown
from spacecraft_gnc.vehicles.two_wheel.summary import states

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SIZE: Final = (8.0, 6.4)  # [inch]
_DPI: Final = 100  # 800 pixels wide
_SPHERES: Final = {"left": 0.0, "right": 1.0, "bottom": 0.42, "top": 0.93, "wspace": 0.0}
_CURVES: Final = {"left": 0.075, "right": 0.965, "bottom": 0.08, "top": 0.29, "wspace": 0.2}
_TO_COME: Final = 0.22  # opacity of what has not been flown yet
_WORDS: Final[dict[str, Any]] = {"ha": "center", "va": "center", "fontsize": 10.0}
_BESIDE: Final = 2.5  # order of what lies inside the sphere: before its far, behind its near side


class AnimatedRun(NamedTuple):
    """One flight with n + 1 states."""

    name: str
    color: str
    times: Array
    """(n + 1,) [s]."""
    attitudes: Array
    """(n + 1, 3, 3), body to inertial."""
    targets: Array
    """(n + 1, 3, 3)."""
    error: Array
    """(n + 1,) [deg]."""
    speeds: Array
    """(n + 1, m) [rad/s]."""
    limit: float
    """[rad/s]; 0: none."""
    rotors: Rotors | None
    beliefs: list[str]
    """(n + 1,) how it is flown, in words."""
    events: list[series.Event]

    def row(self, time: float) -> int:
        """Return the row of the last state at a time [s]."""
        return max(int(np.searchsorted(self.times, time + 1e-9, side="right")) - 1, 0)


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
    shown = [animated_run(run, i) for i, run in enumerate(runs)]
    with style.applied():
        write_gif(Scene(shown, title).frame, frame_times(shown), path)


def animated_run(run: Flown, index: int) -> AnimatedRun:
    """Return what is shown of the flight that stands at a place, from 0."""
    flight = run.trajectory
    return AnimatedRun(
        run.name,
        style.RUN_COLORS[index],
        run.times,
        states(flight)[1],
        np.concatenate([flight.target, flight.target[-1:]]),
        series.error_deg(flight),
        series.wheel_speed(flight),
        series.limit_of(run.scenario, "max_wheel_speed"),
        series.rotors(run),
        series.beliefs(flight),
        series.events(flight),
    )


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
        self._runs, self._view = runs, sphere.View()
        self._figure = Figure(_SIZE, dpi=_DPI)
        self._canvas = FigureCanvasAgg(self._figure)
        self._write(0.02, title, ha="left", fontweight="bold")
        self._spheres = self._row(len(runs), **_SPHERES)
        errors, *speeds = self._row(1 + len(runs), **_CURVES)
        for run, axes in zip(runs, self._spheres, strict=True):
            sphere.draw_sphere(axes, self._view)
            if len(runs) > 1:
                axes.set_title(run.name, color=run.color, fontsize=10.0, loc="center")
        self._curves = [(errors, _errors_of(runs))]
        _still_errors(errors, runs)
        for run, axes in zip(runs, speeds, strict=True):
            self._curves.append((axes, _speeds_of(run)))
            _still_speeds(axes, run)
        self._canvas.draw()  # type: ignore[no-untyped-call]
        self._still = self._canvas.copy_from_bbox(self._figure.bbox)  # type: ignore[no-untyped-call]

    def frame(self, time: float) -> Array:
        """Return the picture (height, width, 3) at a time [s], 8 bits a color."""
        self._canvas.restore_region(self._still)  # type: ignore[no-untyped-call]
        for axes, run in zip(self._spheres, self._runs, strict=True):
            with drawn_over(axes):
                _draw_flight(axes, self._view, run, run.row(time))
        for axes, curves in self._curves:
            with drawn_over(axes):
                for run, values, line in curves:
                    row = run.row(time)
                    axes.plot(run.times[: row + 1], values[: row + 1], **line)
                    axes.plot(run.times[row], values[row], "o", markersize=4.0, color=line["color"])
        clock = self._write(0.98, f"t = {time:.1f} s", ha="right")
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


_Curves = list[tuple[AnimatedRun, Array, dict[str, Any]]]


def _errors_of(runs: Sequence[AnimatedRun]) -> _Curves:
    """Return the curve of the error of each flight."""
    return [(run, run.error, {"color": run.color}) for run in runs]


def _speeds_of(run: AnimatedRun) -> _Curves:
    """Return the curve of the speed of each wheel."""
    return [(run, speed, parts.component(i % 4)) for i, speed in enumerate(run.speeds.T)]


def _still(axes: Axes, curves: _Curves, title: str, draw: Callable[[], None]) -> None:
    for run, values, line in curves:
        axes.plot(run.times, values, alpha=_TO_COME, **line)
    axes.set_title(title, fontsize=9.0)
    axes.set_xlabel(parts.TIME_LABEL, labelpad=1.0)
    axes.set_xlim(0.0, max(run.times[-1] for run, _, _ in curves))
    draw()


def _still_errors(axes: Axes, runs: Sequence[AnimatedRun]) -> None:
    known = np.concatenate([run.error for run in runs])

    def scale() -> None:
        parts.logarithmic(axes, known)

    _still(axes, _errors_of(runs), "Error to the target [deg]", scale)


def _still_speeds(axes: Axes, run: AnimatedRun) -> None:
    def bounds() -> None:
        for side in (-run.limit, run.limit) if run.limit else ():
            parts.limit(axes, side)
        for event in run.events:
            color = style.LIMIT_COLOR if event.is_truth else style.INK
            axes.axvline(event.time, color=color, linewidth=0.9, linestyle=":")

    _still(axes, _speeds_of(run), "Wheel speeds [rad/s]", bounds)


def _draw_flight(axes: Axes, view: sphere.View, run: AnimatedRun, row: int) -> None:
    """Draw bus and wheels, where the body axes have pointed so far, and how it stands."""
    attitude = run.attitudes[row]
    known = bool(np.isfinite(attitude).all())
    for i, color in enumerate(style.AXIS_COLORS):
        path = run.attitudes[: row + 1, :, i]
        sphere.draw_curve(axes, view, path, color=color, linewidth=1.4)
        ((x, y),), (depth,) = view.project(run.targets[row, :, i][None])
        alpha = 1.0 if depth >= 0.0 else 2.0 * sphere.FAR_ALPHA
        axes.plot([x], [y], "D", markersize=5.0, markerfacecolor="none", markeredgecolor=color,
                  alpha=alpha, zorder=3.3)  # fmt: skip
        if known:
            sphere.draw_arrow(axes, view, path[-1], color=color, dashed=False)
    if known:
        draw_spacecraft(axes, view, attitude, np.eye(3)[0])
        for points, line in _wheels(run, row):
            picture, _ = view.project(points @ attitude.T)
            axes.plot(*picture.T, zorder=_BESIDE + 0.1, solid_capstyle="round", **line)
    error = f"{run.error[row]:.3g}° to the target" if known else "not recorded"
    axes.text(0.0, -1.20, error, **_WORDS)
    lost = any(event.time <= run.times[row] for event in run.events)
    axes.text(
        0.0, -1.36, run.beliefs[row], color=style.LIMIT_COLOR if lost else style.INK, **_WORDS
    )


def _wheels(run: AnimatedRun, row: int) -> Iterator[tuple[Array, dict[str, Any]]]:
    """Yield rim, arc as long as the speed, and cross of each wheel, (k, 3) in the body frame."""
    rotors = run.rotors
    if rotors is None:
        return
    for i in range(len(rotors.names)):
        points = rim(rotors.axes[:, i])
        color = style.COMPONENT_COLORS[i % 4] if rotors.healthy[row, i] else style.LIMIT_COLOR
        last, turning = len(points) - 1, float(rotors.turning[row, i])
        steps = round(last * min(abs(turning), 1.0)) if np.isfinite(turning) else 0
        yield points, {"color": color, "linewidth": 1.2}
        arc = points[last - steps :] if turning < 0.0 else points[: steps + 1]
        yield arc, {"color": color, "linewidth": 3.6}
        if not rotors.trusted[row, i]:
            for k in (0, last // 4):
                yield points[[k, k + last // 2]], {"color": style.LIMIT_COLOR, "linewidth": 1.8}
