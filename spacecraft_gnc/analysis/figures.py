"""Publication figures of one flight, written as PNG, SVG or PDF."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np
from matplotlib.figure import Figure

from spacecraft_gnc.analysis import panels, series, style
from spacecraft_gnc.errors import RecordingError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from spacecraft_gnc.loop.trajectory import Trajectory
    from spacecraft_gnc.scenario import Scenario

FORMATS: Final = ("png", "svg", "pdf")
SINGLE = (6.3, 3.2)  # [inch]
DOUBLE = (6.3, 5.2)
_SQUARE = (5.2, 5.6)
_OVERVIEW = (11.0, 8.6)
# No date in the files: the same flight gives the same bytes.
_METADATA: Final[Mapping[str, Mapping[str, None]]] = {
    "png": {},
    "svg": {"Date": None},
    "pdf": {"CreationDate": None},
}
Draw: TypeAlias = "Callable[[Axes], None]"
Maker: TypeAlias = "Callable[[], Figure]"


def flight_figures(
    trajectory: Trajectory,
    scenario: Scenario | None = None,
    *,
    title: str = "",
    error_scale: str = "log",
) -> Iterator[tuple[str, Figure]]:
    """Draw the figures of one flight.

    Parameters
    ----------
    trajectory
        What was flown.
    scenario
        Gives the torque limit and the pointing zones.
    title
        Heading of the overview.
    error_scale
        ``log`` or ``linear``, for the attitude error.

    Yields
    ------
    tuple of str and Figure
        Names and figures of `flight_makers`.
    """
    makers = flight_makers(trajectory, scenario, title=title, error_scale=error_scale)
    yield from ((name, make()) for name, make in makers.items())


def flight_makers(
    trajectory: Trajectory,
    scenario: Scenario | None = None,
    *,
    title: str = "",
    error_scale: str = "log",
) -> dict[str, Maker]:
    """Return what draws each figure of one flight; arguments as of `flight_figures`.

    Returns
    -------
    dict
        By name (``overview``, ``attitude_error``, ``momentum``, ``torque``, ``sphere``;
        ``governor``, ``zones`` and ``solver`` where there is something to show).
    """
    limit = series.torque_limit(trajectory, scenario)
    zones = scenario.controller.zones if scenario is not None else ()
    draw: dict[str, Draw] = {
        "error": lambda axes: panels.attitude_error(axes, trajectory, scale=error_scale),
        "momentum": lambda axes: panels.momentum(axes, trajectory),
        "torque": lambda axes: panels.torque_components(axes, trajectory),
        "norm": lambda axes: panels.torque_norm(axes, trajectory, limit),
        "sphere": lambda axes: panels.attitude_sphere(axes, trajectory, zones),
        "alpha": lambda axes: panels.alpha(axes, trajectory),
        "zones": lambda axes: panels.zone_margins(axes, trajectory, zones),
        "iterations": lambda axes: panels.iterations(axes, trajectory),
        "solve_time": lambda axes: panels.solve_time(axes, trajectory),
    }
    makers: dict[str, Maker] = {
        "overview": lambda: _overview(draw, title),
        "attitude_error": lambda: stacked(SINGLE, draw["error"]),
        "momentum": lambda: stacked(SINGLE, draw["momentum"]),
        "torque": lambda: stacked(DOUBLE, draw["torque"], draw["norm"]),
        "sphere": lambda: stacked(_SQUARE, draw["sphere"]),
    }
    if series.is_governed(trajectory):
        makers["governor"] = lambda: stacked(SINGLE, draw["alpha"])
    if zones:
        makers["zones"] = lambda: stacked(SINGLE, draw["zones"])
    if np.any(trajectory.status >= 0):
        makers["solver"] = lambda: stacked(DOUBLE, draw["iterations"], draw["solve_time"])
    return makers


def _overview(draw: Mapping[str, Draw], title: str) -> Figure:
    with style.applied():
        figure = Figure(_OVERVIEW, layout="constrained")
        grid = figure.add_gridspec(3, 2, width_ratios=[1.12, 1.0])
        cells = {
            "error": grid[0, 0],
            "momentum": grid[1, 0],
            "torque": grid[2, 0],
            "sphere": grid[:2, 1],
            "norm": grid[2, 1],
        }
        for name, cell in cells.items():
            draw[name](figure.add_subplot(cell))
        if title:
            figure.suptitle(title, fontsize=12, fontweight="bold")
        return figure


def stacked(size: tuple[float, float], *draw: Draw) -> Figure:
    """Return a figure with diagrams above each other, over one time axis."""
    with style.applied():
        figure = Figure(size, layout="constrained")
        axes = figure.subplots(len(draw), 1, sharex=True, squeeze=False)[:, 0]
        for panel, draw_panel in zip(axes, draw, strict=True):
            draw_panel(panel)
        for panel in axes[:-1]:
            panel.set_xlabel("")
        return figure


def save_figures(
    figures: Iterable[tuple[str, Figure]], folder: Path, formats: Iterable[str] = ("png",)
) -> list[Path]:
    """Write figures to ``folder``/NAME.FORMAT, each in one step.

    Parameters
    ----------
    figures
        Names and figures, as from `flight_figures`.
    folder
        Created if need be.
    formats
        Of `FORMATS`.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    RecordingError
        If the folder cannot be written.
    """
    formats = tuple(formats)
    written: list[Path] = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, figure in figures:
            written += [_save(figure, folder / f"{name}.{kind}", kind) for kind in formats]
    except OSError as error:
        raise RecordingError(
            f"{folder}: figures cannot be written ({os.strerror(error.errno or 0)}); required a "
            "folder that can be written, with free space; choose another with --out"
        ) from error
    return written


def _save(figure: Figure, path: Path, kind: str) -> Path:
    temporary = path.with_name(f".{path.name}.tmp")
    try:
        with style.applied():
            figure.savefig(temporary, format=kind, metadata=dict(_METADATA[kind]))
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
    return path
