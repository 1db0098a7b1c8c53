"""Replays of a flight with two wheels: the same, by the other solver, by the other models."""

from __future__ import annotations

import json

import numpy as np
import pytest
from two_wheels import two_wheels
from wheel_bags import fly

from spacecraft_gnc.cli.main import main
from spacecraft_gnc.scenario import from_sections
from spacecraft_gnc.vehicles.two_wheel.resolve import REPLAY

SHORT = {"duration": 200.0}


@pytest.fixture(scope="module")
def flight():
    return from_sections(two_wheels(plant=SHORT)).build().run()


def _replayed(flight, **controller):
    flown = from_sections(two_wheels(plant=SHORT))
    revised = from_sections(two_wheels(plant=SHORT, nmpc_controller=controller))
    resolved = REPLAY.resolve(flight, flown, revised)
    return resolved, REPLAY.compare(resolved, flown, revised)


def test_the_same_controller_gives_the_same_bits(flight):
    resolved, numbers = _replayed(flight)
    assert resolved.first_difference is None
    assert numbers["max_cost_difference"] == 0.0
    assert numbers["recorded"]["solved"] == numbers["replayed"]["solved"] == 20


def test_ipopt_finds_the_same_plans(flight):
    pytest.importorskip("casadi")
    _, numbers = _replayed(flight, solver="ipopt")
    assert numbers["replayed"]["method"] == "underactuated, so3, ipopt"
    assert numbers["replayed"]["solved"] == 20
    assert 0.0 < numbers["max_acceleration_difference"] < 1e-3
    assert numbers["max_cost_difference"] < 1e-6


def test_another_model_plans_something_else(flight):
    resolved, numbers = _replayed(flight, prediction_model="simplified")
    assert numbers["replayed"]["solved"] == 20
    assert resolved.difference.max() > 0.1
    assert np.isfinite(resolved.cost_difference)
    labels = [row[0] for row in REPLAY.sides(numbers["recorded"], numbers["replayed"])]
    assert "steps with a plan" in labels
    assert "difference of costs" in [row[0] for row in REPLAY.differences(numbers, 10.0)]


def test_the_command_replays_a_bag(tmp_path, capsys):
    bag, _ = fly(tmp_path, two_wheels(plant=SHORT))
    with pytest.raises(SystemExit) as ended:
        main(["replay", str(bag), "--json"])
    assert ended.value.code == 0
    numbers = json.loads(capsys.readouterr().out)
    assert json.dumps(numbers).count('"solved": 20') == 2
