"""NMPC beside a PD: what README, docs/reproduce.md and config/sun_moon*.yaml say of them."""

from __future__ import annotations

import numpy as np
import pytest

from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.scenario import load
from spacecraft_gnc.scenario.shipped import shipped
from spacecraft_gnc.vehicles.rigid_body import series

LIMIT = 0.01  # [N m]
SOFT = 2e-5  # share by which the penalty of the torque lets the norm pass the limit
PERIOD = 0.4  # [s]


def flown(name, overrides=()):
    scenario = load(shipped(name), overrides)
    flight = scenario.build().run()
    return flight, summarize(flight, scenario)


def test_the_governed_nmpc_stays_outside_and_never_turns_back():
    flight, metrics = flown("sun_moon")
    assert metrics["min_zone_margin_deg"] >= 0.0
    assert max(metrics["zone_margin_deg"].values()) < 0.01  # it passes both as near as it may
    assert metrics["max_torque"] <= LIMIT * (1.0 + SOFT)
    assert metrics["settle_time_0.1deg"] == pytest.approx(42.0, abs=PERIOD)
    assert np.diff(series.settling_error_deg(flight)).max() <= 0.0
    assert metrics["sources"] == {"OPTIMAL": 150}


def test_the_nmpc_alone_keeps_the_zones_as_far_as_its_penalty_does():
    _, metrics = flown("sun_moon", ["reference_governor.governor=none"])
    assert metrics["min_zone_margin_deg"] == pytest.approx(-0.05, abs=0.01)
    assert metrics["settle_time_0.1deg"] == pytest.approx(35.6, abs=PERIOD)


def test_the_pd_runs_through_both():
    flight, metrics = flown("sun_moon_pd")
    assert metrics["zone_margin_deg"] == pytest.approx({"sun": -12.39, "moon": -8.67}, abs=0.01)
    assert metrics["max_torque"] <= LIMIT * (1.0 + 1e-12)
    assert metrics["settle_time_0.1deg"] == pytest.approx(36.4, abs=PERIOD)
    assert np.diff(series.settling_error_deg(flight)).max() <= 0.0


def pd(omega, zeta):
    """Return the overrides for a PD of a natural frequency [rad/s] and a damping ratio."""
    attitude_gain = 0.5 * omega**2 * np.diag([1.0, 0.8, 0.8])
    return {
        "nmpc_controller.method": "feedback",
        "nmpc_controller.feedback_attitude_gain": attitude_gain.ravel(),
        "nmpc_controller.feedback_momentum_gain": (2.0 * zeta * omega * np.eye(3)).ravel(),
    }


def test_the_pd_behind_the_governor_keeps_both():
    overrides = {"reference_governor.governor": "attitude", **pd(0.38, 1.0)}
    _, metrics = flown("sun_moon_pd", overrides)
    assert metrics["min_zone_margin_deg"] >= 0.0
    assert metrics["settle_time_0.1deg"] == pytest.approx(46.0, abs=PERIOD)


@pytest.mark.parametrize(
    ("overrides", "under_1", "under_01", "cost"),
    [
        ({}, 105.2, None, 0.0551),
        ({"nmpc_controller.horizon": 40}, 20.8, 26.8, 0.0366),
        ({"nmpc_controller.method": "feedback"}, 29.2, 41.6, 0.0421),
        (pd(0.32, 0.8), 20.4, 25.6, 0.0366),
    ],
    ids=["paper", "N = 40", "PD", "tuned PD"],
)
def test_case_1_beside_a_pd(overrides, under_1, under_01, cost):
    weights = load(shipped("gupta2015_case1")).controller.weights
    flight, metrics = flown("gupta2015_case1", overrides)
    assert metrics["settle_time_1deg"] == pytest.approx(under_1)
    assert metrics["settle_time_0.1deg"] == (None if under_01 is None else pytest.approx(under_01))
    assert series.stage_costs(flight, weights).sum() == pytest.approx(cost, abs=5e-5)
