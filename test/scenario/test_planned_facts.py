"""What `gnc check` tells of a scenario that flies plans."""

from __future__ import annotations

import pytest

from spacecraft_gnc.scenario import load
from spacecraft_gnc.vehicles.rigid_body.facts import facts
from spacecraft_gnc.vehicles.rigid_body.outlook import outlook

GOVERNED = ("nmpc_controller.method=shooting", "reference_governor.governor=planned")


def test_the_plan_of_figure_4():
    scenario = load("phogat_figure4")
    told = facts(scenario, outlook(scenario, cut_short=False))
    rows = dict(told.rows)
    assert rows["bounds"] == "torque +-20 N m, momentum +-70 N m s"
    assert rows["plan"] == (
        "19 s, cost 20965.95496 N^2 m^2; "
        "bounds that act: torque y, torque z, momentum y, momentum z"
    )
    assert "torque limit" not in rows
    assert rows["settling"] == "at rest at the target from 19 s, the end of the plan"
    assert told.numbers["plan_cost"] == pytest.approx(20965.95496, abs=1e-5)
    assert told.numbers["plan_active"] == ["torque y", "torque z", "momentum y", "momentum z"]
    assert told.numbers["predicted_settling_time"] == 19.0


def test_a_plan_without_bounds():
    nothing = ["torque_bounds=[]", "momentum_bounds=[]"]
    scenario = load("phogat_figure4", [f"nmpc_controller.plan.{one}" for one in nothing])
    rows = dict(facts(scenario, outlook(scenario, cut_short=False)).rows)
    assert rows["bounds"] == "none"
    assert rows["plan"].endswith("bounds that act: none")


def test_a_plan_of_the_governor():
    bounds = ("reference_governor.plan.torque_bounds=[15.0]", "reference_governor.plan.duration=19")
    scenario = load("phogat_figure4", [*GOVERNED, *bounds])
    told = facts(scenario, outlook(scenario, cut_short=False))
    assert dict(told.rows)["bounds"] == "torque +-15 N m"
    assert told.numbers["plan_duration"] == 19.0
    assert "torque y" in told.numbers["plan_active"]


def test_a_flight_that_ends_before_its_plan():
    scenario = load("phogat_figure4", ["plant.duration=12.0"])
    (warning,) = outlook(scenario, cut_short=False).warnings
    assert "plant.duration: received 12 s; required at least 19 s, the time of the plan" in warning
    assert outlook(scenario, cut_short=True).warnings == ()


@pytest.mark.parametrize(
    ("sets", "words"),
    [
        ({}, ()),
        ({"plant.constant_torque": [0.1] * 3}, ()),  # not among the disturbances
        (
            {"plant.disturbances": ["constant"], "plant.constant_torque": [0.1] * 3},
            ("torque_reserve and momentum_reserve 0 beside disturbance constant;",),
        ),
        (
            {
                "plant.inertia": [840.0, 0.0, 0.0, 0.0, 1260.0, 0.0, 0.0, 0.0, 1050.0],
                "nmpc_controller.plan.torque_reserve": 0.05,
                "nmpc_controller.plan.duration": 20.0,
                "nmpc_controller.inertia": [800.0, 0.0, 0.0, 0.0, 1200.0, 0.0, 0.0, 0.0, 1000.0],
            },
            ("plan: received momentum_reserve 0 beside an inertia other than believed;",),
        ),
    ],
)  # fmt: skip
def test_a_body_that_is_not_as_believed_needs_a_reserve(sets, words):
    told = outlook(load("phogat_figure4", sets), cut_short=False).warnings
    assert len(told) == len(words)
    for line, part in zip(told, words, strict=True):
        assert part in line


@pytest.mark.parametrize("name", ["phogat_y90", "phogat_figure4_disturbed", "phogat_replanned"])
def test_the_shipped_ones_have_theirs(name):
    assert outlook(load(name), cut_short=False).warnings == ()


def test_a_scenario_without_a_plan_has_none():
    scenario = load("gupta2015_case1")
    told = facts(scenario, outlook(scenario, cut_short=False))
    assert told.numbers["plan_cost"] is None
    assert not {"plan", "bounds"} & set(dict(told.rows))
