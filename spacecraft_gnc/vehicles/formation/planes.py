"""Figures of the paths of the craft, seen along an axis of Hill's frame."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.figure import Figure

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.axes import legend_below
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation import flown as series
from spacecraft_gnc.vehicles.formation.flown import KM, Flown

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ALONG, RADIAL = 1, 0
"""Axes of the picture: across it along the track, up the radial direction."""
_SIZE: Final = (6.3, 6.8)  # [inch]
_CLOSE: Final = 1.45  # semi-axes of the ellipse that the closer view shows
_BACKED: Final = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5}
_SMALL: Final[dict[str, Any]] = {"fontsize": 7.5, "textcoords": "offset points"}


def paths_figure(run: Flown) -> Figure:
    """Return the paths in the orbital plane: the whole flight, and close around the ellipse."""
    with style.applied():
        if run.scenario is None:
            figure = Figure((_SIZE[0], 0.6 * _SIZE[1]), layout="constrained")
            views = [figure.subplots()]
        else:
            figure = Figure(_SIZE, layout="constrained")
            views = list(figure.subplots(2, 1, height_ratios=(1.0, 1.15)))
            _close_up(views[1], run)
        draw_paths(views[0], run, len(run.times) - 1)
        _label(views[0], "Paths in the orbital plane, Hill's frame")
        views[0].set_aspect("equal", adjustable="datalim")
        _key(views[0])
        legend_below(views[0])
        return figure


def _close_up(axes: Axes, run: Flown) -> None:
    """Draw the surroundings of the natural ellipse."""
    draw_paths(axes, run, len(run.times) - 1, named=False)
    closest = KM * np.abs(series.ellipse(run.scenario)).max(axis=0)
    half = _CLOSE * closest
    axes.set(xlim=(-half[ALONG], half[ALONG]), ylim=(-half[RADIAL], half[RADIAL]))
    axes.set_aspect("equal", adjustable="box")
    _label(axes, "Around the natural ellipse")


def _label(axes: Axes, title: str) -> None:
    axes.set(title=title, xlabel="y along the track [km]", ylabel="x radial [km]")


def draw_paths(axes: Axes, run: Flown, row: int, since: int = 0, *, named: bool = True) -> None:
    """Draw the ellipse, the paths up to a state, and where the craft are and are to be then.

    Parameters
    ----------
    row
        The state.
    since
        The state at which the paths begin.
    named
        Whether a legend is to name them.
    """
    draw_ellipse(axes, run, named=named)
    flight = run.trajectory
    at, places = KM * series.positions(flight), KM * series.held_places(run)
    for i, name in enumerate(series.craft_names(run)):
        color = series.craft_color(i)
        path = at[since : row + 1, i]
        axes.plot(path[:, ALONG], path[:, RADIAL], color=color, linewidth=1.1,
                  label=name if named else None)  # fmt: skip
        if since == 0:
            axes.plot(*_point(at[0, i]), "o", color=color, markersize=4.5, markerfacecolor="white")
        axes.plot(*_point(places[row, i]), "D", color=color, markersize=6.5, markerfacecolor="none",
                  markeredgewidth=1.0)  # fmt: skip
        axes.plot(*_point(at[row, i]), "o", color=color, markersize=4.5, markeredgecolor="white",
                  markeredgewidth=0.6, zorder=4.0)  # fmt: skip
        gone = np.flatnonzero(~flight.healthy[: row + 1, i])
        if gone.size and since <= gone[0]:
            _cross(axes, at[gone[0], i], f"{name} lost")


def draw_ellipse(axes: Axes, run: Flown, *, named: bool = True) -> None:
    """Draw the natural ellipse where it is known, and the origin."""
    ring = KM * series.ellipse(run.scenario)
    if len(ring):
        axes.plot(ring[:, ALONG], ring[:, RADIAL], color=series.ELLIPSE_COLOR, linewidth=1.1,
                  linestyle=(0, (4, 2)), label="natural ellipse" if named else None)  # fmt: skip
    axes.plot(0.0, 0.0, "+", color=style.MUTED, markersize=6.0)


def _point(position: Array) -> tuple[float, float]:
    return float(position[ALONG]), float(position[RADIAL])


def _cross(axes: Axes, position: Array, text: str) -> None:
    axes.plot(*_point(position), "x", color=style.LIMIT_COLOR, markersize=6.0, markeredgewidth=1.6,
              zorder=4.5)  # fmt: skip
    axes.annotate(text, _point(position), xytext=(5, 4), color=style.LIMIT_COLOR,
                  annotation_clip=True, bbox=_BACKED, **_SMALL)  # fmt: skip


def _key(axes: Axes) -> None:
    """Say what the marks mean."""
    for marker, face, text in (
        ("o", "white", "start"),
        ("o", style.INK, "end"),
        ("D", "none", "commanded place at the end"),
    ):
        axes.plot([], [], marker, color=style.INK, markerfacecolor=face, markersize=5.0, label=text)
