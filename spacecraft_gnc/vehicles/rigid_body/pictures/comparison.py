"""Figures of several flights overlaid."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.axes import TIME_LABEL, legend_below
from spacecraft_gnc.drawing.figures import DOUBLE, SINGLE, Maker
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body import series
from spacecraft_gnc.vehicles.rigid_body.pictures import telemetry as panels
from spacecraft_gnc.vehicles.rigid_body.pictures.figures import single

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario


def comparison_makers(
    runs: Mapping[str, tuple[Flight, Scenario | None]], *, error_scale: str = "log"
) -> dict[str, Maker]:
    """Return what draws the figures of several flights over each other, by name.

    Parameters
    ----------
    runs
        Flight and scenario by name.
    error_scale
        ``log`` or ``linear``, for the attitude error.
    """
    flights = {name: trajectory for name, (trajectory, _) in runs.items()}
    errors = {name: series.settling_error_deg(flight) for name, flight in flights.items()}
    momenta = [series.momenta(trajectory) for trajectory in flights.values()]
    unit = style.prefixed("N m s", *momenta)
    norms = {
        name: unit.factor * np.linalg.norm(series.momenta(trajectory), axis=1)
        for name, trajectory in flights.items()
    }
    torque_unit = style.prefixed("N m", *(series.torque_norm(t) for t in flights.values()))
    torques = {n: torque_unit.factor * series.torque_norm(t) for n, t in flights.items()}
    deadlines = [series.solve_deadline(scenario) for _, scenario in runs.values()]
    solve_times = {name: trajectory.solve_time for name, trajectory in flights.items()}
    over = partial(_over_time, flights)
    makers: dict[str, Maker] = {
        "attitude_error": over(errors, "Attitude error", "angle [deg]", scale=error_scale),
        "momentum": over(norms, "Angular momentum", f"|momentum| [{unit.label}]"),
        "torque": over(torques, "Torque norm", f"|torque| [{torque_unit.label}]"),
        "sources": partial(single, DOUBLE, panels.sources, flights),
    }
    residuals = {name: trajectory.residual for name, trajectory in flights.items()}
    if any(np.isfinite(values).any() for values in residuals.values()):
        counts = {name: _iterations(trajectory) for name, trajectory in flights.items()}
        makers["iterations"] = over(counts, "Solver iterations", "iterations [-]")
        makers["residual"] = over(residuals, "Residual", "residual [-]", scale="log")
        makers["solve_times"] = partial(
            single, SINGLE, panels.solve_times, solve_times, max(deadlines)
        )
    return makers


def _iterations(trajectory: Flight) -> Array:
    """Return (n,) iterations; NaN without a solve."""
    return np.where(trajectory.status >= 0, trajectory.iterations, math.nan)


def _over_time(
    flights: Mapping[str, Flight],
    values: Mapping[str, Array],
    title: str,
    label: str,
    scale: str = "linear",
) -> Maker:
    """Return what draws one curve of each flight."""

    def draw(axes: Axes) -> None:
        for i, (name, trajectory) in enumerate(flights.items()):
            times = series.state_times(trajectory)[: len(values[name])]
            color = style.RUN_COLORS[i % len(style.RUN_COLORS)]
            dashes = style.COMPONENT_STYLES[i % len(style.COMPONENT_STYLES)]
            axes.plot(times, values[name], color=color, linestyle=dashes, label=name)
        axes.set(title=title, xlabel=TIME_LABEL, ylabel=label)
        axes.set_yscale(scale)
        axes.margins(x=0.0)
        legend_below(axes)

    return partial(single, SINGLE, draw)
