"""Publication figures of one flight: its motion, and what was recorded beside it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.figure import Figure

from spacecraft_gnc.drawing import representations as forms
from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.figures import DOUBLE, SINGLE, Draw, Maker, stacked
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body import series
from spacecraft_gnc.vehicles.rigid_body.pictures import motion as panels
from spacecraft_gnc.vehicles.rigid_body.pictures import plan as plan_panels
from spacecraft_gnc.vehicles.rigid_body.pictures import telemetry as telemetry_panels
from spacecraft_gnc.vehicles.rigid_body.planner import series as plan_series

if TYPE_CHECKING:
    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario
    from spacecraft_gnc.vehicles.rigid_body.telemetry import Telemetry

_SQUARE = (5.2, 5.6)
_OVERVIEW = (11.0, 8.6)
_BAND: Final = (6.3, 1.7)  # [inch]
_TRIPLE: Final = (6.3, 7.4)  # [inch]
_COSTATES: Final = (
    plan_panels.co_momentum,
    plan_panels.torque_multipliers,
    plan_panels.momentum_multipliers,
)


def flight_figures(
    trajectory: Flight,
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
    trajectory: Flight,
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
        ``plan``, ``tracking``, ``external_torque``, ``governor``, ``zones`` and ``solver`` where
        there is something to show).
    """
    limit = series.torque_limit(trajectory, scenario)
    zones = scenario.controller.zones if scenario is not None else ()
    draw: dict[str, Draw] = {
        "error": lambda axes: panels.attitude_error(axes, trajectory, scale=error_scale),
        "momentum": lambda axes: panels.momentum(axes, trajectory),
        "torque": lambda axes: panels.torque_components(axes, trajectory),
        "tracking": lambda axes: panels.tracking(axes, trajectory),
        "external": lambda axes: panels.external_torque(axes, trajectory),
        "norm": lambda axes: panels.torque_norm(axes, trajectory, limit),
        "sphere": lambda axes: panels.attitude_sphere(axes, trajectory, zones),
        "alpha": lambda axes: panels.alpha(axes, trajectory),
        "zones": lambda axes: panels.zone_margins(axes, trajectory, zones),
        "iterations": lambda axes: panels.iterations(axes, trajectory),
        "solve_time": lambda axes: panels.solve_time(axes, trajectory),
    }
    planned = plan_series.is_planned(trajectory)
    if planned:
        draw |= _of_plan(trajectory, scenario)
    makers: dict[str, Maker] = {
        "overview": lambda: _overview(draw, "plan_error" if planned else "norm", title),
        "attitude_error": lambda: stacked(SINGLE, draw["error"]),
        "momentum": lambda: stacked(SINGLE, draw["momentum"]),
        "torque": lambda: stacked(DOUBLE, draw["torque"], draw["norm"]),
        "sphere": lambda: stacked(_SQUARE, draw["sphere"]),
    }
    if planned:
        names = ("torque", "momentum", "plan_error")
        makers["plan"] = lambda: stacked(_TRIPLE, *(draw[name] for name in names))
    if series.is_moving(trajectory):
        makers["tracking"] = lambda: stacked(DOUBLE, draw["tracking"], draw["error"])
    if series.is_disturbed(trajectory):
        makers["external_torque"] = lambda: stacked(SINGLE, draw["external"])
    if series.is_governed(trajectory):
        makers["governor"] = lambda: stacked(SINGLE, draw["alpha"])
    if zones:
        makers["zones"] = lambda: stacked(SINGLE, draw["zones"])
    if np.any(trajectory.status >= 0):
        makers["solver"] = lambda: stacked(DOUBLE, draw["iterations"], draw["solve_time"])
    return makers


def _of_plan(trajectory: Flight, scenario: Scenario | None) -> dict[str, Draw]:
    """Return what draws the diagrams of a planned flight."""
    bounds = plan_series.bounds_of(scenario)
    return {
        "momentum": lambda axes: plan_panels.momentum(axes, trajectory, bounds),
        "torque": lambda axes: plan_panels.torque(axes, trajectory, bounds),
        "plan_error": lambda axes: plan_panels.error(axes, trajectory),
    }


def _overview(draw: Mapping[str, Draw], last: str, title: str) -> Figure:
    with style.applied():
        figure = Figure(_OVERVIEW, layout="constrained")
        grid = figure.add_gridspec(3, 2, width_ratios=[1.12, 1.0])
        cells = {
            "error": grid[0, 0],
            "momentum": grid[1, 0],
            "torque": grid[2, 0],
            "sphere": grid[:2, 1],
            last: grid[2, 1],
        }
        for name, cell in cells.items():
            draw[name](figure.add_subplot(cell))
        if title:
            figure.suptitle(title, fontsize=12, fontweight="bold")
        return figure


def record_makers(
    trajectory: Flight, telemetry: Telemetry, scenario: Scenario | None = None
) -> dict[str, Maker]:
    """Return what draws each figure of a recording.

    Parameters
    ----------
    trajectory, telemetry
        What was flown and recorded.
    scenario
        Gives tolerance and deadline.

    Returns
    -------
    dict
        By name: ``quaternion``, ``roll_pitch_yaw``, ``rotation_vector``, ``sources``,
        ``invariants``; ``costates``, ``residual``, ``solve_times``, ``curvature``, ``radius`` and
        ``governor_margin`` where there is something to show.
    """
    makers: dict[str, Maker] = {
        form.name: partial(single, SINGLE, telemetry_panels.representation, trajectory, form)
        for form in forms.REPRESENTATIONS
    }
    makers["sources"] = partial(single, _BAND, telemetry_panels.sources, {"": trajectory})
    makers["invariants"] = lambda: stacked(
        _TRIPLE,
        lambda axes: telemetry_panels.kinetic_energy(axes, trajectory, telemetry),
        lambda axes: telemetry_panels.inertial_momentum(axes, trajectory, telemetry),
        lambda axes: telemetry_panels.orthogonality(axes, trajectory, telemetry),
    )
    if telemetry.plans:
        makers["costates"] = lambda: stacked(
            _TRIPLE,
            *(partial(panel, trajectory=trajectory, telemetry=telemetry) for panel in _COSTATES),
        )
    tolerance = scenario.controller.residual_tolerance if scenario is not None else None
    times = {"solves": trajectory.solve_time}
    deadline = series.solve_deadline(scenario)
    optional: dict[str, tuple[Array, Maker]] = {
        "residual": (
            trajectory.residual,
            partial(single, SINGLE, telemetry_panels.residual, trajectory, tolerance),
        ),
        "solve_times": (
            trajectory.solve_time,
            partial(single, SINGLE, telemetry_panels.solve_times, times, deadline),
        ),
        "curvature": (
            telemetry.min_curvature,
            partial(single, SINGLE, telemetry_panels.curvature, trajectory, telemetry),
        ),
        "radius": (
            telemetry.closed_loop_radius,
            partial(single, SINGLE, telemetry_panels.radius, trajectory, telemetry),
        ),
        "governor_margin": (
            trajectory.governor_margin,
            partial(single, SINGLE, telemetry_panels.governor_margin, trajectory),
        ),
    }
    found = {name: make for name, (values, make) in optional.items() if np.isfinite(values).any()}
    return makers | found


def single(size: tuple[float, float], panel: Callable[..., None], *arguments: Any) -> Figure:
    """Return a figure of one panel, drawn with these arguments."""
    return stacked(size, lambda axes: panel(axes, *arguments))
