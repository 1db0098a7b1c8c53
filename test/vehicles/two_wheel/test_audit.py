"""An audit of a flight with wheels passes what was flown, and names what was changed."""

from __future__ import annotations

import numpy as np
import pytest
from flown_bags import first_of, flipped, messages_of
from hypothesis import given, settings
from hypothesis import strategies as st
from recording.bags import CODEC
from wheel_bags import fly, rewrite, sections

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.signals.attitude import GOVERNOR_STATUS, REFERENCE
from spacecraft_gnc.vehicles.two_wheel.signals import COMMAND, STATE

PERIOD = 200_000_000  # [ns]
STEP = 7
EACH = [
    (signal, field)
    for signal in (STATE, COMMAND, REFERENCE, GOVERNOR_STATUS)
    for field in signal.fields
]


RUBBING = {
    "wheel_viscous_friction": [1e-3, 0.0, 2e-3, 1e-4],
    "wheel_coulomb_friction": [5e-3, 5e-3, 0.0, 1e-2],
    "initial_wheel_speed": [1.0, -39.5, 30.0, -0.3],
    "wheel_loss": "partial",
}


@pytest.fixture(scope="module", params=[{}, RUBBING], ids=["smooth", "rubbing"])
def bag(tmp_path_factory, request):
    return fly(tmp_path_factory.mktemp("flown"), sections(plant=request.param))[0]


@pytest.fixture(scope="module")
def messages(bag):
    return messages_of(bag)


@pytest.fixture(scope="module")
def tamper(bag, messages, tmp_path_factory):
    """Return a function that writes the bag again with one message changed."""

    def rewritten(topic, step, change):
        changed = [
            (found, stamp, change(data) if (found, stamp) == (f"/{topic}", step * PERIOD) else data)
            for found, stamp, data in messages
        ]
        assert sum(a != b for a, b in zip(messages, changed, strict=True)) == 1
        return rewrite(bag, tmp_path_factory.mktemp("tampered") / "bag", changed)

    return rewritten


def with_a_flipped_bit(signal, field):
    """Return a change of a message: the lowest bit of the last number of a field."""

    def change(data):
        message = CODEC.store.deserialize_cdr(data, signal.type)
        value = getattr(message, field)
        if isinstance(value, np.ndarray):
            value = value.copy()
            bits = value.view(np.uint8)
            bits[-value.itemsize] ^= 1
        elif isinstance(value, float):
            value = 1.0 if np.isinf(value) else float(np.nextafter(value, np.inf))
        elif isinstance(value, str):
            value = f"{value}x"
        elif isinstance(value, bool | int):
            value = type(value)(value ^ 1)
        else:
            value.z = float(np.nextafter(value.z, np.inf))
        setattr(message, field, value)
        return bytes(CODEC.store.serialize_cdr(message, signal.type))

    return change


def test_what_was_flown_passes(bag):
    audit = audit_bag(bag)
    assert audit.passed, audit.first
    assert audit.steps == 20
    verdicts = {check.name: check.verdict for check in audit.checks}
    for name in ("applied where no command came in time", "residuals of the wheels"):
        assert verdicts.pop(name) == "not applicable"
    assert set(verdicts.values()) == {"pass"}


@pytest.mark.parametrize(("signal", "field"), EACH, ids=str)
def test_one_flipped_bit_of_any_field_is_caught(tamper, signal, field):
    change = with_a_flipped_bit(signal, field)
    audit = audit_bag(tamper(signal.name, STEP, change))
    assert not audit.passed
    told = {check.first.field.partition("[")[0] for check in audit.checks if check.first}
    assert f"{signal}.{field}" in told
    assert first_of(audit)[1] in (STEP - 1, STEP)


@settings(max_examples=40, deadline=None)
@given(st.integers(36 * 8, 36 * 8 + (9 + 4) * 64 - 1))
def test_any_bit_of_attitude_and_orientation_is_caught(tamper, bit):
    changed = tamper("wheel_state", STEP, lambda data: flipped(data, bit))
    try:
        passed = audit_bag(changed).passed
    except RecordingError:  # the bit made a NaN or an infinity, which is no state
        passed = False
    assert not passed


def test_a_target_taken_in_flight_is_followed(tmp_path):
    bag, _ = fly(tmp_path, targets={9: lie.exp(np.array([0.0, 0.3, 0.0]))})
    audit = audit_bag(bag)
    assert audit.passed, audit.first
    notes = {check.name: check.note for check in audit.checks}
    assert notes["decision of the governor"] == "targets taken in flight: 1"


@pytest.mark.parametrize("loss", ["friction", "spinning", "partial"])
def test_a_flight_with_friction_through_rest_and_a_loss_passes(tmp_path, loss):
    flown = sections(plant={**RUBBING, "wheel_loss": loss, "wheel_lost_at": [2.0, 1.0, -1.0, -1.0]})
    bag, states = fly(tmp_path, flown)
    audit = audit_bag(bag)
    assert audit.passed, audit.first
    signs = np.sign([state.wheel_speed for state in states])
    assert (signs[0] * signs[-1] <= 0.0).any()


@pytest.mark.parametrize("name", ["wheel_viscous_friction", "wheel_coulomb_friction"])
def test_friction_that_the_scenario_does_not_tell_fails_both_kinds_of_equations(tmp_path, name):
    flown, _ = fly(tmp_path, sections(plant={**RUBBING, name: [1.1 * x for x in RUBBING[name]]}))
    other, _ = fly(tmp_path / "told", sections(plant=RUBBING))
    audit = audit_bag(rewrite(other, tmp_path / "mixed", messages_of(flown)))
    assert {
        "integrator, from each state",
        "wheel speeds = accelerations within limits, friction and health",
    } <= {check.name for check in audit.checks if check.first}


@pytest.mark.parametrize("mode", ["lockstep", "free_run"])
def test_steps_without_a_command_are_told_apart(tmp_path, mode):
    changed = sections(plant={"mode": mode, "max_held_steps": 1})
    audit = audit_bag(fly(tmp_path, changed, late=(4, 5, 11))[0])
    assert audit.passed, audit.first
    late = next(c for c in audit.checks if c.name == "applied where no command came in time")
    assert late.steps == 3


def test_another_inertia_in_the_scenario_fails_both_kinds_of_equations(bag, messages, tmp_path):
    """A bag whose scenario is not what flew: the plant's own code and the others disagree."""
    flown = sections(plant={"inertia": [1.0, 0.05, -0.1, 0.05, 0.8, 0.02, -0.1, 0.02, 0.91]})
    other, _ = fly(tmp_path, flown)
    audit = audit_bag(rewrite(other, tmp_path / "mixed", messages))
    failed = {check.name for check in audit.checks if check.first}
    assert {
        "integrator, from each state",
        "total momentum = R (J omega + A Js nu)",
        "command of the law",
        "attitude = Runge-Kutta integration",
    } <= failed


def test_other_wheels_than_those_of_the_scenario_are_refused(messages, tmp_path):
    axes = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    wheels = {"wheel_inertias": [0.01] * 3, "initial_wheel_speed": [], "wheel_lost_at": []}
    other, _ = fly(tmp_path, sections(plant={"wheel_axes": axes, **wheels}))
    with pytest.raises(RecordingError, match=r"wheel_state.wheel_speed: received 4 .*required 3"):
        audit_bag(rewrite(other, tmp_path / "mixed", messages))
