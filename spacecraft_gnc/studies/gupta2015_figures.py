"""Pictures of Gupta et al. 2015: its Figs. 1-8 (Case I) and 9-13 (Case II)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.axes import limit
from spacecraft_gnc.studies import overlays
from spacecraft_gnc.studies.gupta2015 import (
    FAST,
    METHODS,
    PARKED,
    Flights,
    zone_constraint,
)
from spacecraft_gnc.vehicles.rigid_body.pictures import motion as panels
from spacecraft_gnc.vehicles.rigid_body.series import attitude_error_deg, state_times

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_BASELINE = "SLSQP"


def figures(flights: Flights) -> Iterator[tuple[str, Figure]]:
    """Yield the pictures by name."""
    yield "gupta2015_case1", _case_1(flights)
    yield "gupta2015_case2", _case_2(flights)


def _case_1(flights: Flights) -> Figure:
    """Draw our flight, and beside it the baseline's where it was flown."""
    columns = [method for method in (FAST, _BASELINE) if ("I", method) in flights.by_case]
    limit = flights.by_case["I", FAST].scenario.controller.max_torque
    with style.applied():
        figure = Figure((5.5 * len(columns), 10.4), layout="constrained")
        grid = figure.subplots(
            4, len(columns), sharey="row", squeeze=False, height_ratios=[1.0, 1.0, 1.0, 2.1]
        )
        for method, column in zip(columns, grid.T, strict=True):
            flight = flights.of("I", method)
            panels.momentum(column[0], flight)
            panels.torque_components(column[1], flight)
            panels.torque_norm(column[2], flight, limit)
            panels.attitude_sphere(column[3], flight)
            for axes, what in zip(
                column, ("momentum", "control", "norm of the control", "attitude"), strict=True
            ):
                axes.set_title(f"{_who(method)}: {what}")
        figure.suptitle("Gupta et al. (2015), Case I", fontsize=12, fontweight="bold")
        return figure


def _who(method: str) -> str:
    return "Ours" if method == FAST else method


def _case_2(flights: Flights) -> Figure:
    flown = flights.by_case["II", FAST]
    flight, controller = flown.trajectory, flown.scenario.controller
    with style.applied():
        figure = Figure((11.0, 10.4), layout="constrained")
        grid = figure.add_gridspec(4, 2)
        left = [figure.add_subplot(grid[i, 0]) for i in range(4)]
        panels.momentum(left[0], flight)
        panels.torque_components(left[1], flight)
        panels.torque_norm(left[2], flight, controller.max_torque)
        for axes, what in zip(left, ("Momentum", "Control", "Norm of the control"), strict=False):
            axes.set_title(what)
        _zone(left[3], flights)
        panels.attitude_sphere(figure.add_subplot(grid[:2, 1]), flight, controller.zones)
        _errors(figure.add_subplot(grid[2, 1]), flights)
        _times(figure.add_subplot(grid[3, 1]), flights)
        figure.suptitle(
            "Gupta et al. (2015), Case II as printed, with the standstill escape",
            fontsize=12,
            fontweight="bold",
        )
        return figure


def _zone(axes: Axes, flights: Flights) -> None:
    times = state_times(flights.of("II"))
    series = {name: zone_constraint(flights.of(case)) for name, case in _CASES.items()}
    overlays.lines(axes, times, series, title="Exclusion zone", ylabel="$H_1$ [-]")
    limit(axes, 0.0)
    axes.set_ylim(top=0.04)
    axes.annotate(
        "inside the zone", (times[-1], 0.0), xytext=(0, 3), textcoords="offset points",
        ha="right", va="bottom", fontsize=8, color=style.LIMIT_COLOR,
    )  # fmt: skip


def _errors(axes: Axes, flights: Flights) -> None:
    times = state_times(flights.of("II"))
    series = {name: attitude_error_deg(flights.of(case)) for name, case in _CASES.items()}
    overlays.lines(axes, times, series, title="Attitude error", ylabel="angle [deg]", floor=1e-4)


def _times(axes: Axes, flights: Flights) -> None:
    flown = {m: flights.by_case["II", m] for m in METHODS if ("II", m) in flights.by_case}
    series = {method: flight.step_times for method, flight in flown.items()}
    times = state_times(flights.of("II"))
    overlays.step_times(axes, times, series, title="Time of a step")


_CASES = {"as printed": "II", "without escape": PARKED, "off the plane": "II off plane"}
