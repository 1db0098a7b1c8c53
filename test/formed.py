"""Flights in formation written by hand, shared by the tests: no dynamics, known numbers."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from spacecraft_gnc.scenario import from_sections
from spacecraft_gnc.vehicles.formation.decision import Answer
from spacecraft_gnc.vehicles.formation.flight import FormationFlight
from spacecraft_gnc.vehicles.formation.geometry import communication_angles_deg, separations
from spacecraft_gnc.vehicles.formation.orbit import orbital_period
from spacecraft_gnc.vehicles.formation.summary import metrics as summarized

PERIOD = orbital_period(350.0e3) / 50.0  # [s]
STEPS = 60
PLACES = np.array([[4000.0, 0.0, 0.0], [0.0, 3000.0, 0.0], [0.0, -3000.0, 0.0]])  # [m]
START = np.array([[-3000.0, 0.0, 0.0], [0.0, 1000.0, 0.0], [0.0, 0.0, 500.0]])  # off these [m]
SECTIONS = {
    "plant": {
        "vehicle": "formation",
        "initial_along_track_offset": [6103.0, 8325.0, 5036.0],
        "initial_amplitude": [1.53, 1.705, 0.877],
        "duration": (STEPS + 0.5) * PERIOD,
    },
    "nmpc_controller": {},
    "reference_governor": {},
}


def scenario(**changes):
    """Return the scenario of the flights, with some values changed by section name."""
    return from_sections({name: {**SECTIONS[name], **changes.get(name, {})} for name in SECTIONS})


def flight(n=STEPS, **changes):
    """Return a flight whose craft close in on places at rest, with some columns changed.

    The position errors are `START` times (1 - k / n)^2, and the shifts of all craft equal from
    step n / 2 on.
    """
    k = np.arange(n + 1)
    share = (1.0 - k / n) ** 2
    position = changes.pop("all_positions", PLACES + share[:, None, None] * START)
    velocity = np.gradient(position, PERIOD, axis=0)
    wanted = np.tile(PLACES, (n, 1, 1))
    delta_v = np.outer(1.0 - k[:n] / n, [0.9, 0.3, 0.0])[:, :, None] * [0.6, 0.0, -0.8]
    ahead = k[:n, None] < n // 2
    values = {
        "position": position[:n],
        "velocity": velocity[:n],
        "delta_v": delta_v,
        "time_shift": np.where(ahead, [7, 3, 49], 3),
        "reference_position": wanted,
        "reference_velocity": np.zeros((n, 3, 3)),
        "separation": separations(position[:n]),
        "communication_angle_deg": communication_angles_deg(position[:n], wanted),
        "healthy": np.ones((n, 3), dtype=bool),
        "lost": np.zeros((n, 3), dtype=bool),
        "status": np.zeros(n, dtype=int),
        "source": np.full(n, 5),
        "iterations": np.full(n, 125000),
        "residual": np.zeros(n),
        "solve_time": np.linspace(1e-3, 3e-3, n),
        "cost": share[:n] + 100.0 * ahead[:, 0],
        "shift_cost": 100.0 * ahead[:, 0],
        "state_cost": share[:n],
        "n_admissible": np.full(n, 700),
        "governor_margin": np.linspace(0.01, 0.5, n),
        "deadlocked": np.zeros(n, dtype=bool),
        "formed": np.zeros(n, dtype=bool),
        "final_position": position[n],
        "final_velocity": velocity[n],
    }
    return FormationFlight(period=PERIOD, time=PERIOD * np.arange(n), **(values | changes))


def loss(n=STEPS, at=20, noticed=22):
    """Return one whose last craft is lost at a step, is found lost later, and drifts away."""
    k = np.arange(n + 1)[:, None]
    found = flight(n)
    position = np.concatenate([found.position, found.final_position[None]])
    drift = np.maximum(k - at, 0) * [0.0, -50.0, 0.0]
    position[:, 2] = np.where(k >= at, position[at, 2] + drift, position[:, 2])
    healthy, lost = np.ones((2, n, 3), dtype=bool)
    healthy[at:, 2], lost[:] = False, False
    lost[noticed:, 2] = True
    delta_v = found.delta_v.copy()
    delta_v[at:, 2] = [0.0, 5.0, 0.0]  # what its controller asks for in vain
    return flight(n, all_positions=position, healthy=healthy, lost=lost, delta_v=delta_v)


def parked(n=STEPS, resolved=True):
    """Return one that parks in another formation at step n / 3, and gets out by two passages."""
    status, flags = np.zeros(n, dtype=int), np.zeros(n, dtype=bool)
    shift = np.tile([7, 3, 49], (n, 1))
    begun, way, end = n // 3, n // 2, 2 * n // 3
    flags[begun : way if resolved else n] = True
    if resolved:
        status[way:end], shift[way:end] = Answer.PASSAGE, [5, 3, 1]
        status[end : end + 5], shift[end:] = Answer.PASSAGE, [3, 3, 3]
    return flight(n, status=status, deadlocked=flags, time_shift=shift)


def run(name="flight", flown=None, **metrics):
    """Return a run as figures and report take it."""
    flown = flight() if flown is None else flown
    found = scenario()
    return SimpleNamespace(
        name=name,
        trajectory=flown,
        scenario=found,
        times=np.append(flown.time, flown.time[-1] + flown.period),
        metrics=summarized(flown, found) | {"missed_deadlines": None} | metrics,
    )
