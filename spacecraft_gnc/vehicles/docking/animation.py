"""Moving picture of docking flights: both bodies in space, their distance and the force."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from spacecraft_gnc.drawing import axes as parts
from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.moving import frame_times, require_few, write_gif
from spacecraft_gnc.drawing.side_by_side import Curve, SideBySide
from spacecraft_gnc.drawing.sphere import View
from spacecraft_gnc.vehicles.docking import flown as series
from spacecraft_gnc.vehicles.docking.flown import Flown
from spacecraft_gnc.vehicles.docking.limits import clearances, margins
from spacecraft_gnc.vehicles.docking.planes import draw_pair

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SPACES: Final = {"left": 0.01, "right": 0.99, "bottom": 0.42, "top": 0.9, "wspace": 0.02}
_CURVES: Final = {"left": 0.075, "right": 0.965, "bottom": 0.08, "top": 0.29, "wspace": 0.2}
_TO_COME: Final = 0.22  # opacity of what has not been flown yet
_WORDS: Final[dict[str, Any]] = {"ha": "center", "va": "center", "fontsize": 10.0}
_VIEW: Final = View(azimuth_deg=-62.0, elevation_deg=24.0)


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


class Scene(SideBySide[Flown]):
    """The picture of several flights side by side, at any time.

    Parameters
    ----------
    runs
        What is shown.
    title
        Heading.
    """

    def __init__(self, runs: Sequence[Flown], title: str = "") -> None:
        super().__init__(runs, title, **_SPACES)
        distances, *forces = self._row(1 + len(runs), **_CURVES)
        self._curves.append((distances, _distances(runs)))
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
        self.keep()

    def draw(self, axes: Axes, run: Flown, row: int) -> None:
        """Draw both bodies and how it stands."""
        draw_pair(axes, run, row, _VIEW)
        _tell(axes, run, row)


def _distances(runs: Sequence[Flown]) -> list[Curve]:
    """Return the curve of the distance of each flight."""
    colors = style.RUN_COLORS if len(runs) > 1 else (style.INK,)
    return [
        (run.times, series.distance(run.trajectory), {"color": color})
        for run, color in zip(runs, colors, strict=False)
    ]


def _forces(run: Flown) -> list[Curve]:
    """Return the curve of each component of the force."""
    components = series.force(run.trajectory).T
    line = {"drawstyle": "steps-post"}
    return [
        (run.times, values, {**parts.component(i), **line}) for i, values in enumerate(components)
    ]


def _still(axes: Axes, curves: Sequence[Curve], title: str) -> None:
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
