"""Nodes that keep to wall time wait for no plan."""

from __future__ import annotations

import pytest

from spacecraft_gnc.nodes._worker import pace_core
from spacecraft_gnc.scenario import load


@pytest.mark.parametrize(("mode", "waits"), [("lockstep", True), ("free_run", False)])
def test_a_plan_is_waited_for_in_lockstep_only(mode, waits):
    scenario = load("phogat_replanned", {"plant.mode": mode})
    controller = scenario.build_controller()
    pace_core(controller, scenario)
    assert controller.waits is controller.keeper.waits is waits


def test_what_computes_nothing_beside_its_commands_is_left_alone():
    scenario = load("gupta2015_case1", {"plant.mode": "free_run"})
    controller = scenario.build_controller()
    pace_core(controller, scenario)
    assert not hasattr(controller, "waits")
