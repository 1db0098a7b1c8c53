"""The terminal-set NMPC in flight: the shipped scenarios, refusals, and what flies without it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from terminal_cases import REST, START, paper

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.loop import Source, State
from spacecraft_gnc.loop.protocols import Reference
from spacecraft_gnc.ocp import Status, TerminalSetSolver
from spacecraft_gnc.scenario import InvalidScenario, load
from spacecraft_gnc.vehicles.rigid_body.controllers.terminal_set.controller import (
    TerminalSetController,
)

CONFIG = Path(__file__).parents[2] / "config"


def fly(name, *overrides):
    scenario = load(CONFIG / f"{name}.yaml", overrides)
    trajectory = scenario.build().run()
    return trajectory, summarize(trajectory, scenario)


def target(attitude):
    return Reference(attitude, np.zeros(3), np.zeros(3))


def test_the_first_example_reaches_the_figures():
    """PAPER_NOTES: 5 deg for good from 56.2 s, 1 deg from 87.1 s; figure 6: |T| <= 0.02."""
    trajectory, summary = fly("kalabic2014_nmpc")
    assert summary["settle_time_5deg"] == pytest.approx(56.2, abs=0.05)
    assert summary["settle_time_1deg"] == pytest.approx(87.1, abs=0.05)
    assert np.linalg.norm(trajectory.torque, axis=1).max() <= 0.02
    assert set(trajectory.status) == {Status.CONVERGED}
    assert set(trajectory.source) == {Source.OPTIMAL}
    assert (np.diff(trajectory.cost) < 0.0).all()


@pytest.mark.parametrize(("name", "torque"), [("flip_plus", -12.83), ("flip_minus", 12.71)])
def test_the_second_example_turns_the_way_of_the_figures(name, torque):
    trajectory, summary = fly(f"kalabic2014_{name}")
    assert trajectory.torque[0, 2] == pytest.approx(torque, rel=5e-3)
    assert np.sign(trajectory.momentum[1:20, 2]) == pytest.approx(np.sign(torque))
    assert summary["final_error_deg"] < 0.2
    assert set(trajectory.status) == {Status.CONVERGED}


def test_the_printed_problem_flies_with_the_horizon_that_it_needs():
    trajectory, _ = fly(
        "kalabic2014_nmpc",
        "nmpc_controller.terminal_set=true",
        "nmpc_controller.horizon=251",
        "plant.duration=15.0",
    )
    assert set(trajectory.status) == {Status.CONVERGED}


def test_the_printed_problem_is_refused_with_what_would_do():
    scenario = load(CONFIG / "kalabic2014_nmpc.yaml", ["nmpc_controller.terminal_set=true"])
    with pytest.raises(InvalidScenario) as caught:
        scenario.build()
    for part in ("received true with horizon: 5", "37.82", "397.9", "horizon: 251"):
        assert part in str(caught.value)


@pytest.mark.parametrize(
    "override",
    [
        "weights.terminal_attitude=0.5",
        "weights.stage_momentum=0.5",
        "torque_penalty=1.0",
        "standstill_error_deg=1.0",
        "actuators=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]",
    ],
)
def test_what_it_does_not_read_is_refused(override):
    with pytest.raises(InvalidScenario, match="required a method that reads it"):
        load(CONFIG / "kalabic2014_nmpc.yaml", [f"nmpc_controller.{override}"])


@pytest.mark.parametrize(
    "override", ["terminal_set=false", "stage_cost_scale=0.2", "weights.stage_rate=1.0"]
)
def test_other_methods_do_not_read_its_parameters(override):
    with pytest.raises(InvalidScenario, match=r"reads it \(terminal_set\), not shooting"):
        load(CONFIG / "gupta2015_case1.yaml", [f"nmpc_controller.{override}"])


def test_out_of_reach_in_flight_the_ladder_answers():
    """Near the target the set is reached; a far target in flight is infeasible, and said so."""
    controller = TerminalSetController(TerminalSetSolver(paper()))
    controller.warm_up()
    near = lie.exp(np.array([0.0, 0.0, 0.2]))
    command = controller.command(State(0, near, REST), target(np.eye(3)))
    assert (command.source, command.status) == (Source.OPTIMAL, Status.CONVERGED)
    far = target(near @ START)
    shifted = controller.command(State(1, near, REST), far)
    assert (shifted.source, shifted.status) == (Source.SHIFTED_PLAN, Status.INFEASIBLE)
    for step in range(2, 7):  # the plan of five steps is used up
        late = controller.command(State(step, near, REST), far)
    assert (late.source, late.status) == (Source.FEEDBACK, Status.INFEASIBLE)
    assert 0.0 < np.linalg.norm(late.control) <= 0.02 * (1.0 + 1e-15)


def test_its_neighboring_extremal_is_that_of_its_own_problem():
    """Where one solve fails, the ladder corrects the plan as the next solve would have."""
    controller = TerminalSetController(TerminalSetSolver(paper(20, "without_kappa")))
    controller.warm_up()
    start = lie.exp(np.array([0.02, -0.03, 0.05]))
    plan = controller.command(State(0, start, REST), target(np.eye(3))).report.solution
    turned = plan.attitudes[1] @ lie.exp(np.array([1e-5, 2e-5, -1e-5]))
    failed = plan.replace(status=Status.MAX_ITERATIONS)
    ladder = controller._ladder
    state = State(1, turned, plan.momenta[1])
    corrected = ladder.command(state, target(np.eye(3)), failed)
    assert corrected.source is Source.NEIGHBORING_EXTREMAL
    late = TerminalSetSolver(paper(19, "without_kappa")).solve(turned, plan.momenta[1])
    assert corrected.control == pytest.approx(late.torques[0], abs=1e-9)
    assert math.isclose(plan.ocp.time_step, 0.1)
