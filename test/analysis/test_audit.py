"""An audit passes what was flown, and names the first step and field of whatever was changed."""

from __future__ import annotations

import struct

import pytest
from flown_bags import edited, first_of, flipped, fly, messages_of, rewrite, sections
from hypothesis import example, given, settings
from hypothesis import strategies as st

from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.columns import read_columns
from spacecraft_gnc.recording.rebuild import rebuild
from spacecraft_gnc.vehicles.rigid_body.signals import SIGNALS

# Bytes of a serialized message: four of encapsulation, the stamp, the frame, padding, the step.
NS = 400_000_000  # control period [ns]
FIELDS = {
    ("attitude_state", "attitude"): (36, 9),
    ("attitude_state", "orientation"): (108, 4),
    ("attitude_state", "angular_momentum"): (140, 3),
    ("attitude_state", "angular_velocity"): (164, 3),
    ("attitude_reference", "angular_velocity"): (140, 3),
    ("attitude_reference", "torque"): (164, 3),
    ("torque_command", "torque"): (36, 3),
    ("plant_invariants", "applied_torque"): (76, 3),
}
"""Place of the first number, and how many there are."""


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return fly(tmp_path_factory.mktemp("flown"))


@pytest.fixture(scope="module")
def messages(bag):
    return messages_of(bag)


@pytest.fixture(scope="module")
def flown(bag):
    with open_bag(bag) as opened:
        found = read_columns(opened, [signal for signal in SIGNALS if signal.is_stepped])
        return {signal.name: columns for signal, columns in found.items()}


@pytest.mark.parametrize(("topic", "name"), FIELDS)
def test_the_places_of_the_fields_are_right(messages, flown, topic, name):
    data = [data for found, _, data in messages if found == f"/{topic}"][5]
    at, n = FIELDS[topic, name]
    assert list(struct.unpack_from(f"<{n}d", data, at)) == flown[topic].fields[name][5].tolist()


def test_what_was_flown_passes(bag):
    audit = audit_bag(bag)
    assert audit.passed, audit.first
    assert audit.steps == 12
    verdicts = {check.name: check.verdict for check in audit.checks}
    assert verdicts["integrator, from each state"] == "pass"
    assert verdicts["residual (backward_sweep)"] == "pass"
    assert verdicts["zone margins"] == "not applicable"


@pytest.fixture(scope="module")
def tamper(bag, messages, tmp_path_factory):
    """Return a function that writes the bag again with the bytes of one message changed."""

    def rewritten(topic, step, change):
        changed = [
            (found, stamp, change(data) if (found, stamp) == (f"/{topic}", step * NS) else data)
            for found, stamp, data in messages
        ]
        assert sum(a != b for a, b in zip(messages, changed, strict=True)) == 1
        return rewrite(bag, tmp_path_factory.mktemp("tampered") / "bag", changed)

    return rewritten


@settings(max_examples=60)
@given(
    field=st.sampled_from(sorted(FIELDS)),
    step=st.integers(0, 11),
    component=st.integers(0, 8),
    bit=st.integers(0, 63),
)
@example(field=("attitude_state", "attitude"), step=0, component=0, bit=0)
@example(field=("attitude_state", "orientation"), step=11, component=3, bit=0)
@example(field=("plant_invariants", "applied_torque"), step=0, component=1, bit=63)
@example(field=("torque_command", "torque"), step=11, component=2, bit=0)
def test_one_bit_flipped_is_caught(tamper, field, step, component, bit):
    topic, name = field
    at, n = FIELDS[field]
    component %= n
    tampered = tamper(topic, step, lambda data: flipped(data, 8 * (at + 8 * component) + bit))
    try:
        audit = audit_bag(tampered)
    except RecordingError as error:  # an exponent of ones is no number: the bag is refused
        assert f"step {step}, field {name}: received" in str(error)  # noqa: PT017
        return
    assert audit.first is not None
    check, first = audit.first
    # the torque of step k - 1 is told with the invariants of step k
    told = step - 1 if topic == "plant_invariants" and step else step
    assert (first.step, first.field) == (told, f"{topic}.{name}[{component}]"), check


@pytest.mark.long
@settings(max_examples=60)
@given(index=st.integers(0, 75), place=st.floats(0.0, 1.0, exclude_max=True), bit=st.integers(0, 7))
def test_whatever_is_changed_ends_in_a_verdict(bag, messages, tmp_path_factory, index, place, bit):
    """Some bits mean nothing (padding, wall times), the others are found; none is a traceback."""
    topic, stamp, data = messages[index % len(messages)]
    at = 8 * (4 + int(place * (len(data) - 4))) + bit
    changed = list(messages)
    changed[index % len(messages)] = (topic, stamp, flipped(data, at))
    try:
        audit = audit_bag(rewrite(bag, tmp_path_factory.mktemp("any") / "bag", changed))
    except RecordingError as error:
        assert len(str(error).splitlines()) == 1  # noqa: PT017
        return
    assert audit.passed or audit.first is not None


CERTIFICATE = {
    "residual": 1e-9,
    "cost": 1e-9,
    "torque_margin": 1e-9,
    "min_curvature": 0.01,
    "status": 1,
}
"""Fields of a certificate, and by how much they are changed."""


@pytest.mark.parametrize(("name", "more"), CERTIFICATE.items())
def test_a_certificate_that_claims_something_else_is_caught(tamper, name, more):
    audit = audit_bag(tamper("solver_status", 4, edited("SolverStatus", **{name: more})))
    _, step, field = first_of(audit)
    expected = "torque_command.source" if name == "status" else f"solver_status.{name}"
    assert (step, field) == (4, expected)


@pytest.mark.parametrize(
    ("name", "at", "check"),
    [
        ("first_costate", 4, "first costate"),
        ("predicted_attitudes", 9, "plan obeys the dynamics: rotations"),
        ("predicted_attitudes", 0, "plan starts at the state"),
        ("predicted_momenta", 16, "plan obeys the dynamics: momenta"),
        ("predicted_torques", 14, "plan obeys the dynamics: momenta"),
        ("predicted_torques", 1, "command = first torque of the plan"),
    ],
)
def test_a_plan_that_is_not_that_of_the_certificate_is_caught(tamper, name, at, check):
    def changed(values):
        other = values.copy()
        other[at] += 1e-7
        return other

    audit = audit_bag(tamper("solver_status", 7, edited("SolverStatus", **{name: changed})))
    assert first_of(audit)[:2] == (check, 7)


@pytest.mark.parametrize("topic", ["attitude_state", "torque_command", "solver_status"])
def test_a_missing_step_is_named(bag, messages, tmp_path, topic):
    left = [item for item in messages if item[:2] != (f"/{topic}", 5 * NS)]
    audit = audit_bag(rewrite(bag, tmp_path / "bag", left))
    assert first_of(audit) == (f"steps of {topic}", 5, f"{topic} (missing)")


def test_a_step_sent_again_passes_and_another_one_in_its_place_does_not(bag, messages, tmp_path):
    repeated = [item for item in messages for _ in range(1 + (item[1] == 3 * NS))]
    audit = audit_bag(rewrite(bag, tmp_path / "same", repeated))
    assert audit.passed
    notes = {check.name: check.note for check in audit.checks}
    assert notes["steps of attitude_state"] == "1 sent again with the same bytes"
    other = [
        (topic, stamp, edited("TorqueCommand", source=1)(data))
        for topic, stamp, data in messages
        if (topic, stamp) == ("/torque_command", 3 * NS)
    ]
    audit = audit_bag(rewrite(bag, tmp_path / "other", messages + other))
    assert first_of(audit)[1:] == (3, "torque_command (two different messages)")


def test_a_flight_that_stopped_early_is_told_and_accepted_if_asked(bag, messages, tmp_path):
    early = [item for item in messages if item[1] < 8 * NS]
    cut = rewrite(bag, tmp_path / "bag", [*early, *(m for m in messages if m[1] == 8 * NS)][:-4])
    audit = audit_bag(cut)
    assert first_of(audit) == ("length of the flight", 8, "the last step")
    assert audit_bag(cut, allow_unfinished=True).passed


@pytest.mark.parametrize("topic", ["attitude_state", "attitude_reference", "torque_command"])
def test_a_flight_that_was_stopped_may_end_in_mid_step(bag, messages, tmp_path, topic):
    """A signal ends the nodes one by one: any message of the last step may be missing."""
    kept = [m for m in messages if m[1] < 8 * NS and m[:2] != (f"/{topic}", 7 * NS)]
    stopped = rewrite(bag, tmp_path / "bag", kept)
    assert not audit_bag(stopped).passed
    audit = audit_bag(stopped, allow_unfinished=True)
    assert audit.passed, audit.first
    assert audit.steps == (6 if topic == "attitude_state" else 7)


def test_a_bag_cut_off_is_audited_as_far_as_it_goes(bag, messages, tmp_path):
    for left in range(len(messages) - 5, len(messages)):
        folder = rewrite(bag, tmp_path / str(left), messages[:left])
        (folder / "metadata.yaml").unlink()
        audit = audit_bag(folder, allow_unfinished=True)
        assert audit.passed, audit.first


def test_a_recovered_bag_is_audited_but_for_its_length(bag, messages, tmp_path):
    folder = rewrite(bag, tmp_path / "cut", messages[:-9])
    (folder / "metadata.yaml").unlink()
    audit = audit_bag(rebuild(folder).folder)
    assert audit.passed, audit.first
    assert 0 < audit.steps < 12
    (length,) = [check for check in audit.checks if check.name == "length of the flight"]
    saved = f"{audit.steps} of 12 steps were saved"
    assert (length.verdict, length.note) == (
        "not applicable", f"the bag was cut off and recovered: {saved}"
    )  # fmt: skip
    states = next(check for check in audit.checks if check.name == "integrator, from the start")
    assert (states.verdict, states.steps) == ("pass", audit.steps + 1)


def test_a_recovered_bag_that_was_changed_is_caught(bag, messages, tmp_path):
    changed = [
        (topic, stamp, flipped(data, 8 * 36) if (topic, stamp) == ("/torque_command", NS) else data)
        for topic, stamp, data in messages[:-9]
    ]
    folder = rewrite(bag, tmp_path / "cut", changed)
    (folder / "metadata.yaml").unlink()
    assert first_of(audit_bag(rebuild(folder).folder))[1:] == (1, "torque_command.torque[0]")


def test_a_stamp_off_the_grid_is_caught(tamper):
    def later(header):
        header.stamp.nanosec += 1
        return header

    audit = audit_bag(tamper("torque_command", 6, edited("TorqueCommand", header=later)))
    assert first_of(audit) == ("time stamps", 6, "torque_command.header.stamp")


def test_another_start_than_the_scenarios_is_caught(bag, tmp_path):
    """A whole flight, consistent in itself, but not the one that the scenario says."""
    start = {"initial_rotation_vector": [0.25, 0.5, 0.4999]}
    other = fly(tmp_path, sections(plant=start))
    swapped = rewrite(bag, tmp_path / "swapped", messages_of(other))
    check, step, field = first_of(audit_bag(swapped))
    assert (check, step) == ("integrator, from the start", 0)
    assert field.startswith("attitude_state.attitude")


def test_other_weights_than_the_scenarios_are_caught(bag, tmp_path):
    other = fly(tmp_path, sections(nmpc_controller={"weights": {"stage_attitude": 0.02}}))
    swapped = rewrite(bag, tmp_path / "swapped", messages_of(other))
    assert first_of(audit_bag(swapped)) == (
        "residual (backward_sweep)", 0, "solver_status.residual",
    )  # fmt: skip


def test_a_stated_tolerance_lets_rounding_through_and_no_more(tamper):
    changed = tamper("attitude_state", 5, lambda data: flipped(data, 8 * 140 + 3))
    assert not audit_bag(changed).passed
    failed = {check.name for check in audit_bag(changed, tolerance=1e-12).checks if check.first}
    assert failed == {"plan starts at the state"}  # no rounding stands between those two
    large = tamper("attitude_state", 5, lambda data: flipped(data, 8 * 140 + 40))
    assert first_of(audit_bag(large, tolerance=1e-12))[0] == "integrator, from each state"
