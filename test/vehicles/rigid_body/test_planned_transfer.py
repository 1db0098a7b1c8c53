"""The transfer that a scenario plans: its numbers, and one line where there is none."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.parameters.problems import InvalidScenario
from spacecraft_gnc.scenario import from_sections
from spacecraft_gnc.scenario.fingerprint import fingerprint
from spacecraft_gnc.scenario.recorded import parse_scenario
from spacecraft_gnc.status import Status
from spacecraft_gnc.vehicles.rigid_body.planner.file import save_plan
from spacecraft_gnc.vehicles.rigid_body.planner.transfer import (
    first_plan,
    plan_parameters,
    planned_limits,
    real_limits,
    too_short,
    transfer_of,
)

BODY = np.diag([800.0, 1200.0, 1000.0])
TURN = [0.0, 1.0, 1.0]


def scenario(plan=(), plant=(), method="planned", law="none", section="nmpc_controller"):
    plan = {"duration": 21.0, "torque_bounds": [20.0], "momentum_bounds": [70.0], **dict(plan)}
    sections = {
        "plant": {
            "inertia": BODY.ravel().tolist(), "time_step": 0.1, "duration": 25.0, **dict(plant)
        },
        "nmpc_controller": {"method": method},
        "reference_governor": {"governor": law, "target_rotation_vector": TURN},
    }  # fmt: skip
    sections[section]["plan"] = plan
    return from_sections(sections)


def test_transfer_has_the_numbers_of_the_scenario():
    transfer = transfer_of(scenario(plant={"initial_rotation_vector": [0.1, 0.0, 0.0]}))
    assert transfer.n_steps == 210
    assert transfer.body.time_step == 0.1
    assert np.array_equal(transfer.body.inertia, BODY)
    assert np.array_equal(transfer.start, lie.exp(np.array([0.1, 0.0, 0.0])))
    assert np.array_equal(transfer.goal, lie.exp(np.array(TURN)))
    assert transfer.limits.tolist() == [[-20.0] * 3, [20.0] * 3, [-70.0] * 3, [70.0] * 3]


def test_body_is_the_believed_one():
    believed = np.diag([900.0, 1200.0, 1000.0])
    one = scenario()
    two = from_sections(
        {
            **{name: dict(values) for name, values in one.sections.items()},
            "nmpc_controller": {
                **one.sections["nmpc_controller"], "inertia": believed.ravel().tolist()
            },
        }
    )  # fmt: skip
    assert np.array_equal(transfer_of(two).body.inertia, believed)


@pytest.mark.parametrize(
    ("given", "low", "high"),
    [
        ([], [-np.inf] * 3, [np.inf] * 3),
        ([3.0], [-3.0] * 3, [3.0] * 3),
        ([1.0, 2.0, 3.0], [-1.0, -2.0, -3.0], [1.0, 2.0, 3.0]),
        ([-1.0, -2.0, -3.0, 4.0, 5.0, 6.0], [-1.0, -2.0, -3.0], [4.0, 5.0, 6.0]),
    ],
)
def test_bounds_are_none_one_three_or_six_numbers(given, low, high):
    limits = real_limits(scenario({"torque_bounds": given}))
    assert limits[:2].tolist() == [low, high]


def test_reserve_is_left_out_of_the_planned_bounds():
    one = scenario({"torque_reserve": 0.25, "momentum_reserve": 0.1, "momentum_bounds": []})
    assert planned_limits(one)[:2].tolist() == [[-15.0] * 3, [15.0] * 3]
    assert np.isinf(planned_limits(one)[2:]).all()
    assert real_limits(one)[1].tolist() == [20.0] * 3
    assert np.array_equal(transfer_of(one).limits, planned_limits(one))


def test_governor_that_plans_has_its_own_plan():
    one = scenario(
        {"torque_bounds": [7.0]}, method="shooting", law="planned", section="reference_governor"
    )
    assert plan_parameters(one) is one.governor.plan
    assert transfer_of(one).limits[1].tolist() == [7.0] * 3


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (
            {"plan": {"duration": 19.03}},
            "plan.duration: received 19.03 s; required a whole number of control periods of 0.1 s",
        ),
        (
            {"plan": {"duration": 0.1}},
            "control periods of 0.1 s, two or more; give 0.2",
        ),
        (
            {"plan": {"torque_bounds": [20.0, 0.0, 20.0]}},
            "nmpc_controller.plan.torque_bounds: received [20.0, 0.0, 20.0]; required bounds that",
        ),
        (
            {"plan": {"momentum_bounds": [70.0, 70.0]}},
            "nmpc_controller.plan.momentum_bounds: received 2 numbers; required 1 number, 3 ",
        ),
        (
            {"plant": {"initial_momentum": [0.0, 70.1, 0.0]}},
            "plant.initial_momentum: received [0.0, 70.1, 0.0]; required within [-70.0",
        ),
        (
            {
                "plant": {"initial_momentum": [0.0, 0.0, -65.0]},
                "plan": {"momentum_reserve": 0.1},
            },
            "(plan.momentum_bounds less plan.momentum_reserve, 0.1)",
        ),
    ],
)
def test_what_is_refused_is_one_line(given, expected):
    with pytest.raises(InvalidScenario) as refused:
        transfer_of(scenario(**given))
    assert expected in str(refused.value)
    assert "\n" not in str(refused.value)


def test_scenario_without_a_planner_is_refused_in_one_line():
    one = from_sections({"plant": {"inertia": BODY.ravel().tolist()}})
    with pytest.raises(InvalidScenario, match="received shooting, with governor none: neither"):
        transfer_of(one)


def test_first_plan_is_found_or_read_from_the_file(tmp_path):
    one = scenario()
    found = first_plan(one)
    assert found.converged
    file = save_plan(tmp_path / "plan.npz", found)
    read = first_plan(scenario({"file": str(file)}))
    assert np.array_equal(read.torque, found.torque)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        (
            {"plan": {"file": "none.npz"}},
            f"received '{Path('none.npz').absolute()}', a file that cannot be read as a plan (No ",
        ),
        (
            {"plan": {"duration": 22.0}},
            "a plan of duration 21 s, not 22; required a plan of this scenario's transfer; write ",
        ),
        (
            {"plant": {"inertia": (1.01 * BODY).ravel().tolist()}},
            "a plan of inertia diag(800, 1200, 1000) kg m^2, not diag(808, 1212, 1010); ",
        ),
    ],
)
def test_plan_file_of_another_transfer_is_refused_in_one_line(tmp_path, changes, reason):
    file = save_plan(tmp_path / "plan.npz", first_plan(scenario()))
    plan = {"file": str(file), **changes.get("plan", {})}
    with pytest.raises(InvalidScenario) as refused:
        first_plan(scenario(**{**changes, "plan": plan}))
    assert "nmpc_controller.plan.file: received " in str(refused.value)
    assert reason in str(refused.value)
    assert "\n" not in str(refused.value)
    assert str(refused.value).count("received") == 1
    assert "write one, with the same --set: gnc plan " in str(refused.value)
    assert str(refused.value).endswith(" --out ANOTHER.npz")


@pytest.mark.parametrize(
    ("duration", "value"), [(5.0, "5 s, in which no plan was found; "), (13.8, "13.8 s, in which")]
)
def test_time_too_short_is_told_with_the_shortest_that_is_found(duration, value):
    with pytest.raises(InvalidScenario) as refused:
        first_plan(scenario({"duration": duration}))
    (problem,) = refused.value.problems
    assert problem.key == "nmpc_controller.plan.duration"
    assert value in f"{problem.value}; "
    shortest = float(problem.requirement.split()[1])
    assert first_plan(scenario({"duration": shortest})).converged
    with pytest.raises(InvalidScenario):
        first_plan(scenario({"duration": round(shortest - 0.1, 1)}))


def test_recording_needs_no_file_beside_it():
    named = scenario({"file": "plan.npz"})
    assert list(named.named_files()) == [("nmpc_controller", "plan.file", "plan.npz")]
    found, problem = parse_scenario(named.to_yaml(), Path("bag"), None, named.stated_defaults())
    assert problem == ""
    assert list(found.named_files()) == []
    assert first_plan(found).converged
    assert fingerprint(found) == fingerprint(named) == fingerprint(scenario())


def test_shorter_time_in_which_a_plan_is_found_is_told_too():
    one = scenario()
    missed = replace(first_plan(one), status=Status.MAX_ITERATIONS)
    problem = too_short(one, missed)
    assert problem.value.startswith("21 s, in which no plan was found from ")
    assert problem.requirement.startswith("a time such as 19.1 s, which was found (no torque")
