"""What is shown of a flight at one moment, and what stays the same all along."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.vehicle import part
from spacecraft_gnc.drawing.sources import source_name
from spacecraft_gnc.drawing.zones import Zone, pointing_margin_deg, unit
from spacecraft_gnc.scenario import Scenario
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array, Matrix3, Vector3

_DIGITS: Final = 7  # significant, of a number that a page draws


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


def status_name(status: int) -> str:
    """Return a solver status in words; it is a constant of SolverStatus."""
    return Status(status).text if 0 <= status < len(Status) else "no solve"


class Strip(NamedTuple):
    """Values over time in place of the angular momentum."""

    title: str
    unit: str
    names: tuple[str, ...]
    """Of the values, such as one for each wheel."""


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
    torque_limit
        Largest norm of the torque [N m]; 0: none, or not known.
    mode, method, governor
        As the scenario names them; empty: not known.
    target
        (3, 3) target attitude of the scenario, body to inertial; None: not known.
    zones
        Pointing zones.
    strip
        What is drawn over time in place of momentum and torque; None: these are.
    """

    title: str
    live: bool
    period: float = math.nan
    n_steps: int = 0
    torque_limit: float = 0.0
    mode: str = ""
    method: str = ""
    governor: str = ""
    target: Matrix3 | None = None
    zones: tuple[Zone, ...] = ()
    strip: Strip | None = None

    @classmethod
    def of(cls, scenario: Scenario, title: str, *, live: bool) -> Setup:
        """Take over what a scenario tells, and what its vehicle draws all along.

        Raises
        ------
        ParameterError
            If the vehicle cannot be watched.
        """
        constants = part("live", scenario).constants(scenario)
        strip = constants.pop("strip", None)
        return cls(
            title=title,
            live=live,
            period=scenario.period,
            n_steps=scenario.n_steps,
            mode=scenario.plant.mode,
            method=scenario.controller.method,
            governor=scenario.governor.governor,
            strip=None if strip is None else Strip(*strip),
            **constants,
        )

    def as_json(self) -> dict[str, Any]:
        """Return it as JSON-able values."""
        return {
            "title": self.title,
            "live": self.live,
            "period": rounded(self.period),
            "n_steps": self.n_steps,
            "torque_limit": self.torque_limit,
            "mode": self.mode,
            "method": self.method,
            "governor": self.governor,
            "strip": None if self.strip is None else self.strip._asdict(),
            "zones": [
                {
                    "name": zone.name,
                    "kind": zone.kind,
                    "body_axis": rounded(unit(zone.body_axis)),
                    "inertial_axis": rounded(unit(zone.inertial_axis)),
                    "half_angle_deg": zone.half_angle_deg,
                }
                for zone in self.zones
            ],
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class Solve:
    """What the solver told of one step; NaN where it did not."""

    status: str
    iterations: int
    residual: float
    cost: float = math.nan
    curvature: float = math.nan
    """Smallest eigenvalue of the reduced Hessian [cost per (N m)^2]."""
    solve_time: float = math.nan
    """Wall time [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Decision:
    """What the governor told of one step."""

    alpha: float
    margin: float = math.nan
    admissible: bool = True
    constraint: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Timing:
    """What the plant's wall clock saw; NaN where it did not."""

    speed: float = math.nan
    """Simulated seconds per wall second."""
    latency: float = math.nan
    """State to torque [s]."""
    slack: float = math.nan
    """Left before the deadline [s]."""
    missed: int = 0
    held: int = 0
    rejected: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A flight at one moment. None and NaN: not known.

    Attributes
    ----------
    phase, note
        Where the flight is, and a sentence about it.
    step, time
        Control step, and simulated time [s].
    attitude, reference, target
        (3, 3) rotations, body to inertial.
    momentum, torque
        (3,) body frame [N m s], [N m].
    strip
        Values of `Setup.strip`.
    external_torque
        (3,) of the disturbances, body frame [N m].
    source
        Where the torque came from, a constant of TorqueCommand; -1: not known.
    rates
        Messages per wall second by topic.
    """

    phase: Phase
    note: str = ""
    step: int = -1
    time: float = math.nan
    attitude: Matrix3 | None = None
    reference: Matrix3 | None = None
    target: Matrix3 | None = None
    momentum: Vector3 | None = None
    torque: Vector3 | None = None
    strip: Array | None = None
    external_torque: Vector3 | None = None
    source: int = -1
    solve: Solve | None = None
    decision: Decision | None = None
    timing: Timing | None = None
    rates: dict[str, float] = field(default_factory=dict)

    def error_deg(self, aim: Matrix3 | None) -> float:
        """Return the angle from ``aim`` to the attitude [deg]; NaN if either is not known."""
        if self.attitude is None or aim is None:
            return math.nan
        return math.degrees(lie.angle_between(aim, self.attitude))

    def margins_deg(self, setup: Setup) -> dict[str, float]:
        """Return the angles left to the pointing zones [deg] by name."""
        if self.attitude is None:
            return {}
        attitude = self.attitude[None]
        return {zone.name: float(pointing_margin_deg(attitude, zone)[0]) for zone in setup.zones}

    def as_json(self, setup: Setup) -> dict[str, Any]:
        """Return it as JSON-able values."""
        target = setup.target if self.target is None else self.target
        return {
            "phase": self.phase.value,
            "note": self.note,
            "step": self.step,
            "time": rounded(self.time),
            "attitude": rounded(self.attitude),
            "reference": rounded(self.reference),
            "target": rounded(target),
            "momentum": rounded(self.momentum),
            "torque": rounded(self.torque),
            "strip": rounded(self.strip),
            "external_torque": rounded(self.external_torque),
            "source": source_name(self.source, "unknown"),
            "error_deg": rounded(self.error_deg(self.reference)),
            "target_error_deg": rounded(self.error_deg(target)),
            "margins_deg": {k: rounded(v) for k, v in self.margins_deg(setup).items()},
            "solve": _members(self.solve),
            "decision": _members(self.decision),
            "timing": _members(self.timing),
            "rates": {topic: rounded(rate) for topic, rate in self.rates.items()},
        }


def rounded(value: Any) -> Any:
    """Return numbers with seven digits, arrays as flat lists; what is not finite as None."""
    if value is None or isinstance(value, str | bool | int):
        return value
    if isinstance(value, np.ndarray):
        return [rounded(item) for item in value.ravel().tolist()]
    return float(f"{value:.{_DIGITS}g}") if math.isfinite(value) else None


def _members(item: Any) -> dict[str, Any] | None:
    return None if item is None else {n: rounded(getattr(item, n)) for n in item.__slots__}
