"""An audit of flights along plans follows them, whatever becomes of the plans."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from flown_bags import edited, fly, messages_of, rewrite
from planned_bags import (
    INERTIA,
    KEPT,
    NS,
    OTHER_TARGET,
    failed,
    fly_planned,
    governed,
    lines,
    moved,
    planned,
)

from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.governors.planned import keeper
from spacecraft_gnc.ocp.transfer import TransferSolver
from spacecraft_gnc.ocp.transfer.starts import STRAIGHT, make_start
from spacecraft_gnc.scenario import from_sections
from spacecraft_gnc.status import Status
from spacecraft_gnc.vehicles.rigid_body.controllers.planned.controller import PlannedController
from spacecraft_gnc.vehicles.rigid_body.metrics.limits import limits_exceeded
from spacecraft_gnc.vehicles.rigid_body.planner import keeper as plan_keeper
from spacecraft_gnc.vehicles.rigid_body.planner.file import save_plan
from spacecraft_gnc.vehicles.rigid_body.planner.transfer import first_plan, transfer_of

STEPS = 120


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return fly_planned(tmp_path_factory.mktemp("planned"))


def test_what_was_flown_passes(bag):
    taken = [stamp // NS for topic, stamp, _ in messages_of(bag) if topic == "/attitude_plan"]
    audit = audit_bag(bag)
    assert audit.passed, audit.first
    found = lines(audit)
    assert taken[0] == 0
    assert 34 < taken[1] < 44
    assert len(taken) == 2
    assert found["plan of a transfer: co-momenta"].steps == 2
    assert found["plan of a transfer: curvature where no bound acts"].steps == 2
    assert found["phase of the plan"].steps == STEPS
    assert found[KEPT].steps == STEPS
    assert found["cost"].steps == STEPS
    assert audit.exceeded == ()


def test_a_plant_of_shorter_steps_passes(tmp_path):
    audit = audit_bag(fly(tmp_path, planned(plant={"time_step": 0.05})))
    assert audit.passed, audit.first


def test_commands_on_a_bound_are_told(bag):
    note = lines(audit_bag(bag))[KEPT].note
    assert 0 < int(note.split()[2]) < STEPS


def test_a_body_on_its_plan_passes(tmp_path):
    """Nothing is left for the tracking to do: what it costs is rounding."""
    plant = {"inertia": INERTIA, "disturbances": []}
    audit = audit_bag(fly(tmp_path, planned(plant=plant)))
    assert audit.passed, audit.first
    assert lines(audit)["plan of a transfer: cost"].steps == 1


def test_a_saddle_is_no_plan(tmp_path, monkeypatch):
    """The eigenaxis plan keeps the first-order conditions only, whatever is told of it."""

    def straight(scenario):
        problem = transfer_of(scenario)
        start = make_start(problem, STRAIGHT)
        found = TransferSolver().solve(problem, (start.torque, start.momentum))
        assert found.status == Status.SADDLE
        return replace(found, status=Status.CONVERGED, min_curvature=0.3)

    monkeypatch.setattr(plan_keeper, "first_plan", straight)
    flown = planned(
        {"duration": 60.0, "torque_bounds": [], "torque_reserve": 0.0, "momentum_reserve": 0.0},
        plant={"initial_momentum": [0.0, 0.0, 0.0], "duration": 10.0},
        reference_governor={"target_rotation_vector": [0.0, 2.967, 0.0]},
    )
    audit = audit_bag(fly(tmp_path, flown))
    assert failed(audit) == {"plan of a transfer: curvature where no bound acts"}


def test_a_step_without_a_solve_follows_the_ladder(tmp_path):
    flown = planned(nmpc_controller={"continuation": "none"})
    audit = audit_bag(fly(tmp_path, flown, failing=(15, 16)))
    assert failed(audit) == {"claimed failures, solved again"}  # they had not failed
    assert lines(audit)["command of the ladder"].verdict == "pass"


@pytest.fixture(scope="module")
def governed_bag(tmp_path_factory):
    return fly(tmp_path_factory.mktemp("governed"), governed(), targets=OTHER_TARGET)


def test_a_governor_that_plans_passes(governed_bag):
    audit = audit_bag(governed_bag)
    assert audit.passed, audit.first
    found = lines(audit)
    assert found["decision of the governor"].verdict == "pass"
    assert found["reference published = step of the plan"].steps == 160
    assert found["plan of a transfer: its start"].steps >= 3
    assert "command = first torque of the plan" in found


def test_a_governor_that_was_started_anew_returns_to_the_first_plan(tmp_path):
    audit = audit_bag(fly(tmp_path, governed(), anew=[70]))
    assert audit.passed, audit.first
    assert "started anew at step 70" in lines(audit)["decision of the governor"].note


def test_plans_that_are_late_in_free_run_are_followed(tmp_path, monkeypatch):
    """Taken some steps after those for which they were made, and one of them never found."""
    late = []

    def ask(self, *problem):
        late.append(_Late(None if len(late) == 1 else self.find(*problem)))
        return late[-1]

    monkeypatch.setattr(keeper.Replanner, "ask", ask)
    monkeypatch.setattr(keeper.PlanKeeper, "waits", _Never(), raising=False)
    free = governed({"replan_error_deg": 0.5}, plant={"mode": "free_run"})
    audit = audit_bag(fly(tmp_path, free, targets=OTHER_TARGET))
    assert len(late) >= 3
    assert audit.passed, audit.first
    assert "in free run" in lines(audit)["decision of the governor"].note


class _Never:
    """An attribute that is false whatever it is set to."""

    def __get__(self, owner, kind=None):
        return False

    def __set__(self, owner, value):
        pass


class _Late:
    """An answer that comes after some questions."""

    def __init__(self, found):
        self._found, self._asked = found, 0

    def done(self):
        self._asked += 1
        return self._asked > 4

    def cancel(self):
        return False

    def result(self):
        return self._found


def test_a_governor_whose_plans_were_not_told_whole(governed_bag, tmp_path):
    """It plans once more itself, as it flew."""
    left = [item for item in messages_of(governed_bag) if item[0] != "/attitude_plan"]
    audit = audit_bag(rewrite(governed_bag, tmp_path / "none", left))
    assert failed(audit) == {"plans of transfers, whole"}
    assert lines(audit)["decision of the governor"].verdict == "pass"
    short = edited("AttitudePlan", momenta=lambda momenta: momenta[:-3])
    cut = [(topic, stamp, short(data) if topic == "/attitude_plan" and stamp == 0 else data)
           for topic, stamp, data in messages_of(governed_bag)]  # fmt: skip
    audit = audit_bag(rewrite(governed_bag, tmp_path / "short", cut))
    assert {"plans of transfers, whole", "plan of each step told"} <= failed(audit)


def test_a_reference_off_the_plan_is_found(governed_bag, tmp_path):
    change = edited("AttitudeReference", torque=moved(1e-9, 0, 0))
    changed = [
        (topic, stamp, change(data) if (topic, stamp) == ("/attitude_reference", 50 * NS) else data)
        for topic, stamp, data in messages_of(governed_bag)
    ]
    audit = audit_bag(rewrite(governed_bag, tmp_path / "bag", changed))
    assert "reference published = step of the plan" in failed(audit)


def test_a_search_without_success_is_followed(tmp_path, monkeypatch):
    """Nothing is found twice, and asked for again ten and twenty steps later."""
    asked = []
    find = keeper.Replanner.find

    def fruitless(self, *problem):
        asked.append(problem)
        return find(self, *problem) if len(asked) > 2 else None

    monkeypatch.setattr(keeper.Replanner, "find", fruitless)
    audit = audit_bag(fly(tmp_path, planned({"replan_error_deg": 0.5}, plant={"duration": 40.0})))
    assert len(asked) >= 3
    assert audit.passed, audit.first


def test_bounds_that_a_flight_exceeds_are_told(bag):
    """Of components, each side by itself: as the scenario has them, without the reserves."""
    claimed = planned({"torque_bounds": [-15.0, -20.0, -20.0, 20.0, 20.0, np.inf]})
    scenario = from_sections(claimed)
    attitudes = np.tile(np.eye(3), (3, 1, 1))
    momenta = np.array([[0.0, 0.0, 0.0], [0.0, -71.0, 60.0], [np.nan] * 3])
    torques = np.array([[16.0, 0.0, 50.0], [-16.0, 0.0, 0.0]])
    found = limits_exceeded(scenario, attitudes, momenta, torques)
    assert [each.limit for each in found] == ["torque -x", "momentum -y"]
    assert [each.factor for each in found] == pytest.approx([16.0 / 15.0, 71.0 / 70.0])
    assert "16 N m, limit 15 N m" in str(found[0])
    assert audit_bag(bag).exceeded == ()


def test_a_controller_that_was_started_anew_is_followed(tmp_path, monkeypatch):
    """It begins with the first plan, finds itself elsewhere, and plans anew."""
    command = PlannedController.command

    def restarted(self, state, reference):
        if state.step == 60:
            self.reset()
        return command(self, state, reference)

    monkeypatch.setattr(PlannedController, "command", restarted)
    audit = audit_bag(fly(tmp_path, planned()))
    assert audit.passed, audit.first
    assert lines(audit)["plan of a transfer: its start"].steps == 4


def test_a_plan_of_a_file_is_certified_without_the_file(tmp_path):
    file = tmp_path / "plan.npz"
    scenario = from_sections(governed())
    save_plan(file, first_plan(scenario))
    bag = fly(tmp_path, governed({"file": str(file)}, plant={"duration": 3.0}))
    file.unlink()
    audit = audit_bag(bag)
    assert audit.passed, audit.first
    assert lines(audit)["decision of the governor"].verdict == "pass"
    assert lines(audit)["plan of a transfer: its start"].verdict == "pass"
