"""Docking flight with its scenario, as figures and report read it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import groupby
from typing import TYPE_CHECKING, Final, NamedTuple, Protocol

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.chart import held
from spacecraft_gnc.drawing.marks import Mark
from spacecraft_gnc.drawing.representations import rotation_vectors
from spacecraft_gnc.drawing.solids import CORNERS, Body
from spacecraft_gnc.drawing.vehicle import FlownRun
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.chief import ChiefMotion
from spacecraft_gnc.vehicles.docking.decision import Answer, Phase
from spacecraft_gnc.vehicles.docking.geometry import deputy_center
from spacecraft_gnc.vehicles.docking.metrics import angles, loss
from spacecraft_gnc.vehicles.docking.summary import phase_name, states

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.docking.flight import DockingFlight
    from spacecraft_gnc.vehicles.docking.parameters.plant import PlantParameters
    from spacecraft_gnc.vehicles.docking.scenario import Scenario
    from spacecraft_gnc.vehicles.docking.telemetry import Telemetry

CHIEF_COLOR: Final = "#8C97A5"
DEPUTY_COLOR: Final = style.AXIS_COLORS[0]
SIGHT_COLOR: Final = style.AXIS_COLORS[2]
SNAPSHOT: Final = 150.0
"""Time between two snapshots [s], as in figure 6 of the report."""

_SNAPSHOTS: Final = 9  # at the most, beside the last one


class Flown(FlownRun, Protocol):
    """One run."""

    @property
    def trajectory(self) -> DockingFlight:
        """What was flown."""

    @property
    def scenario(self) -> Scenario | None:
        """What flew; None: not known."""

    @property
    def telemetry(self) -> Telemetry:
        """What its bag tells."""


def offset(flight: DockingFlight) -> Array:
    """Return the port offset (n + 1, 3) of the states, chief frame [m]."""
    return states(flight)[1]


def distance(flight: DockingFlight) -> Array:
    """Return the distance (n + 1,) between the ports [m]."""
    return np.asarray(np.linalg.norm(offset(flight), axis=1))


def angle_deg(flight: DockingFlight) -> Array:
    """Return the angle (n + 1,) between deputy and chief [deg]."""
    return np.degrees(angles(states(flight)[2]))


def rotation_deg(flight: DockingFlight) -> Array:
    """Return the rotation vectors (n + 1, 3), deputy to chief [deg], without jumps."""
    return np.degrees(rotation_vectors(states(flight)[2]))


def reference_offset(flight: DockingFlight) -> Array:
    """Return the port offset (n + 1, 3) asked for, held over each step [m]."""
    return held(flight.reference[:, :3])


def reference_deg(flight: DockingFlight) -> Array:
    """Return the rotation vector (n + 1, 3) asked for, held over each step [deg]."""
    return np.degrees(held(flight.reference[:, 3:]))


def short_of_target(flight: DockingFlight) -> Array:
    """Return how far (n,) the reference is from the target [m]."""
    return np.asarray(np.linalg.norm((flight.reference - flight.target)[:, :3], axis=1))


def slack_percent(flight: DockingFlight) -> Array:
    """Return the slack (n,) of the admissible set [% of a row's room], without its rounding."""
    return np.round(100.0 * flight.slack, 4)


def force(flight: DockingFlight) -> Array:
    """Return the force (n + 1, 3) commanded, held over each step [N]."""
    return held(flight.force)


def moment(flight: DockingFlight) -> Array:
    """Return the moment (n + 1, 3) commanded, held over each step [N m]."""
    return held(flight.moment)


def limit_of(scenario: Scenario | None, name: str) -> float:
    """Return a limit of the plant; 0: not known."""
    return 0.0 if scenario is None else float(getattr(scenario.plant, name))


class Event(NamedTuple):
    """Something that happened."""

    time: float
    """[s]"""
    text: str
    is_bad: bool


def events(flight: DockingFlight) -> list[Event]:
    """Return losses of thrusters, their detection, changes of phase, and missing references."""
    found = [*_thruster_events(flight), *_phase_events(flight), *_answer_events(flight)]
    found.sort(key=lambda event: event.time)
    return [_together(list(same)) for _, same in groupby(found, lambda event: event.time)]


def _together(same: list[Event]) -> Event:
    """Return what happened at one time."""
    bad = any(event.is_bad for event in same)
    return Event(same[0].time, ", ".join(event.text for event in same), bad)


def _thruster_events(flight: DockingFlight) -> Iterator[Event]:
    found = loss(flight.time, flight.thrusters, flight.lost_thruster)
    if found.thruster_lost_at is not None:
        yield Event(found.thruster_lost_at, f"{found.thruster_lost} lost", True)
    if found.thruster_loss_detected_at is not None:
        yield Event(found.thruster_loss_detected_at, "noticed", False)
    for alarm in found.false_alarms:
        yield Event(alarm["at"], f"false alarm {alarm['thruster']}", True)


def _phase_events(flight: DockingFlight) -> Iterator[Event]:
    """Yield when it gave up, and when it was at the hold point."""
    for row in np.flatnonzero(np.diff(flight.phase, prepend=int(Phase.DOCKING))):
        if 0 <= flight.phase[row] < len(Phase):
            yield Event(float(flight.time[row]), phase_name(int(flight.phase[row])), False)


def _answer_events(flight: DockingFlight) -> Iterator[Event]:
    """Yield the first step of each stretch without an admissible reference."""
    without = (flight.status >= Answer.INFEASIBLE) & (flight.status <= Answer.LEAST_VIOLATION)
    for row in np.flatnonzero(np.diff(without.astype(int), prepend=0) > 0):
        yield Event(float(flight.time[row]), "no admissible reference", True)


def marks(flight: DockingFlight) -> list[Mark]:
    """Return `events` as diagrams show them."""
    colors = {True: style.LIMIT_COLOR, False: style.INK}
    return [Mark(e.time, e.text, colors[e.is_bad], e.is_bad) for e in events(flight)]


def bodies(run: Flown) -> list[Body]:
    """Return chief and deputy in the chief frame; empty where their sizes are not known."""
    if run.scenario is None:
        return []
    p, (times, rho, attitude) = run.scenario.plant, states(run.trajectory)
    n = len(times)
    still = np.broadcast_to(np.eye(3), (n, 3, 3))
    return [
        Body("chief", CHIEF_COLOR, p.chief_size, p.chief_port, np.zeros((n, 3)), still),
        Body(
            "deputy", DEPUTY_COLOR, p.deputy_size, p.deputy_port,
            deputy_center(p.chief_port, p.deputy_port, rho, attitude), attitude,
        ),
    ]  # fmt: skip


def sight(plant: PlantParameters, length: float) -> Array:
    """Return the corners (8, 3) of the line-of-sight pyramid up to ``length`` [m] from the port.

    Its base comes first; the deputy's port has to stay in it.
    """
    tangent = math.tan(math.radians(plant.line_of_sight_half_angle_deg))
    along = 0.5 * length * (1.0 + CORNERS[:, :1])
    width = tangent * along + plant.line_of_sight_slack
    return np.asarray(plant.chief_port + np.hstack([along, width * CORNERS[:, 1:]]))


def reach(run: Flown) -> float:
    """Return the length of the pyramid that is drawn [m]: somewhat more than is flown."""
    farthest = float(np.nanmax(offset(run.trajectory)[:, 0], initial=1.0))
    return 1.1 * farthest


def snapshot_rows(run: Flown) -> list[int]:
    """Return the states every `SNAPSHOT` seconds, or a multiple, and the last one; some ten."""
    times = run.times - run.times[0]
    every = SNAPSHOT * max(1, math.ceil(times[-1] / SNAPSHOT / _SNAPSHOTS))
    wanted = np.arange(0.0, times[-1] + 1e-9, every)
    return sorted({*np.searchsorted(times, wanted - 1e-9).tolist(), len(times) - 1})


def chief_attitudes(run: Flown) -> Array:
    """Return the attitude (n + 1, 3, 3) of the chief, chief to Hill's frame."""
    if run.scenario is None:
        return np.broadcast_to(np.eye(3), (len(run.times), 3, 3))
    p = run.scenario.plant
    start = lie.exp(p.chief_initial_rotation_vector)
    chief = ChiefMotion(p.mean_motion, p.chief_spin_rate, p.chief_spin_axis, start)
    return chief.attitudes(run.times)


def port_path(run: Flown) -> Array:
    """Return the path (n + 1, 3) of the deputy's port in the chief frame [m]."""
    port = np.zeros(3) if run.scenario is None else run.scenario.plant.chief_port
    return np.asarray(port + offset(run.trajectory))
