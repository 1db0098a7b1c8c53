"""Flights in formation written by hand, shared by the tests: no dynamics, known numbers."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np

from spacecraft_gnc.scenario import from_sections
from spacecraft_gnc.vehicles.formation.decision import Answer
from spacecraft_gnc.vehicles.formation.flight import FormationFlight
from spacecraft_gnc.vehicles.formation.geometry import communication_angles_deg, separations
from spacecraft_gnc.vehicles.formation.hill import natural_states
from spacecraft_gnc.vehicles.formation.orbit import mean_motion, orbital_period
from spacecraft_gnc.vehicles.formation.report import REPORT
from spacecraft_gnc.vehicles.formation.summary import metrics as summarized

SAMPLES = 50
PERIOD = orbital_period(350.0e3) / SAMPLES  # [s]
NATURAL = natural_states(mean_motion(350.0e3), 1000.0, SAMPLES)
PHASES = (16, 0, 33)
OFFSETS = np.array([6000.0, -5000.0, 4000.0])  # [m] along the track at the start
SHIFTED = np.array([7, 3, 0])  # [control steps] until all are 7
AGREED = 30  # step from which on all shifts are 7


def scenario(n_craft=3, **changes):
    """Return the scenario of the flights, with some values changed by section name."""
    names = [f"sc{i + 1}" for i in range(n_craft)]
    start = {
        "initial_phase": list(map(float, PHASES[:n_craft])),
        "initial_along_track_offset": OFFSETS[:n_craft].tolist(),
        "initial_amplitude": [1.0] * n_craft,
    }
    sections = {
        "plant": {"vehicle": "formation", "spacecraft": names, "duration": 100.5 * PERIOD, **start},
        "nmpc_controller": {},
        "reference_governor": {"phase": list(PHASES[:n_craft])},
    }
    return from_sections({k: {**values, **changes.get(k, {})} for k, values in sections.items()})


def flight(n=100, n_craft=3, **changes):
    """Return a flight in which offsets along the track decay, with some columns changed.

    Craft i is `OFFSETS` times exp(-k / 10) off its place at step k; its delta-v points along the
    track, of size 0.8 exp(-k / 10) m/s.
    """
    k, craft = np.arange(n + 1), slice(n_craft)
    shift = np.where(k[:, None] < AGREED, SHIFTED[craft], SHIFTED[0])
    places = NATURAL[(k[:, None] + np.array(PHASES[craft]) + shift) % SAMPLES]
    decay = np.exp(-k / 10.0)
    position = places[..., :3].copy()
    position[..., 1] += decay[:, None] * OFFSETS[craft]
    delta_v = np.zeros((n, n_craft, 3))
    delta_v[..., 1] = 0.8 * decay[:n, None]
    unequal = (shift != shift[:, :1]).any(axis=1)[:n]
    shift_cost = np.where(unequal, 74.0, 0.0)
    values = {
        "position": position[:n],
        "velocity": places[:n, :, 3:],
        "delta_v": delta_v,
        "time_shift": shift[:n],
        "reference_position": places[:n, :, :3],
        "reference_velocity": places[:n, :, 3:],
        "separation": separations(position[:n]),
        "communication_angle_deg": communication_angles_deg(position[:n], places[:n, :, :3]),
        "healthy": np.ones((n, n_craft), dtype=bool),
        "lost": np.zeros((n, n_craft), dtype=bool),
        "status": np.zeros(n, dtype=int),
        "source": np.full(n, 5),
        "iterations": np.full(n, SAMPLES**n_craft),
        "residual": np.full(n, 1e-9),
        "solve_time": np.linspace(0.1, 0.3, n),
        "cost": shift_cost + 100.0 * decay[:n],
        "shift_cost": shift_cost,
        "state_cost": 100.0 * decay[:n],
        "n_admissible": np.full(n, 1000),
        "governor_margin": np.linspace(0.05, 0.2, n),
        "deadlocked": np.zeros(n, dtype=bool),
        "formed": (np.arange(n) > 70) & ~unequal,
        "final_position": position[n],
        "final_velocity": places[n, :, 3:],
    }
    return FormationFlight(period=PERIOD, time=PERIOD * np.arange(n), **(values | changes))


def lost(n=100, row=40, craft=1, found=43):
    """Return one in which a craft is lost at a step, which is concluded some steps later."""
    healthy, concluded = np.ones((n, 3), dtype=bool), np.zeros((n, 3), dtype=bool)
    healthy[row:, craft], concluded[found:, craft] = False, True
    return flight(n, healthy=healthy, lost=concluded)


def deadlocked(n=100):
    """Return one that is deadlocked at steps 35 to 49, then makes two passages of five steps."""
    k = np.arange(n)
    status = np.where((k >= 50) & (k < 60), Answer.PASSAGE, Answer.OPTIMAL)
    shift = flight(n).time_shift.copy()
    shift[35:50], shift[50:55] = [3, 7, 5], [3, 7, 7]
    return flight(n, deadlocked=(k >= 35) & (k < 50), status=status, time_shift=shift)


def run(name="flight", flown=None, known="formation", telemetry=None, **metrics):
    """Return a run as figures and report take it."""
    flown = flight() if flown is None else flown
    found = scenario(flown.n_craft) if known == "formation" else known
    return SimpleNamespace(
        name=name,
        trajectory=flown,
        scenario=found,
        times=np.append(flown.time, flown.time[-1] + flown.period),
        telemetry=REPORT.telemetry(flown, found, None) if telemetry is None else telemetry,
        metrics=summarized(flown, found) | {"missed_deadlines": None} | metrics,
    )


def missing(flown, step):
    """Return a flight that lost the messages of a step."""
    nothing = {}
    for name in (
        "position", "velocity", "delta_v", "reference_position", "reference_velocity", "separation",
        "communication_angle_deg", "cost", "shift_cost", "state_cost", "solve_time", "residual",
    ):  # fmt: skip
        nothing[name] = getattr(flown, name).copy()
        nothing[name][step] = math.nan
    nothing["status"], nothing["time_shift"] = flown.status.copy(), flown.time_shift.copy()
    nothing["status"][step] = nothing["time_shift"][step] = -1
    return flight(flown.n_steps, flown.n_craft, **nothing)
