"""What config/sun_moon.yaml and its PD claim: past two zones, or through them."""

from __future__ import annotations

import numpy as np
import pytest

from spacecraft_gnc.analysis import series
from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.scenario import load
from spacecraft_gnc.scenario.shipped import shipped

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
