"""Pictures beside Figs. 2 to 12 of Kalabic et al. 2014."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.figure import Figure

from spacecraft_gnc.drawing import sphere, style
from spacecraft_gnc.drawing.axes import frame, limit
from spacecraft_gnc.studies import overlays
from spacecraft_gnc.studies.kalabic2014 import (
    ALONE,
    FLIP_MINUS,
    FLIP_PLUS,
    GOVERNED,
    LIMIT,
    NMPC,
    OVER_NMPC,
    PARKED,
    UNGOVERNED,
    Flights,
    error_deg,
)
from spacecraft_gnc.vehicles.rigid_body import series
from spacecraft_gnc.vehicles.rigid_body.pictures import motion as panels

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from spacecraft_gnc.studies.flights import Flown
    from spacecraft_gnc.types import Array

_BODY_AXES: Final = tuple({"color": color} for color in style.AXIS_COLORS)
_ZONE_VIEW: Final = sphere.View(azimuth_deg=40.0, elevation_deg=20.0)
VIEW: Final = sphere.View(azimuth_deg=50.0, elevation_deg=38.0)


def figures(flights: Flights) -> Iterator[tuple[str, Figure]]:
    """Yield name and figure."""
    yield "kalabic2014_governor", _governor(flights)
    yield "kalabic2014_nmpc", _nmpc(flights)
    yield "kalabic2014_flip", _flip(flights)
    yield "governed_nmpc", _over_nmpc(flights)


def _governor(flights: Flights) -> Figure:
    """Figs. 2 to 5, and the torque without the governor."""
    flown = flights.by_name[GOVERNED]
    with style.applied():
        figure = Figure((11.0, 8.4), layout="constrained")
        grid = figure.add_gridspec(6, 2)
        left = [figure.add_subplot(grid[2 * i : 2 * i + 2, 0]) for i in range(3)]
        panels.torque_norm(left[0], flown.trajectory, LIMIT)
        _rates(left[1], flown)
        _alpha(left[2], flown)
        _path(figure.add_subplot(grid[:4, 1]), flown, every=10.0)
        _compared(figure.add_subplot(grid[4:, 1]), flights)
        _title(figure, "reference governor")
        return figure


def _nmpc(flights: Flights) -> Figure:
    """Figs. 6 to 8, and the error beside the governor's."""
    flown = flights.by_name[NMPC]
    with style.applied():
        figure = Figure((11.0, 8.4), layout="constrained")
        grid = figure.add_gridspec(6, 2)
        left = [figure.add_subplot(grid[2 * i : 2 * i + 2, 0]) for i in range(3)]
        panels.torque_norm(left[0], flown.trajectory, LIMIT)
        _rates(left[1], flown)
        names = (GOVERNED, UNGOVERNED, NMPC)
        errors = {name: error_deg(flights.of(name)) for name in names}
        times = max((series.state_times(flights.of(name)) for name in names), key=len)
        overlays.lines(
            left[2], times, errors, title="Angle to the target", ylabel="angle [deg]", floor=1e-3
        )
        _path(figure.add_subplot(grid[:5, 1]), flown, every=2.0)
        _title(figure, "terminal-set NMPC, N = 5, without the kappa part")
        return figure


def _flip(flights: Flights) -> Figure:
    """Figs. 9 to 12."""
    names = {FLIP_PLUS: r"$C_3(\pi)$", FLIP_MINUS: r"$C_3(-0.99\,\pi)$"}
    with style.applied():
        figure = Figure((11.0, 8.4), layout="constrained")
        grid = figure.add_gridspec(5, 2)
        times = series.state_times(flights.of(FLIP_PLUS))
        torque = {
            label: np.append(flights.of(name).torque[:, 2], flights.of(name).torque[-1, 2])
            for name, label in names.items()
        }
        rate = {
            label: _angular_velocity(flights.by_name[name])[:, 2] for name, label in names.items()
        }
        overlays.lines(
            figure.add_subplot(grid[:2, 0]), times, torque, title="Torque about z",
            ylabel="$T_3$ [N m]",
        )  # fmt: skip
        overlays.lines(
            figure.add_subplot(grid[:2, 1]), times, rate, title="Angular velocity about z",
            ylabel=r"$\Omega_3$ [rad/s]",
        )  # fmt: skip
        for column, (name, label) in enumerate(names.items()):
            axes = figure.add_subplot(grid[2:, column])
            _path(axes, flights.by_name[name], every=2.0)
            axes.set_title(f"Body axes, from {label}")
        _title(figure, "terminal-set NMPC, N = 10, no torque limit, half a turn")
        return figure


def _over_nmpc(flights: Flights) -> Figure:
    """Draw the same scenario with the governor and without."""
    names = (OVER_NMPC, ALONE, PARKED)
    flown = [flights.by_name[name] for name in names]
    times = series.state_times(flown[0].trajectory)
    zones = flown[0].scenario.controller.zones
    with style.applied():
        figure = Figure((11.0, 8.4), layout="constrained")
        grid = figure.add_gridspec(5, 2)
        for column in range(2):
            axes = figure.add_subplot(grid[:3, column])
            panels.attitude_sphere(axes, flown[column].trajectory, zones, _ZONE_VIEW)
            axes.set_title(f"Body axes, {names[column]}")
            references = flown[column].trajectory.reference
            sphere.draw_curve(axes, _ZONE_VIEW, references[:, :, 0], color=style.INK, linewidth=0.8)
        margins = {
            name: series.zone_margin_deg(one.trajectory, zones[0])
            for name, one in zip(names, flown, strict=True)
        }
        left = figure.add_subplot(grid[3:, 0])
        overlays.lines(left, times, margins, title="Angle to the zone", ylabel="angle [deg]")
        limit(left, 0.0)
        errors = {name: error_deg(flights.of(name)) for name in names}
        overlays.lines(
            figure.add_subplot(grid[3:, 1]), times, errors, title="Angle to the target",
            ylabel="angle [deg]", floor=1e-3,
        )  # fmt: skip
        figure.suptitle(
            "A 15 deg zone across an 86 deg turn: governor over NMPC, and NMPC alone",
            fontsize=12,
            fontweight="bold",
        )
        return figure


def _title(figure: Figure, what: str) -> None:
    figure.suptitle(f"Kalabic et al. (2014): {what}", fontsize=12, fontweight="bold")


def _angular_velocity(flown: Flown) -> Array:
    """Return (n + 1, 3) body rates [rad/s]."""
    inverse = np.linalg.inv(flown.scenario.plant.inertia)
    return np.asarray(series.momenta(flown.trajectory) @ inverse)


def _rates(axes: Axes, flown: Flown) -> None:
    times = series.state_times(flown.trajectory)
    rates = _angular_velocity(flown).T
    overlays.lines(
        axes,
        times,
        {rf"$\Omega_{axis}$": 1e3 * rate for axis, rate in zip("xyz", rates, strict=True)},
        title="Angular velocity, body frame",
        ylabel="angular velocity [mrad/s]",
        looks=_BODY_AXES,
    )


def _alpha(axes: Axes, flown: Flown) -> None:
    """Draw alpha on a scale that shows the thousandths of the way and the 1 at the end."""
    flight = flown.trajectory
    axes.plot(flight.time, np.maximum(flight.alpha, 1e-5), ".", color=style.INK, markersize=2.5)
    frame(axes, series.state_times(flight), "Share of the way admitted", r"$\alpha$ [-]")
    axes.set_yscale("log")
    axes.set_ylim(0.8e-5, 2.0)


def _compared(axes: Axes, flights: Flights) -> None:
    norms = {name: series.torque_norm(flights.of(name)) for name in (GOVERNED, UNGOVERNED)}
    times = series.state_times(flights.of(GOVERNED))
    overlays.lines(
        axes, times, norms, title="Torque norm, with and without the governor",
        ylabel="torque [N m]", floor=1e-5,
    )  # fmt: skip
    limit(axes, LIMIT)


def _path(axes: Axes, flown: Flown, every: float) -> None:
    """Draw the body axes on the sphere, a dot every so many seconds, and the reference's path."""
    flight = flown.trajectory
    panels.attitude_sphere(axes, flight, flown.scenario.controller.zones, VIEW)
    stride = max(1, round(every / flight.period))
    attitudes, references = series.attitudes(flight)[::stride], flight.reference
    for i, color in enumerate(style.AXIS_COLORS):
        picture, depth = VIEW.project(attitudes[:, :, i])
        near = picture[depth >= 0.0]
        axes.plot(near[:, 0], near[:, 1], "o", color=color, markersize=3.0, zorder=3.4)
        sphere.draw_curve(axes, VIEW, references[:, :, i], color=style.INK, linewidth=0.8)
    shaped = "; reference thin" if flown.scenario.governor.governor != "none" else ""
    axes.set_title(f"Body axes, a dot every {every:g} s{shaped}")
