"""An audit of a docking flight passes what was flown, and names what was forged."""

from __future__ import annotations

import numpy as np
import pytest
from docking_bags import fly, rewrite, sections, ungoverned
from flown_bags import first_of, messages_of
from recording.bags import CODEC

from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.cli.main import main
from spacecraft_gnc.vehicles.docking.signals import (
    COMMAND,
    GOVERNOR_STATUS,
    REFERENCE,
    STATE,
)
from spacecraft_gnc.vehicles.docking.state import RelativeReference

PERIOD = 5_000_000_000  # [ns]
STEP = 1
"""A step at which constraints keep the reference from the wish."""


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return fly(tmp_path_factory.mktemp("flown"))


@pytest.fixture(scope="module")
def messages(bag):
    return messages_of(bag)


@pytest.fixture
def forge(bag, messages, tmp_path):
    """Return a function that writes the bag again with one message changed, or left out."""

    def rewritten(signal, change, step=STEP):
        changed = []
        for topic, stamp, data in messages:
            if (topic, stamp) != (f"/{signal}", step * PERIOD):
                changed.append((topic, stamp, data))
            elif change is not None:
                message = CODEC.store.deserialize_cdr(data, signal.type)
                change(message)
                made = bytes(CODEC.store.serialize_cdr(message, signal.type))
                changed.append((topic, stamp, made))
        assert changed != messages
        return rewrite(bag, tmp_path / "bag", changed)

    return rewritten


def add(field, amount, index=0):
    """Return a change of a message: something added to a number of a field."""

    def change(message):
        *path, last = field.split(".")
        for name in path:
            message = getattr(message, name)
        value = getattr(message, last)
        if isinstance(value, np.ndarray):
            value = value.copy()
            value[index] += amount
        elif not isinstance(value, float | int):
            value.y += amount
        else:
            value += amount
        setattr(message, last, value)

    return change


def put(field, value, index=None):
    """Return a change of a message: another value of a field, or of one of its numbers."""

    def change(message):
        made = value
        if index is not None:
            made = getattr(message, field).copy()
            made[index] = value
        setattr(message, field, made)

    return change


FORGED = [
    (STATE, add("port_offset", 1e-3), "motion = "),
    (STATE, add("port_velocity", 1e-4), "motion = "),
    (STATE, add("angular_velocity", 1e-4), "motion = "),
    (STATE, add("attitude", 1e-3), "quaternion = rotation matrix"),
    (STATE, add("orientation.w", 1e-12), "quaternion = rotation matrix"),
    (STATE, add("measured_port_offset", 1e-12), "measured = truth"),
    (STATE, add("measured_attitude", 1e-12), "measured = truth"),
    (STATE, add("line_of_sight_margin", 1e-3), "margins = "),
    (STATE, add("clearance", -1e-3), "margins = "),
    (STATE, put("thrusters", False, 2), "thrusters = "),
    (STATE, add("applied_wrench.force", 1e-9), "applied = command"),
    (STATE, add("chief_attitude", 1e-9), "attitude of the chief"),
    (COMMAND, add("wrench.force", 1e-3), "command = "),
    (COMMAND, add("wrench.torque", 1e-4), "command = "),
    (REFERENCE, add("port_offset", 1e-3), "reference = status"),
    (GOVERNOR_STATUS, add("reference", 1e-9), "reference = status"),
    (GOVERNOR_STATUS, add("wish", 1e-9), "wish = target"),
    (GOVERNOR_STATUS, add("slack", 1e-3), "slack and"),
    (GOVERNOR_STATUS, put("constraint", "vertex 3 off the docking face"), "slack and"),
    (GOVERNOR_STATUS, put("status", 1), "reference held: no admissible one"),
    (GOVERNOR_STATUS, put("phase", 1), "phase of the governor"),
    (GOVERNOR_STATUS, put("law", "time_invariant"), "law of the governor"),
    (GOVERNOR_STATUS, add("multipliers", 1e-2), "program of the governor: stationarity"),
    (GOVERNOR_STATUS, put("active_ahead", 7, 0), "program of the governor: "),
    (GOVERNOR_STATUS, put("lost_thruster", 2), "direction concluded lost"),
    (GOVERNOR_STATUS, add("response_error", 1e-3), "response to the force"),
    (COMMAND, None, "steps of wrench_command"),
    (GOVERNOR_STATUS, None, "steps of periodic_governor_status"),
]


def test_what_was_flown_passes(bag):
    audit = audit_bag(bag)
    assert audit.passed, audit.first
    assert audit.steps == 10
    verdicts = {check.name: check.verdict for check in audit.checks}
    for name in (
        "abort asks no force of the lost direction",
        "applied where no command came in time",
        "no direction concluded lost that answers",
    ):
        assert verdicts.pop(name) == "not applicable"
    assert set(verdicts.values()) == {"pass"}


@pytest.mark.parametrize(
    ("signal", "change", "check"),
    [  # an audit lasts five seconds: CI takes every fourth
        case if i % 4 == 0 else pytest.param(*case, marks=pytest.mark.long)
        for i, case in enumerate(FORGED)
    ],
)
def test_a_forged_message_is_named(forge, signal, change, check):
    audit = audit_bag(forge(signal, change))
    failed = [found.name for found in audit.checks if found.first]
    assert any(name.startswith(check) for name in failed), failed
    assert first_of(audit)[1] in (STEP, STEP + 1)


def test_a_forged_bag_ends_the_command_with_1(forge, bag, capsys):
    for flown, code in ((bag, 0), (forge(STATE, add("port_offset", 1e-3)), 1)):
        with pytest.raises(SystemExit) as ended:
            main(["audit", str(flown)])
        assert (ended.value.code or 0) == code
    assert "relative_state.port_offset" in capsys.readouterr().out


def test_noise_of_another_seed_is_named(tmp_path):
    noisy = {"position_noise": 1e-3, "attitude_noise": 1e-3, "rate_noise": 1e-5, "seed": 4}
    flown = fly(tmp_path, ungoverned(**noisy))
    assert audit_bag(flown).passed
    other = fly(tmp_path / "claimed", ungoverned(**{**noisy, "seed": 5}))
    audit = audit_bag(rewrite(other, tmp_path / "mixed", messages_of(flown)))
    failed = {check.name for check in audit.checks if check.first}
    assert "measured = truth and noise of the seed" in failed
    assert "measured = truth and noise of the seed, attitude" in failed


def test_held_references_are_proven_inadmissible(tmp_path):
    audit = audit_bag(fly(tmp_path, sections(plant={"position_noise": 0.1, "seed": 3})))
    assert audit.passed, audit.first
    steps = {check.name: check.steps for check in audit.checks}
    assert steps["reference held: no admissible one (LP)"] == 3
    assert steps["reference held = the last one"] == 3


def test_a_lost_thruster_and_a_new_target_are_followed(tmp_path):
    """The governor notices at once: the chief's rotation takes force in every direction."""
    flown = sections(plant={"thruster_lost": "-x", "thruster_lost_at": 20.0})
    target = RelativeReference.of(np.array([0.1, 0.0, 0.0, 0.0, 0.0, 0.0]))
    audit = audit_bag(fly(tmp_path, flown, {2: target}))
    assert audit.passed, audit.first
    verdicts = {check.name: check for check in audit.checks}
    assert verdicts["wish = target"].note == "targets taken in flight: 1"
    assert verdicts["no direction concluded lost that answers"].verdict == "pass"
    assert verdicts["abort asks no force of the lost direction"].verdict == "pass"


def test_another_mass_in_the_scenario_fails_the_motion(bag, messages, tmp_path):
    other = fly(tmp_path, ungoverned(mass=131.0))
    audit = audit_bag(rewrite(other, tmp_path / "mixed", messages))
    failed = {check.name for check in audit.checks if check.first}
    assert any(name.startswith("motion = ") for name in failed)
    assert "command = the audit's own law: force" in failed
