"""Flights of random spacecraft by every method: none that is what it says fails an audit."""

from __future__ import annotations

import numpy as np
import pytest
from flown_bags import fly, sections

from spacecraft_gnc.analysis.audit import audit_bag

METHODS = ("shooting", "neighboring_extremal", "fsolve")


def random_flight(seed):
    """Return the sections of a flight of 15 steps; of three solves, some fail in many of them."""
    rng = np.random.default_rng(seed)
    moment, step = 10.0 ** rng.uniform(-4, 4), float(rng.choice([0.1, 0.4, 1.0]))
    horizon, method = int(rng.choice([1, 2, 5, 10, 30])), METHODS[seed % len(METHODS)]
    torque = moment / (step * horizon) ** 2  # turns the body by about a radian in the horizon
    axis = rng.normal(size=3)
    weights = {
        "stage_attitude": float(10.0 ** rng.uniform(-3, 1)),
        "terminal_attitude": float(10.0 ** rng.uniform(-3, 1)),
        "stage_momentum": float(10.0 ** rng.uniform(-3, 0) / moment**2),
        "terminal_momentum": float(10.0 ** rng.uniform(-3, 0) / moment**2),
        "stage_torque": float(10.0 ** rng.uniform(-4, -1) / torque**2),
    }
    limit = float(torque * 10.0 ** rng.uniform(-2, 1)) if rng.random() < 0.8 else 0.0
    controller = {
        "method": method, "horizon": horizon, "weights": weights, "max_torque": limit,
    }  # fmt: skip
    if limit > 0.0:
        share = 10.0 ** rng.uniform(0, 6)
        controller["torque_penalty"] = float(weights["stage_torque"] / limit**2 * share)
    if method != "fsolve":
        controller["max_iterations"] = int(rng.choice([2, 4, 50]))
        controller["continuation"] = str(rng.choice(["none", "penalty", "state"]))
        controller["step_rule"] = str(rng.choice(["backtracking", "full", "chord"]))
    if rng.random() < 0.3:
        star = {
            "body_axis": [1.0, 0.0, 0.0],
            "inertial_axis": [-1.0, *rng.normal(size=2).tolist()],
            "half_angle_deg": float(rng.uniform(2, 25)),
            "penalty": float(weights["stage_attitude"] * 10.0 ** rng.uniform(0, 5)),
        }
        controller |= {"zone_names": ["star"], "zones": {"star": star}}
    plant = {
        "inertia": (moment * np.diag([1.0, 0.8, 0.7])).ravel().tolist(),
        "time_step": step,
        "duration": 15.0 * step,
        "initial_rotation_vector": (axis / np.linalg.norm(axis) * rng.uniform(0, 3)).tolist(),
        "initial_momentum": (rng.normal(size=3) * moment * 10.0 ** rng.uniform(-3, -1)).tolist(),
    }
    return sections(plant=plant, nmpc_controller=controller, launcher={"cut_short": True})


@pytest.mark.parametrize("seed", range(36))
def test_a_flight_that_is_what_it_says_passes(tmp_path, seed):
    audit = audit_bag(fly(tmp_path, random_flight(seed)))
    assert audit.passed, audit.first
    counts = audit.counts
    assert counts.failures_confirmed == counts.solves_repeated
    assert counts.fallbacks_justified == counts.fallbacks
    assert counts.standstills_found == counts.standstills_reported
