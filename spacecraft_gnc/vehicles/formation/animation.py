"""Moving picture of flights in formation: the orbital plane, separations and delta-v."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.ticker import MaxNLocator

from spacecraft_gnc.drawing import axes as parts
from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.chart import held
from spacecraft_gnc.drawing.moving import frame_times, require_few, write_gif
from spacecraft_gnc.drawing.side_by_side import SIZE, Curve, SideBySide
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation import flown as series
from spacecraft_gnc.vehicles.formation.events import events, standing, standing_name
from spacecraft_gnc.vehicles.formation.flown import KM, Flown
from spacecraft_gnc.vehicles.formation.geometry import pairs
from spacecraft_gnc.vehicles.formation.limits import all_separations
from spacecraft_gnc.vehicles.formation.planes import ALONG, RADIAL, draw_paths
from spacecraft_gnc.vehicles.formation.summary import length

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SPACES: Final = {"left": 0.06, "right": 0.985, "bottom": 0.46, "top": 0.9, "wspace": 0.12}
_CURVES: Final = {"left": 0.06, "right": 0.985, "bottom": 0.08, "top": 0.29, "wspace": 0.16}
_TO_COME: Final = 0.22  # opacity of what has not been flown yet
_TRAIL: Final = 25  # states before the one that is shown: half an orbit where it has fifty
_ROOM: Final = 1.1
_LEAST: Final = 1.35  # semi-axes of the ellipse that are always seen
_WORDS: Final[dict[str, Any]] = {"ha": "center", "va": "center", "fontsize": 9.0}


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
        seen = reach(runs)
        for i, (run, axes) in enumerate(zip(runs, self._spaces, strict=True)):
            _frame(axes, seen)
            if len(runs) > 1:
                color = style.RUN_COLORS[i]
                axes.set_title(run.name, color=color, fontsize=10.0, loc="center")
        self._spaces[0].set_ylabel("x radial [km]", labelpad=1.0)
        self._curves = self._diagrams()
        self.keep()

    def draw(self, axes: Axes, run: Flown, row: int) -> None:
        """Draw the craft with their trails, and how it stands."""
        _draw_links(axes, run, row)
        draw_paths(axes, run, row, max(row - _TRAIL, 0))
        _tell(axes, run, row)

    def _diagrams(self) -> list[tuple[Axes, list[Curve]]]:
        """Return the diagrams of all runs with their curves, drawn faintly."""
        apart, spent = self._row(2, **_CURVES)
        separations = _curves(self._runs, series.pair_color, _separations)
        delta_v = _curves(self._runs, series.craft_color, _delta_v)
        _still(apart, separations, "Least separation [km]" if self._is_compared else
               "Separation [km]")  # fmt: skip
        _still(spent, delta_v, "Largest delta-v [m/s]" if self._is_compared else "Delta-v [m/s]")
        for run in self._runs:
            for axes, name, factor in (
                (apart, "min_separation", KM), (spent, "max_delta_v", 1.0)
            ):  # fmt: skip
                if side := series.limit_of(run.scenario, name):
                    parts.limit(axes, factor * side)
            for event in events(run):
                color = style.LIMIT_COLOR if event.is_bad else style.INK
                for axes in (apart, spent):
                    axes.axvline(event.time, color=color, linewidth=0.9, linestyle=":")
        return [(apart, separations), (spent, delta_v)]

    @property
    def _is_compared(self) -> bool:
        return len(self._runs) > 1


def reach(runs: Sequence[Flown]) -> tuple[Array, Array]:
    """Return the least and the greatest position (3,) that has to be seen [km].

    A lost craft that drifts away is left out from its loss on.
    """
    points = [_LEAST * KM * series.ellipse(run.scenario) for run in runs]
    for run in runs:
        gone = held(series.concluded_lost(run.trajectory))
        seen = KM * series.positions(run.trajectory)[~gone]
        points.append(seen[np.isfinite(seen).all(axis=-1)])
    together = np.concatenate([*points, np.zeros((1, 3))])
    return together.min(axis=0), together.max(axis=0)


def _frame(axes: Axes, seen: tuple[Array, Array]) -> None:
    """Set the range of the picture to what has to be seen, with one scale along both axes."""
    low, high = seen
    box, (width, height) = axes.get_position(), SIZE
    shape = box.width * width / (box.height * height)
    middle, half = 0.5 * (low + high), 0.5 * _ROOM * (high - low)
    across = max(half[ALONG], shape * half[RADIAL])
    axes.set(
        xlim=(middle[ALONG] - across, middle[ALONG] + across),
        ylim=(middle[RADIAL] - across / shape, middle[RADIAL] + across / shape),
    )
    axes.set_xlabel("y along the track [km]", labelpad=1.0)


def _draw_links(axes: Axes, run: Flown, row: int) -> None:
    """Draw a line between the craft of each pair: red where a constraint is broken."""
    at, kept = KM * series.positions(run.trajectory)[row], series.pairs_kept(run)[row]
    for (first, second), is_kept in zip(pairs(len(at)).tolist(), kept.tolist(), strict=True):
        ends = at[[first, second]]
        color = style.MUTED if is_kept else style.LIMIT_COLOR
        axes.plot(ends[:, ALONG], ends[:, RADIAL], color=color, linewidth=0.8 if is_kept else 2.2,
                  alpha=0.7)  # fmt: skip


def _separations(run: Flown) -> Array:
    return KM * all_separations(run.trajectory)


def _delta_v(run: Flown) -> Array:
    return series.delta_v(run.trajectory)


def _curves(runs: Sequence[Flown], color: Any, values: Any) -> list[Curve]:
    """Return a curve of each column of one run, or of the worst one of each of several."""
    line = {"drawstyle": "steps-post"} if values is _delta_v else {}
    if len(runs) == 1:
        columns = values(runs[0]).T
        return [(runs[0].times, c, {"color": color(i), **line}) for i, c in enumerate(columns)]
    worst = series.widest if values is _delta_v else lambda v: -series.widest(-v)
    return [
        (run.times, worst(values(run)), {"color": style.RUN_COLORS[i], **line})
        for i, run in enumerate(runs)
    ]


def _still(axes: Axes, curves: Sequence[Curve], title: str) -> None:
    """Draw what is to come faintly, with the frame of the diagram."""
    for times, values, line in curves:
        axes.plot(times, values, alpha=_TO_COME, **line)
    axes.set_title(title, fontsize=9.0)
    axes.set_xlabel(parts.TIME_LABEL, labelpad=1.0)
    axes.set_xlim(0.0, max(times[-1] for times, _, _ in curves))
    axes.set_ylim(bottom=0.0)
    axes.xaxis.set_major_locator(MaxNLocator(5))


def _tell(axes: Axes, run: Flown, row: int) -> None:
    """Write how it stands, and what is broken or happened last."""
    apart = KM * series.nearest(run.trajectory)[row]
    away = series.farthest(run)[row]
    known = f"{apart:.3g} km apart, up to {length(away)} off" if np.isfinite(away) else ""
    axes.text(0.5, -0.2, known or "not recorded", transform=axes.transAxes, **_WORDS)
    axes.text(0.5, -0.27, _news(run, row), transform=axes.transAxes, color=style.LIMIT_COLOR,
              **_WORDS)  # fmt: skip


def _news(run: Flown, row: int) -> str:
    """Return which constraints are broken, or else what happened last."""
    flight, p = run.trajectory, run.scenario
    broken = []
    if p is not None:
        most = series.angle_limit(p)
        broken = [
            text
            for text, is_broken in (
                ("too close", series.nearest(flight)[row] < p.plant.min_separation),
                ("angle too large", most and series.widest(series.angles_deg(run))[row] > most),
                ("delta-v too large", series.widest(_delta_v(run))[row] > p.plant.max_delta_v),
            )
            if is_broken
        ]
    return ", ".join(broken) or _last(run, row)


def _last(run: Flown, row: int) -> str:
    """Return what happened last: an event, or the beginning of a deadlock or passage."""
    told = [(event.time, event.text) for event in events(run)]
    states = standing(run.trajectory).tolist()
    told += [
        (float(run.times[k + 1]), standing_name(after))
        for k, (before, after) in enumerate(pairwise(states))
        if after != before and standing_name(after) in ("deadlock", "passage")
    ]
    past = [(time, text) for time, text in sorted(told) if time <= run.times[row]]
    return f"{past[-1][0]:.0f} s: {past[-1][1]}" if past else ""
