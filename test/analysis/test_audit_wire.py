"""An audit fails a bag without a topic of its graph, or whose messages say more than numbers."""

from __future__ import annotations

import struct
from functools import partial

import docking_bags
import flown_bags
import pytest
import wheel_bags
from flown_bags import edited, first_of, flipped, messages_of

from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.vehicles.docking.audit.flight import DockingAudit

PADDING = 27  # the last byte before the step, behind any frame
FLY = {
    "rigid_body": lambda folder: flown_bags.fly(
        folder, flown_bags.sections(plant={"pose_every": 3})
    ),
    "two_wheel": lambda folder: wheel_bags.fly(folder)[0],
    "docking": lambda folder: docking_bags.fly(
        folder, docking_bags.ungoverned(pose_every=3, duration=35.0)
    ),
}
REWRITE = {
    "rigid_body": flown_bags.rewrite,
    "two_wheel": wheel_bags.rewrite,
    "docking": docking_bags.rewrite,
}
STATE = {
    "rigid_body": "attitude_state",
    "two_wheel": "wheel_state",
    "docking": "relative_state",
}
POSE = {"rigid_body": "pose", "two_wheel": "pose", "docking": "deputy_pose"}
EARLIER = ("/wheel_solver_status", "/wheel_diagnosis")
"""Of methods that came after ``feedback``, whose flights of earlier versions lack them."""
TARGETS = {
    "rigid_body": "accepted_target",
    "two_wheel": "accepted_target",
    "docking": "accepted_docking_target",
}


class Flown:
    """A flight whose bag is written again."""

    def __init__(self, vehicle, folder):
        self.vehicle, self.folder, self.count = vehicle, folder, 0
        self.bag = FLY[vehicle](folder / "flown")
        self.messages = messages_of(self.bag)

    def written(self, messages, **options):
        """Write other messages; return the bag."""
        self.count += 1
        rewrite = REWRITE[self.vehicle]
        return rewrite(self.bag, self.folder / str(self.count), messages, **options)

    def changed(self, topic, number, change):
        """Write the bag with one message of a topic changed, counted from 0."""
        at = [i for i, (name, _, _) in enumerate(self.messages) if name == f"/{topic}"][number]
        messages = list(self.messages)
        name, stamp, data = messages[at]
        messages[at] = (name, stamp, change(data))
        assert messages[at] != self.messages[at]
        return self.written(messages)


@pytest.fixture(
    scope="module",
    params=[pytest.param("docking", marks=pytest.mark.long), "rigid_body", "two_wheel"],
)
def flown(request, tmp_path_factory):
    return Flown(request.param, tmp_path_factory.mktemp(request.param))


@pytest.fixture
def light(monkeypatch):
    """Leave out what the audit of a docking flight integrates: it takes a second each time."""
    monkeypatch.setattr(DockingAudit, "audit", lambda *_: ())


@pytest.fixture(scope="module")
def rigid(tmp_path_factory):
    return Flown("rigid_body", tmp_path_factory.mktemp("rigid"))


def failed(audit):
    return {check.name for check in audit.checks if check.first is not None}


def lines(audit):
    return {check.name: check for check in audit.checks}


def test_what_was_flown_passes(flown):
    audit = audit_bag(flown.written(flown.messages))
    assert audit.passed, audit.first
    found = lines(audit)
    for name in ("topics of the graph", "frames", "encoding", "clock", POSE[flown.vehicle]):
        assert found[name].verdict == "pass", name
    assert found["clock"].steps == audit.steps
    assert found[POSE[flown.vehicle]].steps == audit.steps // 3 + 1
    assert not any(check.note for check in (found["clock"], found[POSE[flown.vehicle]]))


@pytest.mark.usefixtures("light")
def test_no_channel_can_be_left_out(flown):
    """Whether it holds messages or not: a recorder announces all of them."""
    topics = {name for name, _, _ in flown.messages} - {f"/{STATE[flown.vehicle]}"}
    for topic in sorted({*topics, f"/{TARGETS[flown.vehicle]}", "/diagnostics"}):
        left = [item for item in flown.messages if item[0] != topic]
        if topic.endswith("_command") or topic in EARLIER:
            continue  # without a command there is no flight
        audit = audit_bag(flown.written(left, without=[topic]))
        assert audit.first is not None, topic
        name, step, where = first_of(audit)
        assert (name, step) == ("topics of the graph", 0)
        assert where.strip("/") == f"{topic.strip('/')} (no channel)"


@pytest.mark.usefixtures("light")
def test_a_clock_that_is_late_is_caught(flown):
    def later(data):
        return data[:8] + struct.pack("<I", struct.unpack_from("<I", data, 8)[0] + 1)

    audit = audit_bag(flown.changed("clock", 4, later))
    assert failed(audit) == {"clock"}
    assert first_of(audit) == ("clock", 4, "clock (time)")


@pytest.mark.usefixtures("light")
def test_a_tick_left_out_is_caught(flown):
    ticks = [item for item in flown.messages if item[0] == "/clock"]
    for at in (0, 5, len(ticks) - 1):
        left = [item for item in flown.messages if item != ticks[at]]
        audit = audit_bag(flown.written(left))
        assert failed(audit) == {"clock"}
        assert first_of(audit)[1] == at


@pytest.mark.usefixtures("light")
def test_a_clock_that_goes_back_is_caught_and_a_tick_sent_again_passes(flown):
    ticks = [i for i, item in enumerate(flown.messages) if item[0] == "/clock"]
    again, back = list(flown.messages), list(flown.messages)
    again.insert(ticks[5] + 1, flown.messages[ticks[5]])
    audit = audit_bag(flown.written(again))
    assert audit.passed
    assert lines(audit)["clock"].note == "1 sent again with the same bytes"
    back.insert(ticks[5] + 1, flown.messages[ticks[3]])
    assert failed(audit_bag(flown.written(back))) == {"clock"}


@pytest.mark.usefixtures("light")
def test_a_tick_too_many_is_caught(flown):
    last = [item for item in flown.messages if item[0] == "/clock"][-1]
    more = (last[0], last[1], last[2][:4] + struct.pack("<iI", 10**6, 0))
    assert failed(audit_bag(flown.written([*flown.messages, more]))) == {"clock"}


@pytest.mark.usefixtures("light")
def test_another_pose_is_caught(flown):
    pose = POSE[flown.vehicle]
    for at in (28, -8):  # a position and the last number
        audit = audit_bag(flown.changed(pose, 2, lambda d, at=at: flipped(d, 8 * (at % len(d)))))
        assert failed(audit) == {pose}
        name, step, where = first_of(audit)
        assert (name, step, where.partition("[")[0]) == (pose, 6, f"{pose}.pose")


@pytest.mark.usefixtures("light")
def test_a_pose_left_out_is_caught(flown):
    pose = POSE[flown.vehicle]
    poses = [item for item in flown.messages if item[0] == f"/{pose}"]
    for at in (0, 1, len(poses) - 1):
        left = [item for item in flown.messages if item != poses[at]]
        audit = audit_bag(flown.written(left))
        assert failed(audit) == {pose}
        assert first_of(audit)[1] == 3 * at
    none = [item for item in flown.messages if item[0] != f"/{pose}"]
    assert failed(audit_bag(flown.written(none))) == {pose}


@pytest.mark.usefixtures("light")
def test_another_frame_is_caught(flown):
    """Of the same length, so that nothing else changes."""

    def other(data):
        return data[:16] + b"x" + data[17:]

    for topic in (STATE[flown.vehicle], POSE[flown.vehicle]):
        audit = audit_bag(flown.changed(topic, 1, other))
        assert "frames" in failed(audit)
        name, step, where = first_of(audit)
        assert (name, where) == ("frames", f"{topic}.header.frame_id")
        assert step == (1 if topic == STATE[flown.vehicle] else 3)


@pytest.mark.usefixtures("light")
def test_padding_that_is_not_zero_is_caught(flown):
    for topic in (STATE[flown.vehicle], POSE[flown.vehicle]):
        audit = audit_bag(flown.changed(topic, 1, partial(flipped, bit=8 * PADDING + 2)))
        assert failed(audit) == {"encoding"}
        assert first_of(audit)[2] == f"{topic} (bytes)"


@pytest.mark.usefixtures("light")
def test_bytes_behind_the_end_are_caught(flown):
    for topic in (STATE[flown.vehicle], POSE[flown.vehicle]):
        audit = audit_bag(flown.changed(topic, 1, lambda data: data + b"\0\0\0\0"))
        assert failed(audit) == {"encoding"}


@pytest.mark.parametrize("told", ["single_shooting", "", "neighboring", "nothing known"])
def test_another_formulation_is_caught(rigid, told):
    change = edited("SolverStatus", formulation=lambda _: told)
    audit = audit_bag(rigid.changed("solver_status", 3, change))
    assert audit.first is not None
    assert audit.first[1].step == 3
    if told != "neighboring_extremal":
        assert "formulation of the method" in failed(audit)


def test_another_formulation_of_a_failed_solve_is_caught(tmp_path):
    bag = flown_bags.fly(tmp_path / "a", failing=[4])
    change = edited("SolverStatus", formulation=lambda _: "other")
    messages = [
        (name, stamp, change(data) if (name, stamp) == ("/solver_status", 1_600_000_000) else data)
        for name, stamp, data in messages_of(bag)
    ]
    audit = audit_bag(flown_bags.rewrite(bag, tmp_path / "b", messages))
    assert lines(audit)["formulation of the method"].first == (4, "solver_status.formulation")


def test_another_attitude_error_is_caught(rigid):
    audit = audit_bag(rigid.changed("attitude_error", 5, lambda d: flipped(d, 8 * (len(d) - 8))))
    assert failed(audit) == {"attitude_error"}
    assert first_of(audit)[1:] == (5, "attitude_error.vector[2]")


def test_other_markers_of_zones_are_caught(rigid):
    audit = audit_bag(rigid.changed("zone_markers", 0, lambda d: flipped(d, 8 * (len(d) - 4))))
    assert failed(audit) == {"zone_markers"}
    none = [item for item in rigid.messages if item[0] != "/zone_markers"]
    assert failed(audit_bag(rigid.written(none))) == {"zone_markers"}


def test_losses_that_are_made_up_turn_nothing_off(rigid):
    lost = {f"/{topic}": 3 for topic in ("attitude_state", "governor_status", "accepted_target")}
    audit = audit_bag(rigid.written(rigid.messages, lost=lost))
    assert lines(audit)["decision of the governor"].verdict == "pass"


def test_a_stated_tolerance_lets_the_rounding_of_a_pose_through(rigid):
    changed = rigid.changed("pose", 2, lambda d: flipped(d, 8 * (len(d) - 8)))
    assert audit_bag(changed, tolerance=1e-12).passed


@pytest.mark.parametrize(
    "topics",
    [
        ["attitude_state", "torque_command", "plant_invariants"],
        ["*", "/tf"],
        ["pose", "attitude_state", "torque_command", "plant_invariants", "clock"],
    ],
)
def test_topics_left_out_on_purpose_are_not_missed(tmp_path, topics):
    sections = flown_bags.sections(plant={"pose_every": 3}) | {"recorder": {"topics": topics}}
    bag = flown_bags.fly(tmp_path / "all", sections)
    messages = messages_of(bag)
    known = {name for name, _, _ in messages} | {
        f"/{name}" for name in ("accepted_target", "target_attitude", "diagnostics", "wall_timing",
                                "attitude_plan", "plan_status")
    }  # fmt: skip
    out = () if "*" in topics else {name for name in known if name.strip("/") not in topics}
    left = [item for item in messages if item[0] not in out]
    audit = audit_bag(flown_bags.rewrite(bag, tmp_path / "some", left, without=out))
    assert audit.passed, audit.first
    assert lines(audit)["topics of the graph"].steps == (14 if "*" in topics else len(topics))


def test_a_bag_of_before_plans_lacks_their_topics(rigid):
    audit = audit_bag(rigid.written(rigid.messages, without=["/attitude_plan", "/plan_status"]))
    assert audit.passed, audit.first
