"""An audit passes what was flown, and names the first step and field of whatever was changed."""

from __future__ import annotations

import struct

import pytest
from flown_bags import fly, messages_of, rewrite
from hypothesis import example, given, settings
from hypothesis import strategies as st

from spacecraft_gnc.analysis.audit.run import audit_bag
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.columns import read_columns

# Bytes of a serialized message: four of encapsulation, the stamp, the frame, padding, the step.
NS = 400_000_000  # control period [ns]
FIELDS = {
    ("attitude_state", "attitude"): (36, 9),
    ("attitude_state", "orientation"): (108, 4),
    ("attitude_state", "angular_momentum"): (140, 3),
    ("attitude_state", "angular_velocity"): (164, 3),
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
        return read_columns(opened, [topic for topic, _ in FIELDS])


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


def flipped(data, bit):
    """Return the bytes with one bit, counted from the first byte on, changed."""
    changed = bytearray(data)
    changed[bit // 8] ^= 1 << bit % 8
    return bytes(changed)


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
        assert f"step {step}, field {name}: received" in str(error)
        return
    assert audit.first is not None
    check, first = audit.first
    # the torque of step k - 1 is told with the invariants of step k
    told = step - 1 if topic == "plant_invariants" and step else step
    assert (first.step, first.field) == (told, f"{topic}.{name}[{component}]"), check
