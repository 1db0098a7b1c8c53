"""Flights and scenarios for the tests of metrics and figures."""

from __future__ import annotations

from pathlib import Path

import case_1
import numpy as np

from spacecraft_gnc.scenario import from_sections
from spacecraft_gnc.vehicles.rigid_body.flight import RigidBodyFlight

DATA = Path(__file__).parents[1] / "data"
PERIOD = 0.4  # [s]


def trajectory(attitude, momentum, torque, **replaced):
    """Return a flight of n steps from n + 1 states, solved without trouble."""
    n = len(torque)
    fields = {
        "period": PERIOD,
        "time": PERIOD * np.arange(n),
        "attitude": attitude[:-1],
        "momentum": momentum[:-1],
        "torque": torque,
        "external_torque": np.zeros((n, 3)),
        "reference": np.tile(np.eye(3), (n, 1, 1)),
        "reference_rate": np.zeros((n, 3)),
        "reference_torque": np.zeros((n, 3)),
        "target": np.tile(np.eye(3), (n, 1, 1)),
        "iterations": np.full(n, 2),
        "residual": np.full(n, 1e-13),
        "cost": np.full(n, 0.01),
        "solve_time": np.linspace(3e-5, 6e-5, n),
        "status": np.zeros(n, dtype=np.int64),
        "source": np.zeros(n, dtype=np.int64),
        "alpha": np.ones(n),
        "governor_margin": np.full(n, np.inf),
        "plan": np.full(n, -1),
        "plan_phase": np.full(n, -1),
        "plan_error": np.full(n, np.nan),
        "plan_torque": np.full((n, 3), np.nan),
        "plan_momentum": np.full((n, 3), np.nan),
        "final_attitude": attitude[-1],
        "final_momentum": momentum[-1],
        "final_reference": np.eye(3),
    }
    return RigidBodyFlight(**{**fields, **replaced})


def case1():
    """Return Case I of Gupta et al. (2015) as CasADi and IPOPT fly it."""
    with np.load(DATA / "gupta2015_case1_ipopt.npz") as stored:
        return trajectory(stored["attitude"], stored["momentum"], stored["torque"])


def at_rest(n=20, **replaced):
    """Return a flight that stays at its reference."""
    zero = np.zeros((n + 1, 3))
    return trajectory(np.tile(np.eye(3), (n + 1, 1, 1)), zero, zero[:-1], **replaced)


def scenario(zones=None, **controller):
    """Return Case I's scenario, with pointing zones by name."""
    zones = zones or {}
    section = {"zone_names": list(zones), "zones": zones, **case_1.controller(**controller)}
    return from_sections({"plant": case_1.PLANT, "nmpc_controller": section})


def zone(axis, half_angle_deg, kind="exclusion"):
    """Return the parameters of a zone for the body x axis."""
    return {
        "kind": kind,
        "body_axis": [1.0, 0.0, 0.0],
        "inertial_axis": list(axis),
        "half_angle_deg": half_angle_deg,
    }
