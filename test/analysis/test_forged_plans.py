"""Forged plans, steps along them and commands: an audit finds each."""

from __future__ import annotations

import numpy as np
import pytest
from flown_bags import edited, first_of, flipped, fly, messages_of, rewrite
from hypothesis import given, settings
from hypothesis import strategies as st
from planned_bags import INERTIA, KEPT, LEAD, NS, failed, fly_planned, lines, moved, planned

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.errors import RecordingError

AS_ASKED = "plan of a transfer: as the scenario asks"


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return fly_planned(tmp_path_factory.mktemp("planned"))


@pytest.fixture(scope="module")
def messages(bag):
    return messages_of(bag)


@pytest.fixture
def tamper(bag, messages, tmp_path):
    def change(topic, step, by):
        changed = [
            (name, stamp, by(data) if (name, stamp) == (f"/{topic}", step * NS) else data)
            for name, stamp, data in messages
        ]
        assert changed != messages
        return audit_bag(rewrite(bag, tmp_path / "bag", changed))

    return change


@pytest.fixture(scope="module")
def second(messages):
    """Step at which the second plan is taken."""
    _, taken = (stamp // NS for topic, stamp, _ in messages if topic == "/attitude_plan")
    return taken


@pytest.mark.long
@settings(max_examples=25, deadline=None)
@given(place=st.floats(0.0, 1.0), bit=st.integers(48, 63))
def test_no_number_of_a_plan_stops_the_audit(bag, messages, tmp_path_factory, place, bit):
    """Of any size: what is told is refused, or found, or of no consequence."""

    def change(data):
        number = 4 + 8 * int(place * ((len(data) - 4) // 8 - 1))
        return flipped(data, 8 * number + bit)

    changed = [
        (topic, stamp, change(data) if (topic, stamp) == ("/attitude_plan", 0) else data)
        for topic, stamp, data in messages
    ]
    try:
        audit_bag(rewrite(bag, tmp_path_factory.mktemp("bits") / "bag", changed))
    except RecordingError as error:
        assert "attitude_plan" in str(error)  # noqa: PT017


def added(index, by):
    def change(values):
        values = np.array(values)
        values[index] += by
        return values

    return change


PLAN_FORGERIES = {
    "number": ({"number": 1}, {"step of the plan = plan", "plans are taken when they are due"}),
    "first_step": ({"first_step": 1}, {"step of the plan = plan"}),
    "cause": ({"cause": lambda _: 1}, {"plans are taken when they are due"}),
    "status": ({"status": 2}, {"plan of a transfer: optimal"}),
    "time_step": ({"time_step": 1e-9}, {AS_ASKED, "plan of a transfer: turns of the momenta"}),
    "inertia": ({"inertia": added(0, 1.0)}, {AS_ASKED, "plan of a transfer: turns of the momenta"}),
    "torque bound": ({"torque_bounds": added(3, 1.0)}, {AS_ASKED}),
    "momentum bound": ({"momentum_bounds": added(0, -1.0)}, {AS_ASKED}),
    "a bound that acts": (
        {"torque_bounds": added(4, 1.0)},
        {AS_ASKED, "plan of a transfer: signs of the multipliers"},
    ),
    "goal": (
        {"goal": lambda goal: (lie.exp([1e-6, 0.0, 0.0]) @ goal.reshape(3, 3)).ravel()},
        {AS_ASKED, "plan of a transfer: ends at the goal"},
    ),
    "attitude": (
        {"attitudes": added(9 * 30 + 1, 1e-6)},
        {"plan of a transfer: rotations", "step of the plan = plan"},
    ),
    "momentum": (
        {"momenta": added(3 * 30, 1e-4)},
        {"plan of a transfer: turns of the momenta", "plan of a transfer: momenta of the torques"},
    ),
    "last momentum": ({"momenta": added(-1, 1e-4)}, {"plan of a transfer: ends at rest"}),
    "torque": (
        {"torques": added(3 * 30, 1e-4)},
        {"plan of a transfer: momenta of the torques", "plan of a transfer: cost",
         "plan of a transfer: stationary by the torque", "step of the plan = plan"},
    ),
    "co-momentum": (
        {"co_momenta": added(3 * 30, 1e-4)},
        {"plan of a transfer: co-momenta", "plan of a transfer: stationary by the torque"},
    ),
    "zeta": ({"zeta": added(1, 1.0)}, {"plan of a transfer: co-momenta"}),
    "torque multiplier": (
        {"torque_multipliers": added(3 * 30, 1e-4)},
        {"plan of a transfer: stationary by the torque",
         "plan of a transfer: signs of the multipliers"},
    ),
    "momentum multiplier": (
        {"momentum_multipliers": added(3 * 10, -1e-2)},
        {"plan of a transfer: co-momenta", "plan of a transfer: signs of the multipliers"},
    ),
    "cost": ({"cost": 1e-6}, {"plan of a transfer: cost"}),
    "residual": ({"residual": 1e-6}, {"plan of a transfer: residual told"}),
    "curvature": (
        {"min_curvature": lambda _: 0.99}, {"plan of a transfer: curvature where no bound acts"},
    ),
    "no curvature": (
        {"min_curvature": lambda _: np.nan}, {"plan of a transfer: curvature where no bound acts"},
    ),
    "short": ({"torques": lambda torques: torques[:-3]}, {"plans of transfers, whole"}),
}  # fmt: skip


FIRST = ("number", "first_step", "cause", "goal", "a bound that acts")
FORGED = [(name, "first") for name in FIRST] + [
    (name, "second") for name in PLAN_FORGERIES if name != "a bound that acts"
]


@pytest.mark.parametrize(("name", "which"), FORGED)
def test_a_forged_plan_is_found(tamper, second, name, which):
    changes, expected = PLAN_FORGERIES[name]
    audit = tamper(
        "attitude_plan", 0 if which == "first" else second, edited("AttitudePlan", **changes)
    )
    assert expected <= failed(audit)


STEP_FORGERIES = {
    "number": ({"number": 1}, "step of the plan = plan"),
    "plan_step": ({"plan_step": -1}, "step of the plan = plan"),
    "phase": ({"phase": lambda old: (old + 1) % 4}, "phase of the plan"),
    "attitude_error": ({"attitude_error": 1e-9}, "angle off the plan"),
    "momentum_error": ({"momentum_error": moved(1e-12, 0, 0)}, "momentum off the plan"),
    "attitude": (
        {"attitude": lambda R: (R.reshape(3, 3) @ lie.exp([0.0, 1e-12, 0.0])).ravel()},
        "step of the plan = plan",
    ),
    "momentum": ({"momentum": moved(0, 1e-9, 0)}, "step of the plan = plan"),
    "torque": ({"torque": moved(0, 0, 1e-9)}, "step of the plan = plan"),
    "reference_rate": ({"reference_rate": moved(1e-9, 0, 0)}, "reference = motion of the plan"),
    "reference_torque": (
        {"reference_torque": moved(1e-9, 0, 0)}, "reference = motion of the plan",
    ),
    "nominal_torque": (
        {"nominal_torque": moved(1e-9, 0, 0)}, "command = first torque of the plan",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", STEP_FORGERIES)
def test_a_forged_step_is_found(tamper, name):
    changes, expected = STEP_FORGERIES[name]
    assert expected in failed(tamper("plan_status", 60, edited("PlanStatus", **changes)))


@pytest.mark.parametrize("field", ["reference_rate", "reference_torque"])
def test_the_certificates_of_the_tracking_refuse_another_motion(tamper, field):
    audit = tamper("plan_status", 20, edited("PlanStatus", **{field: moved(1e-3, 0, 0)}))
    assert {"residual (backward_sweep)", "cost"} <= failed(audit)


def test_a_reference_that_moves_after_the_plan_is_found(tamper):
    audit = tamper("plan_status", 119, edited("PlanStatus", reference_rate=moved(1e-3, 0, 0)))
    assert "reference at rest after the plan" in failed(audit)


def test_a_command_beyond_a_bound_is_found(tamper):
    audit = tamper("torque_command", 80, edited("TorqueCommand", torque=moved(1e-6, 0, 0)))
    assert first_of(audit)[1:] == (80, "torque_command.torque[0]")
    assert KEPT in failed(audit)


def test_a_step_or_a_plan_left_out_is_found(bag, messages, tmp_path, second):
    left = [item for item in messages if item[:2] != ("/plan_status", 9 * NS)]
    audit = audit_bag(rewrite(bag, tmp_path / "step", left))
    assert first_of(audit) == ("steps of plan_status", 9, "plan_status (missing)")
    left = [item for item in messages if item[:2] != ("/attitude_plan", second * NS)]
    audit = audit_bag(rewrite(bag, tmp_path / "plan", left))
    assert failed(audit) == {"step of the plan = plan"}
    left = [item for item in messages if item[:2] != ("/attitude_plan", 0)]
    audit = audit_bag(rewrite(bag, tmp_path / "first", left))
    assert "plan of each step told" in failed(audit)


def without(topic, bag, messages, folder):
    left = [item for item in messages if item[0] != f"/{topic}"]
    return audit_bag(rewrite(bag, folder / topic, left))


def test_what_was_not_recorded_is_not_certified(bag, messages, tmp_path):
    audit = without("attitude_plan", bag, messages, tmp_path)
    assert failed(audit) == {"plans of transfers, whole"}
    audit = without("plan_status", bag, messages, tmp_path)
    assert failed(audit) == {"steps of plan_status"}
    assert "what was tracked is not known" in lines(audit)["plans of the solver"].note
    audit = without("solver_status", bag, messages, tmp_path)
    assert failed(audit) == {"steps of solver_status"}
    start = lines(audit)["plan of a transfer: its start"]
    assert (start.steps, start.verdict) == (1, "pass")
    assert "was not recorded: not foreseen" in start.note


def test_a_scenario_that_does_not_record_plans_has_none_certified(tmp_path):
    topics = ["attitude_state", "torque_command", "plant_invariants"]
    flown = planned() | {"recorder": {"topics": topics}}
    bag = fly(tmp_path, flown)
    left = [item for item in messages_of(bag) if item[0][1:] in topics]
    audit = audit_bag(rewrite(bag, tmp_path / "few", left))
    assert audit.passed, audit.first
    assert "no plan is certified" in lines(audit)["plans of transfers, whole"].note


HEAVIER = [801.0, *INERTIA[1:]]
ONE_SIDED = [-70.0, -70.0, -70.0, np.inf, 70.0, 70.0]
DUE = "plans are taken when they are due"
CLAIMS = {
    "another inertia": ({"nmpc_controller": {"inertia": HEAVIER}}, {}, AS_ASKED),
    "narrower torque": ({}, {"torque_bounds": [19.0]}, AS_ASKED),
    "one-sided momentum": ({}, {"momentum_bounds": ONE_SIDED}, AS_ASKED),
    "less reserve": ({}, {"torque_reserve": 0.05}, AS_ASKED),
    "another time": ({}, {"duration": 23.0}, "plan of a transfer: its duration"),
    "another target": (
        {"reference_governor": {"target_rotation_vector": [0.9, 0.9, 0.91]}}, {}, AS_ASKED,
    ),
    "another start": (
        {"plant": {"initial_momentum": [30.0, -10.0, 11.0]}}, {}, "plan of a transfer: its start",
    ),
    "another limit of the error": ({}, {"replan_error_deg": 3.0}, "phase of the plan"),
    "no further plans": ({}, {"replan_error_deg": 0.0}, DUE),
    "another lead": ({}, {"replan_lead": LEAD + 1}, DUE),
}  # fmt: skip


@pytest.mark.parametrize("name", CLAIMS)
def test_a_flight_of_another_scenario_is_found(tmp_path, name):
    changes, plan, expected = CLAIMS[name]
    audit = audit_bag(fly(tmp_path, planned(), claimed=planned(plan, **changes)))
    assert expected in failed(audit)
