"""An audit of flights whose reference moves: what is right passes, one changed bit does not."""

from __future__ import annotations

import pytest
from flown_bags import flipped, fly, messages_of, rewrite, sections
from hypothesis import given, settings
from hypothesis import strategies as st

from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.errors import RecordingError

NS = 400_000_000  # control period [ns]
FIELDS = {"angular_velocity": 140, "torque": 164}
"""Byte of the first number in an attitude_reference message."""
TURNING = {
    "governor": "turning_reference",
    "target_rotation_vector": [0.2, 0.45, 0.5],
    "reference_rate": [0.02, 0.03, -0.01],
}


def moving(**changes):
    return sections(reference_governor=TURNING, **changes)


@pytest.fixture(
    scope="module",
    params=["shooting", "neighboring_extremal", "slsqp", "fsolve", "single_shooting", "feedback"],
)
def bag(request, tmp_path_factory):
    method = {"method": request.param}
    if request.param == "single_shooting":
        method = {"method": "shooting", "formulation": "single_shooting"}
    return fly(tmp_path_factory.mktemp("moving"), moving(nmpc_controller=method))


def test_what_was_flown_passes(bag):
    audit = audit_bag(bag)
    assert audit.passed, audit.first
    checks = {check.name: check for check in audit.checks}
    assert checks["decision of the governor"].verdict == "pass"
    assert "attitude_reference.torque" in checks["decision of the governor"].examined


def test_steps_of_the_plant_that_are_shorter_than_the_period(tmp_path):
    """The momentum of a body on its way is that of the plant's integrator."""
    flown = moving(plant={"time_step": 0.1}, nmpc_controller={"time_step": 0.4})
    audit = audit_bag(fly(tmp_path, flown))
    assert audit.passed, audit.first


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    bag = fly(tmp_path_factory.mktemp("changed"), moving())
    return bag, messages_of(bag)


@settings(max_examples=20)
@given(
    field=st.sampled_from(sorted(FIELDS)),
    step=st.integers(0, 11),
    component=st.integers(0, 2),
    bit=st.integers(0, 63),
)
def test_one_bit_of_the_feedforward_is_caught(flown, tmp_path_factory, field, step, component, bit):
    bag, messages = flown
    at = 8 * (FIELDS[field] + 8 * component) + bit
    changed = [
        (topic, stamp, flipped(data, at))
        if (topic, stamp) == ("/attitude_reference", step * NS)
        else (topic, stamp, data)
        for topic, stamp, data in messages
    ]
    tampered = rewrite(bag, tmp_path_factory.mktemp("tampered") / "bag", changed)
    try:
        audit = audit_bag(tampered)
    except RecordingError as error:  # an exponent of ones is no number: the bag is refused
        assert f"step {step}, field {field}: received" in str(error)  # noqa: PT017
        return
    assert audit.first is not None
    check, first = audit.first
    assert (first.step, first.field) == (step, f"attitude_reference.{field}[{component}]"), check


@pytest.mark.parametrize("field", FIELDS)
def test_the_certificates_alone_refuse_another_motion(flown, tmp_path, field):
    """A sixteenth more or less: the plan is not optimal for that reference."""
    bag, messages = flown
    changed = [
        (topic, stamp, flipped(data, 8 * (FIELDS[field] + 8) + 48) if stamp == 3 * NS
         and topic == "/attitude_reference" else data)
        for topic, stamp, data in messages
    ]  # fmt: skip
    audit = audit_bag(rewrite(bag, tmp_path / "bag", changed))
    failed = {check.name for check in audit.checks if check.verdict == "FAIL"}
    assert {"residual (backward_sweep)", "cost"} <= failed


def test_a_ladder_over_a_moving_reference_is_followed(tmp_path):
    bag = fly(tmp_path, moving(nmpc_controller={"continuation": "none"}), failing=(5, 6))
    audit = audit_bag(bag)
    names = {check.name for check in audit.checks if check.verdict == "FAIL"}
    assert names == {"claimed failures, solved again"}  # they had not failed
