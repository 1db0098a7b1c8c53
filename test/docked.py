"""Docking flights written by hand, shared by the tests: no dynamics, known numbers."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.scenario import from_sections
from spacecraft_gnc.vehicles.docking.flight import DockingFlight
from spacecraft_gnc.vehicles.docking.report import REPORT
from spacecraft_gnc.vehicles.docking.summary import metrics as summarized

PERIOD = 5.0  # [s]
START = np.array([20.0, 4.0, -3.0])  # [m]
TURNED = np.array([0.3, -0.2, 0.25])  # [rad]
SECTIONS = {
    "plant": {
        "vehicle": "docking",
        "initial_port_offset": START.tolist(),
        "initial_rotation_vector": TURNED.tolist(),
        "duration": 300.0,
    },
    "nmpc_controller": {"time_step": PERIOD},
    "reference_governor": {},
}


def scenario(**changes):
    """Return the scenario of the flights, with some values changed by section name."""
    return from_sections({name: {**SECTIONS[name], **changes.get(name, {})} for name in SECTIONS})


def flight(n=60, **changes):
    """Return an approach that decays to the dock, with some columns changed.

    The offset is `START` times (1 - k / n)^2, the rotation vector `TURNED` times the same, so that
    both end at zero; the reference leads by a quarter of the flight.
    """
    share = (1.0 - np.arange(n + 1) / n) ** 2
    lead = np.clip(1.0 - (np.arange(n) + 0.25 * n) / n, 0.0, None) ** 2
    offset, vector = np.outer(share, START), np.outer(share, TURNED)
    attitude = np.stack([lie.exp(v) for v in vector])
    speed = np.gradient(offset, PERIOD, axis=0)
    turn = np.gradient(vector, PERIOD, axis=0)
    margin = np.tan(np.radians(30.0)) * offset[:, 0] + 0.05 - np.abs(offset[:, 1])
    values = {
        "port_offset": offset[:n],
        "port_velocity": speed[:n],
        "attitude": attitude[:n],
        "angular_velocity": turn[:n],
        "measured_port_offset": offset[:n],
        "measured_port_velocity": speed[:n],
        "measured_attitude": attitude[:n],
        "measured_angular_velocity": turn[:n],
        "force": np.outer(np.cos(np.pi * np.arange(n) / n), [-0.8, 0.2, 0.1]),
        "moment": np.outer(np.cos(np.pi * np.arange(n) / n), [0.01, -0.03, 0.02]),
        "reference": np.hstack([np.outer(lead, START), np.outer(lead, TURNED)]),
        "target": np.zeros((n, 6)),
        "line_of_sight_margin": margin[:n],
        "clearance": offset[:n, 0],
        "thrusters": np.ones((n, 6), dtype=bool),
        "status": np.zeros(n, dtype=int),
        "source": np.full(n, 5),
        "iterations": np.full(n, 7),
        "residual": np.full(n, 1e-9),
        "solve_time": np.linspace(1e-3, 3e-3, n),
        "slack": np.linspace(0.0, 0.5, n),
        "phase": np.zeros(n, dtype=int),
        "lost_thruster": np.full(n, -1),
        "response_error": np.zeros(n),
        "final_port_offset": offset[n],
        "final_port_velocity": speed[n],
        "final_attitude": attitude[n],
        "final_angular_velocity": turn[n],
        "final_line_of_sight_margin": np.array(margin[n]),
        "final_clearance": np.array(offset[n, 0]),
    }
    return DockingFlight(period=PERIOD, time=PERIOD * np.arange(n), **(values | changes))


def aborted(n=60):
    """Return one that loses a thruster at 100 s, finds out 10 s later and goes to hold at 10 m."""
    found = flight(n)
    k, at = np.arange(n), 20
    turned = np.clip((k - at - 2) / 25.0, 0.0, 1.0)[:, None]
    hold = np.array([10.0, 0.0, 0.0])
    offset = (1.0 - turned) * found.port_offset[np.minimum(k, at + 2)] + turned * hold
    thrusters = np.ones((n, 6), dtype=bool)
    thrusters[at:, 0] = False
    answered = k < at + 2
    phase = np.where(answered, 0, np.where(turned[:, 0] < 1.0, 1, 2))
    reference = found.reference.copy()
    reference[~answered] = [10.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    return flight(
        n, port_offset=offset, thrusters=thrusters, phase=phase, reference=reference,
        lost_thruster=np.where(answered, -1, 0), clearance=offset[:, 0],
        line_of_sight_margin=np.tan(np.radians(30.0)) * offset[:, 0] - np.abs(offset[:, 1]),
        final_port_offset=offset[-1], final_line_of_sight_margin=np.array(5.0),
        final_clearance=np.array(9.9),
    )  # fmt: skip


def run(name="flight", flown=None, known="docking", **metrics):
    """Return a run as figures and report take it."""
    flown = flight() if flown is None else flown
    found = scenario() if known == "docking" else known
    return SimpleNamespace(
        name=name,
        trajectory=flown,
        scenario=found,
        times=np.append(flown.time, flown.time[-1] + flown.period),
        telemetry=REPORT.telemetry(flown, found, None),
        metrics=summarized(flown, found) | {"missed_deadlines": None} | metrics,
    )
