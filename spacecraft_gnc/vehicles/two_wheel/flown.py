"""Flight with its scenario, as figures and report read it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.attitude_view import Rotors
from spacecraft_gnc.drawing.geometry import rim
from spacecraft_gnc.drawing.marks import Mark
from spacecraft_gnc.drawing.vehicle import FlownRun
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.two_wheel.euler import to_euler_321
from spacecraft_gnc.vehicles.two_wheel.summary import mode_name, states
from spacecraft_gnc.vehicles.two_wheel.wheels import as_axes

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.two_wheel.flight import WheelFlight
    from spacecraft_gnc.vehicles.two_wheel.scenario import Scenario
    from spacecraft_gnc.vehicles.two_wheel.telemetry import Telemetry


class Flown(FlownRun, Protocol):
    """One run."""

    @property
    def trajectory(self) -> WheelFlight:
        """What was flown."""

    @property
    def scenario(self) -> Scenario | None:
        """What flew; None: not known."""

    @property
    def telemetry(self) -> Telemetry:
        """What its bag tells."""


def error_deg(flight: WheelFlight) -> Array:
    """Return the angle (n + 1,) from the target to the attitude [deg]."""
    targets = np.concatenate([flight.target, flight.target[-1:]])
    return np.degrees(lie.angles_between(targets, states(flight)[1]))


def euler_deg(flight: WheelFlight) -> Array:
    """Return roll, pitch, yaw (n + 1, 3) of the states [deg]."""
    return np.degrees(to_euler_321(states(flight)[1]))


def rate(flight: WheelFlight) -> Array:
    """Return the rate of the bus (n + 1, 3) in the states, body frame [rad/s]."""
    return states(flight)[2]


def wheel_speed(flight: WheelFlight) -> Array:
    """Return the wheel speeds (n + 1, m) of the states [rad/s]."""
    return states(flight)[3]


def wheel_names(flight: WheelFlight) -> list[str]:
    """Return how the wheels are called."""
    return [f"wheel {i + 1}" for i in range(flight.wheel_speed.shape[1])]


class Event(NamedTuple):
    """Something that happened to a wheel."""

    time: float
    """[s]"""
    text: str
    is_truth: bool
    """It happened; else it was concluded on board."""


def events(flight: WheelFlight) -> list[Event]:
    """Return when wheels were lost, and when they were excluded on board."""
    told = ((flight.healthy, "lost", True), (flight.diagnosed, "excluded", False))
    found = [
        Event(float(flight.time[np.argmin(column)]), f"{name} {what}", truth)
        for healthy, what, truth in told
        for name, column in zip(wheel_names(flight), healthy.T, strict=True)
        if not column.all()
    ]
    return sorted(found)


def marks(flight: WheelFlight) -> list[Mark]:
    """Return `events` as diagrams show them."""
    colors = {True: style.LIMIT_COLOR, False: style.INK}
    return [
        Mark(event.time, event.text, colors[event.is_truth], event.is_truth)
        for event in events(flight)
    ]


def beliefs(flight: WheelFlight) -> list[str]:
    """Return how it is flown, and which wheels are excluded and lost, in words (n + 1)."""
    names = np.array(wheel_names(flight), dtype=object)
    rows = [
        ", ".join(
            [
                mode_name(int(mode)),
                *(f"{name} excluded" for name in names[~believed]),
                *(f"{name} lost" for name in names[~healthy]),
            ]
        )
        for mode, believed, healthy in zip(
            flight.mode, flight.diagnosed, flight.healthy, strict=True
        )
    ]
    return [*rows, rows[-1]]


def rotors(run: Flown) -> Rotors | None:
    """Return the wheels as a 3-D view draws them; None where their axes are not known."""
    if run.scenario is None:
        return None
    flight = run.trajectory
    return Rotors(
        wheel_names(flight),
        as_axes(run.scenario.plant.wheel_axes),
        turning(wheel_speed(flight), limit_of(run.scenario, "max_wheel_speed")),
        np.vstack([flight.healthy, flight.healthy[-1:]]),
        np.vstack([flight.diagnosed, flight.diagnosed[-1:]]),
    )


def wheel_rims(scenario: Scenario) -> list[Array]:
    """Return the rim (k, 3) of each wheel in the unit sphere, body frame."""
    return [rim(axis) for axis in as_axes(scenario.plant.wheel_axes).T]


def turning(speed: Array, limit: float) -> Array:
    """Return wheel speeds over their limit, or over the largest one where there is none."""
    most = limit or float(np.nanmax(np.abs(speed), initial=0.0))
    return np.asarray(speed / (most or 1.0))


def limit_of(scenario: Scenario | None, name: str) -> float:
    """Return a limit of the wheels; 0: none, or not known."""
    return 0.0 if scenario is None else float(getattr(scenario.plant, name))
