"""A flight along plans, solved again: by itself, from its middle, and by a method without plans."""

from __future__ import annotations

import numpy as np
import pytest
from flown_bags import fly
from planned_bags import fly_planned, governed

from spacecraft_gnc.analysis.reader import load_run
from spacecraft_gnc.scenario import revise
from spacecraft_gnc.vehicles.rigid_body.resolve import compare, resolve
from spacecraft_gnc.vehicles.rigid_body.resolve.table import differences


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return load_run(fly_planned(tmp_path_factory.mktemp("planned")))


def test_itself_commands_the_same_again(run):
    scenario = run.info.scenario
    assert resolve(run.trajectory, scenario, scenario).first_difference is None


@pytest.mark.parametrize("steps", [(60, 80), (41, 42)])
def test_the_plan_of_a_later_step_rests_on_all_before(run, steps):
    """The first plan was left behind: without the past another one would be flown."""
    scenario = run.info.scenario
    assert run.trajectory.plan[steps[0]] == 1
    resolved = resolve(run.trajectory, scenario, scenario, steps=steps, cold=steps[0] == 60)
    assert resolved.steps.tolist() == list(range(*steps))
    assert resolved.torque_difference.max() < 1e-10


def test_another_method_tracks_the_motion_of_the_plans(run):
    recorded = run.info.scenario
    revised, unread = revise(recorded, [], "shooting")
    assert "plan.duration" in unread
    resolved = resolve(run.trajectory, recorded, revised)
    numbers = compare(resolved, recorded, revised)
    assert numbers["tracks_plans"]
    limits = np.abs(run.trajectory.torque) > 20.0 - 1e-9
    momenta = np.abs(run.trajectory.momentum) > 62.9  # the guard keeps 63 N m s of what it believes
    free = ~(limits | momenta).any(axis=1)
    same = (resolved.replayed.torque == resolved.recorded.torque).all(axis=1)
    assert same[free].mean() > 0.9
    assert numbers["cost_difference_max"] == 0.0
    rows = dict(differences(numbers | {"check": None}, 0.25))
    assert rows["reference"].endswith("tracked: shooting keeps no bounds of a plan")


def test_a_governor_that_plans_leaves_its_reference_to_the_method(tmp_path):
    run = load_run(fly(tmp_path, governed(plant={"duration": 10.0})))
    recorded = run.info.scenario
    assert resolve(run.trajectory, recorded, recorded).first_difference is None
    revised, _ = revise(recorded, [], "slsqp")
    resolved = resolve(run.trajectory, recorded, revised, steps=(0, 10))
    assert not compare(resolved, recorded, revised)["tracks_plans"]
    assert resolved.torque_difference.max() < 1e-2
