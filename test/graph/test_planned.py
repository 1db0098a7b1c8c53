"""Plans flown by the controller and by the governor: graphs of processes, their bags and audits."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from graph.comparison import CASE1, assert_equals_simulation
from graph.test_governed import PATIENCE, Operator, about_x
from graph.test_wheels import messages
from rclpy.action import ActionClient
from spacecraft_gnc_msgs.action import SlewTo

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.analysis.reader import read_flight
from spacecraft_gnc.governors.planned.report import Cause, Phase
from spacecraft_gnc.launcher.outcome import Interrupted
from spacecraft_gnc.scenario import load

pytestmark = pytest.mark.graph

FIGURE4 = CASE1.parent / "phogat_figure4.yaml"
REPLANNED = CASE1.parent / "phogat_replanned.yaml"
LONG = pytest.mark.long
REPLANS = {
    "phogat_figure4": 0,
    "phogat_y90": 0,
    "phogat_figure4_disturbed": 0,
    "phogat_replanned": 1,
}
"""Shipped scenarios -> further plans, at least."""
GOVERNED = (
    "nmpc_controller.method=shooting",
    "reference_governor.governor=planned",
    "reference_governor.plan.duration=19.0",
    "reference_governor.plan.torque_bounds=[20.0]",
    "reference_governor.plan.momentum_bounds=[70.0]",
)
"""Figure 4, planned by the governor and tracked by the NMPC."""


class Slew(Operator):
    """Commands one other target while the graph flies, and waits until it is reached."""

    def command(self) -> None:
        self.action = ActionClient(self.node, SlewTo, "slew_to")
        assert self.action.wait_for_server(PATIENCE)
        self.first = self.result(self.send("first", about_x(40.0)))
        self.action.destroy()


def require_whole(out: Path, *, ended: bool = False) -> Any:
    """Return the flight of a run whose audit passes and whose every step tells of its plan.

    ``ended`` by a signal, it is shorter than its scenario says.
    """
    audit = audit_bag(out, allow_unfinished=ended)
    assert audit.passed, audit.first
    flight: Any = read_flight(out / "bag").trajectory
    # A governor answers the last state too.
    told = messages(out / "bag", "/plan_status")[: flight.n_steps]
    assert [message.step for message in told] == list(range(flight.n_steps))
    np.testing.assert_array_equal([message.number for message in told], flight.plan)
    np.testing.assert_array_equal([message.phase for message in told], flight.plan_phase)
    assert flight.plan_phase[-1] == Phase.ARRIVED
    return flight


@pytest.mark.parametrize(
    "name",
    [
        name if name in ("phogat_figure4", "phogat_replanned") else pytest.param(name, marks=LONG)
        for name in REPLANS
    ],
)
def test_a_flight_is_that_of_simulate_and_its_audit_passes(graph: Any, name: str) -> None:
    scenario = CASE1.parent / f"{name}.yaml"
    out = graph.fly(scenario=scenario)
    assert set(graph.exit_codes.values()) == {0}
    assert_equals_simulation(out / "bag", scenario=scenario)
    flight = require_whole(out)
    plans = messages(out / "bag", "/attitude_plan")
    assert [plan.number for plan in plans] == list(range(len(plans)))
    assert len(plans) == int(flight.plan.max()) + 1 >= REPLANS[name] + 1
    assert plans[0].cause == Cause.START
    assert all(plan.status == 0 and plan.cause == Cause.DEVIATION for plan in plans[1:])
    for plan in plans:
        assert plan.step == plan.first_step == np.argmax(flight.plan == plan.number)
    metrics = summarize(flight, read_flight(out / "bag").info.scenario)
    assert metrics["final_error_deg"] < 0.5
    assert metrics["limits_exceeded"] == []
    assert metrics["max_bound_use"] <= 1.0 + 1e-9


def test_a_plan_of_the_governor_leads_the_controller(graph: Any) -> None:
    out = graph.fly(*GOVERNED, scenario=FIGURE4)
    assert set(graph.exit_codes.values()) == {0}
    assert_equals_simulation(out / "bag", *GOVERNED, scenario=FIGURE4)
    flight = require_whole(out)
    (plan,) = messages(out / "bag", "/attitude_plan")
    np.testing.assert_array_equal(plan.torques, flight.plan_torque[:190].ravel())
    np.testing.assert_allclose(flight.torque[:190], flight.plan_torque[:190], atol=1e-8)
    assert flight.plan_error.max() < 1e-12


def test_in_free_run_another_plan_is_taken_when_it_is_there(graph: Any) -> None:
    """The flight does not wait for it, and ends as it should."""
    free = ("plant.mode=free_run", "plant.real_time_factor=4.0")
    out = graph.fly(*free, scenario=REPLANNED)
    assert set(graph.exit_codes.values()) == {0}
    flight: Any = read_flight(out / "bag").trajectory
    plans = messages(out / "bag", "/attitude_plan")
    assert len(plans) == int(flight.plan.max()) + 1 >= 2
    assert all(plan.step >= plan.first_step for plan in plans)
    asked = int(np.argmax(flight.plan_phase == Phase.REPLANNING))
    assert plans[1].first_step >= asked + 5  # plan.replan_lead
    metrics = summarize(flight, read_flight(out / "bag").info.scenario)
    assert metrics["final_error_deg"] < 0.5
    assert metrics["plan_end_time"] is not None


@pytest.mark.parametrize("overrides", [(), GOVERNED], ids=["method", "governor"])
def test_a_target_in_flight_is_planned_for(graph: Any, at: Any, overrides: tuple[str, ...]) -> None:
    operator = Slew()
    out: Path = graph.folder / "slew"
    endless = "plant.duration=4000.0"
    with pytest.raises(Interrupted):
        graph.fly(*overrides, endless, scenario=FIGURE4, display=at(30, operator), out=out)
    assert operator.first.reached
    plans = messages(out / "bag", "/attitude_plan")
    assert [plan.cause for plan in plans] == [Cause.START, Cause.TARGET]
    goal = plans[1].goal.reshape(3, 3)
    assert lie.angle_between(goal, about_x(40.0)) < 1e-9
    flight = require_whole(out, ended=True)
    tolerance = math.radians(load(FIGURE4).governor.slew_tolerance_deg)  # it settles as it is ended
    assert lie.angle_between(flight.attitude[-1], goal) < tolerance
