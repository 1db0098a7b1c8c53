"""The governor is asked again: one bit of what it decided is caught, and so is another target."""

from __future__ import annotations

from pathlib import Path

import pytest
from flown_bags import edited, first_of, flipped, fly, messages_of, rewrite

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.columns import read_columns
from spacecraft_gnc.recording.stamps import step_of
from spacecraft_gnc.scenario import read_sections
from spacecraft_gnc.signals.attitude import GOVERNOR_STATUS

CONFIG = Path(__file__).parents[2] / "config"
CHECK = "decision of the governor"
N = 36
TARGETS = {7: lie.exp([0.0, 0.3, 0.1]), 20: lie.exp([0.2, -0.1, 0.3])}


def scenario(name="kalabic2014_governor"):
    found = read_sections(CONFIG / f"{name}.yaml")
    found["plant"]["duration"] = N * found["plant"]["time_step"]
    return found


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    """A governed flight whose target is replaced twice."""
    return fly(tmp_path_factory.mktemp("governed"), scenario(), targets=TARGETS)


@pytest.fixture(scope="module")
def tamper(bag, tmp_path_factory):
    """Return a function that writes the bag again with the bytes of one message changed."""

    def rewritten(topic, step, change):
        changed = [
            (found, stamp, change(data) if (found, step_of(data)) == (f"/{topic}", step) else data)
            for found, stamp, data in messages_of(bag)
        ]
        assert sum(a != b for a, b in zip(messages_of(bag), changed, strict=True)) == 1
        return rewrite(bag, tmp_path_factory.mktemp("tampered") / "bag", changed)

    return rewritten


def line(audit, name=CHECK):
    return next(check for check in audit.checks if check.name == name)


def test_every_decision_is_made_again_with_the_targets_taken_in_flight(bag):
    audit = audit_bag(bag)
    assert audit.passed, audit.first
    found = line(audit)
    assert (found.verdict, found.steps, found.worst) == ("pass", N, 0.0)
    assert found.note == "targets taken in flight: 2"
    with open_bag(bag) as opened:
        alpha = read_columns(opened, [GOVERNOR_STATUS])[GOVERNOR_STATUS].fields["alpha"]
    assert ((alpha > 0.0) & (alpha < 1.0)).sum() > N / 2  # the governor had something to decide


@pytest.mark.parametrize("step", [0, 7, 19, N - 1])
@pytest.mark.parametrize(
    ("topic", "at", "field"),
    [
        ("attitude_reference", 36 + 8 * 4, "attitude_reference.attitude[4]"),
        ("governor_status", 36, "governor_status.alpha"),
        ("governor_status", 52, "governor_status.margin"),
    ],
)
def test_one_bit_of_a_decision_is_caught(tamper, step, topic, at, field):
    audit = audit_bag(tamper(topic, step, lambda data: flipped(data, 8 * at)))
    failed = {check.name: check.first for check in audit.checks if check.first is not None}
    assert failed[CHECK] == (step, field)
    assert audit.first[1].step == step


@pytest.mark.parametrize("name", ["evaluations", "violation_step", "horizon", "waypoints"])
def test_another_count_is_caught(tamper, name):
    audit = audit_bag(tamper("governor_status", 11, edited("GovernorStatus", **{name: 1})))
    assert first_of(audit) == (CHECK, 11, f"governor_status.{name}")


def test_another_constraint_is_caught(tamper):
    change = edited("GovernorStatus", active_constraint=lambda _: "star")
    audit = audit_bag(tamper("governor_status", 11, change))
    assert first_of(audit)[1:] == (11, "governor_status.active_constraint")


def test_another_target_is_caught(tamper):
    """A rotation, and admissible, but not the one that was flown to."""

    def other(attitude):
        return (lie.exp([1e-4, 0.0, 0.0]) @ attitude.reshape(3, 3)).ravel()

    audit = audit_bag(tamper("accepted_target", 7, edited("AttitudeReference", attitude=other)))
    assert first_of(audit)[:2] == (CHECK, 7)


def test_a_target_that_the_governor_would_not_take_is_caught(tamper):
    skewed = edited("AttitudeReference", attitude=lambda attitude: 2.0 * attitude)
    audit = audit_bag(tamper("accepted_target", 20, skewed))
    found = ("targets are admissible", 20, "accepted_target.attitude")
    assert first_of(audit) == found


def test_a_target_left_out_is_caught(bag, tmp_path):
    left = [item for item in messages_of(bag) if item[0] != "/accepted_target"]
    audit = audit_bag(rewrite(bag, tmp_path / "bag", left))
    assert first_of(audit)[:2] == (CHECK, 7)


def test_a_governor_that_was_started_anew_is_recognized(tmp_path):
    audit = audit_bag(fly(tmp_path, scenario(), targets=TARGETS, anew=[12]))
    assert audit.passed, audit.first
    anew = "the governor started anew at step 12"
    assert line(audit).note == f"targets taken in flight: 2; {anew}"
    assert line(audit).steps == N


def test_a_way_round_a_zone_is_followed(tmp_path):
    audit = audit_bag(fly(tmp_path, scenario("governed_nmpc")))
    assert audit.passed, audit.first
    assert (line(audit).verdict, line(audit).steps) == ("pass", N)


def test_a_stated_tolerance_lets_rounding_through_and_no_more(tamper):
    rounded = tamper("governor_status", 9, lambda data: flipped(data, 8 * 52))
    assert audit_bag(rounded, tolerance=1e-12).passed
    large = tamper("governor_status", 9, lambda data: flipped(data, 8 * 52 + 40))
    assert first_of(audit_bag(large, tolerance=1e-12)) == (CHECK, 9, "governor_status.margin")
    counted = tamper("governor_status", 9, edited("GovernorStatus", evaluations=1))
    assert audit_bag(counted, tolerance=1e-12).passed  # rounding may tip the last bisection


def test_without_the_channel_of_the_targets_the_audit_fails(bag, tmp_path):
    left = [item for item in messages_of(bag) if item[0] != "/accepted_target"]
    audit = audit_bag(rewrite(bag, tmp_path / "bag", left, without=["/accepted_target"]))
    assert first_of(audit) == ("topics of the graph", 0, "accepted_target (no channel)")
    assert (line(audit).verdict, line(audit).note) == (
        "not applicable", "not recorded: accepted_target"
    )  # fmt: skip


def test_where_the_targets_are_not_recorded_on_purpose_nothing_is_asked(tmp_path):
    wanted = ["attitude_state", "attitude_reference", "governor_status", "torque_command",
              "solver_status", "plant_invariants"]  # fmt: skip
    flown = {**scenario(), "recorder": {"topics": wanted}}
    bag = fly(tmp_path, flown, targets=TARGETS)
    left = [item for item in messages_of(bag) if item[0].strip("/") in wanted]
    others = {topic for topic, _, _ in messages_of(bag)} - {topic for topic, _, _ in left}
    without = [*others, "/diagnostics", "/target_attitude", "/attitude_plan", "/plan_status"]
    audit = audit_bag(rewrite(bag, tmp_path / "bag2", left, without=without))
    assert audit.passed, audit.first
    assert (line(audit).verdict, line(audit).note) == (
        "not applicable", "not recorded: accepted_target"
    )  # fmt: skip


def test_losses_told_are_no_excuse(bag, tmp_path):
    """Neither where a target is missing, nor where everything is there and they are made up."""
    lost = {"/accepted_target": 1}
    left = [item for item in messages_of(bag) if item[0] != "/accepted_target"]
    audit = audit_bag(rewrite(bag, tmp_path / "left", left, lost=lost))
    assert first_of(audit)[:2] == (CHECK, 7)
    note = "the recorder says that it lost messages of /accepted_target"
    assert line(audit).note == note
    audit = audit_bag(rewrite(bag, tmp_path / "whole", messages_of(bag), lost=lost))
    assert audit.passed, audit.first
    assert (line(audit).steps, line(audit).note) == (N, f"targets taken in flight: 2; {note}")


def test_a_governor_that_passes_through_is_asked_too(tmp_path):
    flown = fly(tmp_path, scenario("kalabic2014_ungoverned"))
    assert line(audit_bag(flown)).steps == N
    turned = lie.exp([0.1, 0.0, 0.0])
    changed = [
        (topic, stamp, edited("AttitudeReference", attitude=lambda _: turned.ravel())(data)
         if (topic, step_of(data)) == ("/attitude_reference", 5) else data)
        for topic, stamp, data in messages_of(flown)
    ]  # fmt: skip
    found = audit_bag(rewrite(flown, tmp_path / "changed", changed))
    assert line(found).first == (5, "attitude_reference.attitude[4]")
