"""An audit of a flight in formation passes what was flown, and names what was forged."""

from __future__ import annotations

import numpy as np
import pytest
from flown_bags import first_of, messages_of
from formation_bags import fly, nanoseconds, rewrite, sections, ungoverned
from recording.bags import CODEC

from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.cli.main import main
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.vehicles.formation.signals import COMMAND, GOVERNOR_STATUS, REFERENCE, STATE

STEP = 4
"""A step at which constraints keep the shifts from the cheapest candidate."""
SC2 = COMMAND.of("sc2")


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
            if (topic, stamp) != (f"/{signal}", step * nanoseconds()):
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
        value = getattr(message, field)
        if isinstance(value, np.ndarray):
            value = value.copy()
            value[index] = value[index] + amount
        elif not isinstance(value, float | int):
            value.y += amount
        else:
            value += amount
        setattr(message, field, value)

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


def swap(message):
    """Exchange the commanded delta-v of the first two craft in what was asked for."""
    asked = message.applied_delta_v.copy()
    asked[:6] = np.roll(asked[:6], 3)
    message.applied_delta_v = asked


def words(old, new):
    """Return a change of the words about the constraint with the least room."""

    def change(message):
        assert old in message.constraint
        message.constraint = message.constraint.replace(old, new)

    return change


FORGED = {
    "position": (STATE, add("position", 1e-6, 4), "motion = "),
    "velocity": (STATE, add("velocity", 1e-9, 8), "motion = "),
    "healthy": (STATE, put("healthy", False, 1), "craft that answer"),
    "applied delta-v": (STATE, add("applied_delta_v", 1e-12, 3), "applied = command"),
    "applied source": (STATE, put("applied_source", 4, 2), "applied = command"),
    "applied to another craft": (STATE, swap, "applied = command"),
    "delta-v": (SC2, add("delta_v", 1e-9), "command = "),
    "source": (SC2, put("source", 4), "command = the audit's own law: source"),
    "no command": (SC2, None, "steps of sc2/delta_v_command"),
    "shift": (REFERENCE, add("shift", 1, 1), "reference = "),
    "shift of a period": (REFERENCE, put("shift", 77, 1), "shifts: below a period"),
    "commanded position": (REFERENCE, add("position", 1e-6, 2), "reference = "),
    "commanded velocity": (REFERENCE, add("velocity", 1e-9, 2), "reference = "),
    "law": (GOVERNOR_STATUS, put("law", "none"), "law of the governor"),
    "passed": (GOVERNOR_STATUS, put("status", 5), "law of the governor"),
    "held": (GOVERNOR_STATUS, put("status", 1), "shifts held: no candidate"),
    "longest kept": (GOVERNOR_STATUS, put("status", 2), "shifts held: no candidate"),
    "least violation": (GOVERNOR_STATUS, put("status", 3), "shifts held: no candidate"),
    "passage": (GOVERNOR_STATUS, put("status", 4), "passage: begins"),
    "cost": (GOVERNOR_STATUS, add("cost", 1e-5), "cost of the shifts"),
    "shift cost": (GOVERNOR_STATUS, add("shift_cost", 1.0), "cost of the shifts"),
    "state cost": (GOVERNOR_STATUS, add("state_cost", 1e-5), "cost of the shifts"),
    "admissible ones": (GOVERNOR_STATUS, add("n_admissible", -1), "candidates: "),
    "not counted": (GOVERNOR_STATUS, put("n_admissible", -1), "candidates: "),
    "candidates": (GOVERNOR_STATUS, add("n_candidates", 1), "candidates: "),
    "margin": (GOVERNOR_STATUS, add("margin", 1e-7), "constraint with the least room"),
    "other craft": (GOVERNOR_STATUS, words("sc3", "sc1"), "constraint with the least room: in"),
    "other time": (GOVERNOR_STATUS, add("constraint_ahead", 1.0), "constraint with the least room"),
    "no constraint": (GOVERNOR_STATUS, put("constraint", ""), "constraint with the least room: in"),
    "refused": (GOVERNOR_STATUS, put("refused", ""), "constraint that the cheapest"),
    "refused margin": (GOVERNOR_STATUS, add("refused_margin", 1e-7), "constraint that the cheap"),
    "error": (GOVERNOR_STATUS, add("error", 1e-6), "error = "),
    "deadlocked": (GOVERNOR_STATUS, put("deadlocked", True), "deadlocked"),
    "waypoint": (GOVERNOR_STATUS, put("waypoint", np.array([1, 1, 1], np.uint32)), "passage"),
    "passages left": (GOVERNOR_STATUS, put("passages_left", 1), "passage"),
    "lost": (GOVERNOR_STATUS, put("lost", True, 0), "craft concluded lost"),
    "response": (GOVERNOR_STATUS, add("response", 1e-5), "response of each craft"),
    "formed": (GOVERNOR_STATUS, put("formed", True), "formed"),
    "no status": (GOVERNOR_STATUS, None, "steps of time_shift_status"),
}


def test_what_was_flown_passes(bag):
    audit = audit_bag(bag)
    assert audit.passed, audit.first
    assert audit.steps == 9
    assert audit.exceeded == ()
    verdicts = {check.name: check.verdict for check in audit.checks}
    assert verdicts.pop("shifts: no admissible candidate costs less") == "pass"
    absent = {name for name, verdict in verdicts.items() if verdict == "not applicable"}
    assert absent == {
        "answer where no candidate is admissible",
        "applied where no command came in time",
        "no craft concluded lost that answers",
        "passage: begins at a deadlock, nearer with each formation",
        "passage: goes on until the formation is attained",
        "passage: no admissible candidate is nearer, or costs less",
        "passage: transitions left = a search of all parked formations",
        "shifts held = the last ones",
        "shifts held: no candidate is admissible",
        "shifts: no candidate exceeds a limit by less",
        "shifts: no candidate keeps the limits longer",
    }


def test_limits_exceeded_are_told_and_fail_nothing(tmp_path):
    audit = audit_bag(fly(tmp_path, ungoverned(saturates=False)))
    assert audit.passed, audit.first
    assert [found.limit for found in audit.exceeded] == [
        "delta-v",
        "separation",
        "communication angle",
    ]
    assert all(found.factor > 1.01 for found in audit.exceeded)


@pytest.mark.parametrize("motion", ["two_body", "two_body_j2"])
def test_exact_motion_is_integrated_again(tmp_path, motion):
    flown = fly(tmp_path, sections(plant={"motion": motion, "argument_of_latitude_deg": 30.0}))
    audit = audit_bag(flown)
    assert audit.passed, audit.first
    worst = {check.name: check.worst for check in audit.checks}
    assert worst["motion = two bodies about the Earth, DOP853: position"] < 2e-9
    other = fly(tmp_path / "claimed", sections(plant={"motion": "hill"}))
    audit = audit_bag(rewrite(other, tmp_path / "mixed", messages_of(flown)))
    assert first_of(audit)[0] == "motion = Hill's equations, matrix exponential: position"


def test_a_saturated_delta_v_is_followed(tmp_path):
    """Without a governor the limit of the first craft holds at the start."""
    audit = audit_bag(fly(tmp_path, ungoverned()))
    assert audit.passed, audit.first
    assert audit.exceeded[0].limit == "delta-v"


def test_a_start_by_states_is_held_against_the_scenario(bag, messages, tmp_path):
    other = sections(plant={"initial_along_track_offset": [6103.0, 8325.0, 5036.001]})
    audit = audit_bag(rewrite(fly(tmp_path, other), tmp_path / "mixed", messages))
    assert first_of(audit) == ("start = the scenario's: position", 0, "hill_state.position[7]")


def test_other_weights_in_the_scenario_are_found(bag, messages, tmp_path):
    other = fly(tmp_path, sections(nmpc_controller={"weights": {"delta_v": 101.0}}))
    failed = {
        check.name
        for check in audit_bag(rewrite(other, tmp_path / "mixed", messages)).checks
        if check.first
    }
    assert {"command = the audit's own law", "cost of the shifts = W + Omega"} <= failed


def test_a_command_that_never_came_is_that_craft_s_idle_control(tmp_path):
    audit = audit_bag(fly(tmp_path, late=[(3, 1), (6, 2)], silent=[(7, 0)]))
    assert audit.passed, audit.first
    checks = {check.name: check for check in audit.checks}
    late = checks["applied where no command came in time"]
    assert late.verdict == "pass"
    assert late.note == "3 steps, as wall_timing counts them"
    assert (
        checks["steps of sc1/delta_v_command"].note == "1 steps without one, counted by the plant"
    )


def test_an_idle_step_that_the_plant_does_not_count_is_found(tmp_path):
    audit = audit_bag(fly(tmp_path, late=[(3, 1)], counted=False))
    assert first_of(audit)[0] == "applied = command"


def test_a_bag_of_other_craft_is_refused(bag, messages, tmp_path):
    flown = sections(
        plant={
            "spacecraft": ["sc1", "sc2"],
            "initial_phase": [18.0, 8.4],
            "initial_along_track_offset": [6103.0, 8325.0],
            "initial_amplitude": [1.53, 1.705],
        },
        reference_governor={"phase": [6, 0]},
    )
    mixed = rewrite(fly(tmp_path, flown), tmp_path / "mixed", messages)
    with pytest.raises(RecordingError, match="required 6, 3 for each craft of the scenario"):
        audit_bag(mixed)


def test_a_forged_bag_ends_the_command_with_1(forge, bag, capsys):
    for flown, code in ((bag, 0), (forge(STATE, add("position", 1e-3)), 1)):
        with pytest.raises(SystemExit) as ended:
            main(["audit", str(flown)])
        assert (ended.value.code or 0) == code
    assert "hill_state.position" in capsys.readouterr().out


@pytest.mark.parametrize(("signal", "change", "check"), FORGED.values(), ids=FORGED)
def test_a_forged_message_is_named(forge, signal, change, check):
    audit = audit_bag(forge(signal, change))
    failed = [found.name for found in audit.checks if found.first]
    assert any(name.startswith(check) for name in failed), failed
    assert first_of(audit)[1] in (STEP - 1, STEP, STEP + 1)
