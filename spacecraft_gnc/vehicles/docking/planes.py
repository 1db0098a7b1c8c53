"""Figures of an approach: seen along two axes of the chief, and snapshots in space."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.figure import Figure

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.axes import legend
from spacecraft_gnc.drawing.solids import Body, draw_bodies, draw_edges, outline
from spacecraft_gnc.drawing.sphere import View
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking import flown as series
from spacecraft_gnc.vehicles.docking.flown import Flown

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_PLANES: Final = ((0, 1), (0, 2))
_SIZE: Final = (6.3, 6.6)  # [inch]
_WIDE: Final = 6.3  # [inch]
_VIEW: Final = View(azimuth_deg=-62.0, elevation_deg=24.0)
_COLUMNS: Final = 2
_NEAR: Final = 2.2  # [m] of what is drawn around a docked pair


def approach_figure(run: Flown) -> Figure:
    """Return the approach in the x-y and the x-z plane of the chief frame."""
    with style.applied():
        figure = Figure(_SIZE, layout="constrained")
        for axes, plane in zip(figure.subplots(2, 1, sharex=True), _PLANES, strict=True):
            _draw_plane(axes, run, plane)
            axes.set_ylabel(f"{'xyz'[plane[1]]} [m]")
        axes.set_xlabel("x [m], chief frame")
        top = figure.axes[0]
        top.set_title("Approach, chief frame")
        legend(top, 4)
        return figure


def _draw_plane(axes: Axes, run: Flown, plane: tuple[int, int]) -> None:
    path, reference = series.port_path(run), _reference_path(run)
    axes.plot(*path[:, plane].T, color=series.DEPUTY_COLOR, label="deputy's port")
    axes.plot(
        *reference[:, plane].T, color=style.AXIS_COLORS[1], linewidth=1.0, linestyle=(0, (3, 1.5)),
        label="reference",
    )  # fmt: skip
    if run.scenario is not None:
        region = series.sight(run.scenario.plant, series.reach(run))
        shape = outline(region, plane)
        axes.fill(*shape.T, color=series.SIGHT_COLOR, alpha=0.08, linewidth=0.0)
        axes.plot(*shape.T, color=series.SIGHT_COLOR, linewidth=0.9, label="line of sight")
    for body in series.bodies(run):
        rows = [0] if body.name == "chief" else series.snapshot_rows(run)
        _outlines(axes, body, rows, plane)
    axes.plot(*path[series.snapshot_rows(run)][:, plane].T, "o", color=series.DEPUTY_COLOR,
              markersize=3.0)  # fmt: skip
    axes.set_aspect("equal", adjustable="datalim")


def _outlines(axes: Axes, body: Body, rows: list[int], plane: tuple[int, int]) -> None:
    """Draw the outline of a body in some states."""
    for row in rows:
        if body.is_known(row):
            shape = outline(body.corners(row), plane)
            axes.fill(*shape.T, facecolor=body.color, alpha=0.35, linewidth=0.0)
            axes.plot(*shape.T, color=style.INK, linewidth=0.7)


def _reference_path(run: Flown) -> Array:
    """Return the path (n + 1, 3) of the reference in the chief frame [m]."""
    port = np.zeros(3) if run.scenario is None else run.scenario.plant.chief_port
    return np.asarray(port + series.reference_offset(run.trajectory))


def snapshots_figure(run: Flown) -> Figure:
    """Return the two bodies every `flown.SNAPSHOT` seconds, seen along one direction (figure 6)."""
    rows = series.snapshot_rows(run)
    lines = -(-len(rows) // _COLUMNS)
    with style.applied():
        figure = Figure((_WIDE, 0.4 + 2.4 * lines), layout="constrained")
        grid = figure.subplots(lines, _COLUMNS, squeeze=False).ravel()
        for axes, row in zip(grid, rows, strict=False):
            draw_pair(axes, run, row, _VIEW)
            axes.set_title(f"t = {run.times[row]:g} s", loc="center")
        for axes in grid[len(rows) :]:
            axes.set_axis_off()
        figure.suptitle("Chief frame", fontsize=10, fontweight="bold", x=0.01, ha="left")
        return figure


def draw_pair(axes: Axes, run: Flown, row: int, view: View) -> None:
    """Draw both bodies in a state, the pyramid between them and the path so far."""
    bodies = series.bodies(run)
    axes.set_aspect("equal")
    axes.set_axis_off()
    if run.scenario is None or not all(body.is_known(row) for body in bodies):
        axes.text(0.5, 0.5, "not recorded", transform=axes.transAxes, ha="center")
        return
    apart = float(series.distance(run.trajectory)[row])
    region = series.sight(run.scenario.plant, max(1.15 * apart, 1.0))
    draw_edges(axes, view, region, color=series.SIGHT_COLOR, linewidth=0.8, zorder=1.5)
    path, _ = view.project(series.port_path(run)[: row + 1])
    axes.plot(*path.T, color=series.DEPUTY_COLOR, linewidth=1.0, zorder=2.0)
    draw_bodies(axes, view, [(body.corners(row), body.color) for body in bodies])
    ports, _ = view.project(np.array([body.port_at(row) for body in bodies]))
    axes.plot(*ports.T, "o", color=style.AXIS_COLORS[1], markersize=2.5, zorder=4.0)
    _window(axes, view, bodies, row, apart)


def _window(axes: Axes, view: View, bodies: list[Body], row: int, apart: float) -> None:
    """Show both bodies, closer the closer they are."""
    middle, _ = view.project(np.array([body.positions[row] for body in bodies]).mean(axis=0)[None])
    half = 0.62 * apart + _NEAR
    axes.set(
        xlim=(middle[0, 0] - half, middle[0, 0] + half),
        ylim=(middle[0, 1] - 0.62 * half, middle[0, 1] + 0.62 * half),
    )
