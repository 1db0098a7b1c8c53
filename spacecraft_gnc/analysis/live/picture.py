"""Picture of a flight at one instant, and the setup that stays the same."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from enum import Enum
from typing import Any, Final

import numpy as np

from spacecraft_gnc.analysis.vehicle import part_of
from spacecraft_gnc.drawing.geometry import circle, graticule
from spacecraft_gnc.drawing.live import Readout, VehicleLive, duration, number
from spacecraft_gnc.drawing.zones import Zone, unit
from spacecraft_gnc.parameters.sections import DEFAULT_VEHICLE
from spacecraft_gnc.scenario import Scenario
from spacecraft_gnc.vehicles.registry import vehicle_of
from spacecraft_gnc.vehicles.vehicle import Vehicle

_DIGITS: Final = 7  # significant, of a number that a page draws
_DRAWN: Final = ("target", "zones", "rims", "bodies", "region", "craft", "ring", "trail")
"""Constants that are drawn, and no number or word."""
_CIRCLE: Final = 72  # points of a circle on the sphere


class Phase(str, Enum):
    """Where a watched flight is."""

    WAITING = "waiting"
    """Nothing was received yet."""
    FLYING = "flying"
    STALE = "stale"
    """Nothing new for a while, though somebody publishes."""
    OVER = "over"
    PLAYING = "playing"
    """A recording runs."""
    PAUSED = "paused"


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """What a flight is, as far as it is known.

    Attributes
    ----------
    title
        Name of the scenario, bag or domain.
    live
        A graph that flies now; otherwise a recording.
    period
        Control period [s]; NaN: not known.
    n_steps
        Control steps of the whole flight; 0: not known.
    mode, method, governor
        As the scenario names them; empty: not known.
    vehicle
        Its part that says what is shown; None: nothing flies yet.
    scenario
        What flies; None: not known.
    constants
        What the vehicle shows all along.
    """

    title: str
    live: bool
    period: float = math.nan
    n_steps: int = 0
    mode: str = ""
    method: str = ""
    governor: str = ""
    vehicle: VehicleLive | None = None
    scenario: Scenario | None = None
    constants: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, scenario: Scenario, title: str, *, live: bool) -> Setup:
        """Take over what a scenario tells, and what its vehicle draws all along.

        Raises
        ------
        ParameterError
            If the vehicle cannot be watched.
        """
        room = part_of("live", scenario.vehicle)
        return cls(
            title=title,
            live=live,
            period=scenario.period,
            n_steps=scenario.n_steps,
            mode=scenario.plant.mode,
            method=scenario.controller.method,
            governor=scenario.governor.governor,
            vehicle=room,
            scenario=scenario,
            constants=room.constants(scenario),
        )

    @classmethod
    def without_scenario(
        cls, title: str, vehicle: Vehicle | None = None, *, live: bool, **known: Any
    ) -> Setup:
        """Return what is known of a vehicle's flight whose scenario is not.

        Raises
        ------
        ParameterError
            If the vehicle cannot be watched.
        """
        room = part_of("live", vehicle_of(DEFAULT_VEHICLE) if vehicle is None else vehicle)
        return cls(title=title, live=live, vehicle=room, constants=room.constants(None), **known)

    @property
    def governed(self) -> bool:
        """Whether a governor is known to stand between target and reference."""
        return self.governor not in ("", "none")

    @property
    def history(self) -> tuple[str, ...]:
        """Values that are drawn over time."""
        return () if self.vehicle is None else tuple(self.vehicle.history)

    def values(self, row: Mapping[str, Any]) -> dict[str, Any]:
        """Return what is shown of a row of the flight; nothing before a vehicle is known."""
        return {} if self.vehicle is None else self.vehicle.values(row, self.constants)

    def as_json(self) -> dict[str, Any]:
        """Return it as JSON-able values."""
        told = {k: v for k, v in self.constants.items() if k not in _DRAWN}
        return {
            "title": self.title,
            "live": self.live,
            "period": rounded(self.period),
            "n_steps": self.n_steps,
            **{name: rounded(value) for name, value in told.items()},
            "mode": self.mode,
            "method": self.method,
            "governor": self.governor,
            "zones": [
                {
                    "name": zone.name,
                    "kind": zone.kind,
                    "body_axis": rounded(unit(zone.body_axis)),
                    "inertial_axis": rounded(unit(zone.inertial_axis)),
                    "half_angle_deg": zone.half_angle_deg,
                }
                for zone in self.constants.get("zones", ())
            ],
        }

    def page_json(self) -> dict[str, Any]:
        """Return, likewise, what a page draws: charts, and the circles on the sphere."""
        panels = () if self.vehicle is None else self.vehicle.panels(self.scenario)
        return {
            "panels": [panel.as_json() for panel in panels],
            "graticule": [_points(line) for line in graticule(_CIRCLE)],
            "rims": [_rim(zone) for zone in self.constants.get("zones", ())],
            "wheels": [_points(wheel) for wheel in self.constants.get("rims", ())],
            "bodies": [body.as_json() for body in self.constants.get("bodies", ())],
            "region": _points(self.constants.get("region", ())),
            "craft": list(self.constants.get("craft", ())),
            "ring": _points(self.constants.get("ring", ())),
            "trail": self.constants.get("trail", ""),
        }


def _rim(zone: Zone) -> list[Any]:
    half_angle = math.radians(zone.half_angle_deg)
    return _points(circle(unit(zone.inertial_axis), half_angle, _CIRCLE))


def _points(line: Any) -> list[Any]:
    points: list[Any] = np.round(line, 5).tolist()
    return points


@dataclass(frozen=True, slots=True, kw_only=True)
class Timing:
    """What the plant's wall clock saw; NaN where it did not."""

    speed: float = math.nan
    """Simulated seconds per wall second."""
    latency: float = math.nan
    """State to command [s]."""
    slack: float = math.nan
    """Left before the deadline [s]."""
    missed: int = 0
    held: int = 0
    rejected: int = 0

    def readouts(self) -> Iterator[Readout]:
        """Yield the lines beside the picture."""
        yield Readout("times real time", number(self.speed, 3))
        yield Readout("state to command", duration(self.latency))
        yield Readout("deadline slack", duration(self.slack), "bad" if self.slack < 0.0 else "")
        yield Readout("deadlines missed", f"{self.missed}", "bad" if self.missed else "")
        yield Readout("commands held", f"{self.held}" if self.held else "", "warn")
        yield Readout("messages rejected", f"{self.rejected}" if self.rejected else "", "bad")


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A flight at one moment.

    Attributes
    ----------
    phase, note
        Where the flight is, and a sentence about it.
    step, time
        Control step, and simulated time [s]; NaN: not known.
    values
        What the vehicle shows of it, by name (`drawing.live.VehicleLive`).
    timing
        None: not known.
    rates
        Messages per wall second by topic.
    """

    phase: Phase
    note: str = ""
    step: int = -1
    time: float = math.nan
    values: Mapping[str, Any] = field(default_factory=dict)
    timing: Timing | None = None
    rates: Mapping[str, float] = field(default_factory=dict)

    def readouts(self, setup: Setup) -> dict[str, list[Readout]]:
        """Return the lines beside the picture that are known, by the name of their group."""
        groups: dict[str, Any] = {}
        if setup.vehicle is not None and self.values:
            groups |= setup.vehicle.readouts(self.values, setup.governed)
        if self.timing is not None:
            groups["timing"] = self.timing.readouts()
        return {name: [line for line in lines if line.text] for name, lines in groups.items()}

    def as_json(self) -> dict[str, Any]:
        """Return it as JSON-able values."""
        return {
            "phase": self.phase.value,
            "note": self.note,
            "step": self.step,
            "time": rounded(self.time),
            **rounded(self.values),
            "timing": None if self.timing is None else rounded(asdict(self.timing)),
            "rates": rounded(self.rates),
        }


def rounded(value: Any) -> Any:
    """Return numbers with seven digits, arrays as flat lists; what is not finite as None."""
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, Mapping):
        return {name: rounded(item) for name, item in value.items()}
    if isinstance(value, np.ndarray):
        return [rounded(item) for item in value.ravel().tolist()]
    return float(f"{value:.{_DIGITS}g}") if math.isfinite(value) else None
