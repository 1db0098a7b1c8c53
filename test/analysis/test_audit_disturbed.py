"""An audit of disturbed flights: the recorded sum is integrated and flown again, bit for bit."""

from __future__ import annotations

from importlib import metadata

import numpy as np
import pytest
from flown_bags import first_of, flipped, fly, messages_of, rewrite, sections
from hypothesis import given, settings
from hypothesis import strategies as st

from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.analysis.reader import read_flight
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.plant.disturbances import registry
from spacecraft_gnc.scenario import from_sections

NS = 400_000_000  # control period [ns]
EXTERNAL = "plant_invariants.external_torque"
CHECK = "external torque = sum of the disturbances"
BYTE = 108
"""Of the first number of external_torque in a plant_invariants message."""
DISTURBED = {
    "disturbances": ["constant", "gravity_gradient", "noise"],
    "constant_torque": [1e-4, -2e-4, 5e-5],
    "orbit_rate": 1.1e-3,
    "noise_torque": [1e-5, 1e-5, 1e-5],
    "seed": 7,
}


class Drag:
    """A disturbance of another package."""

    @classmethod
    def from_parameters(cls, parameters, inertia):
        del parameters, inertia
        return cls()

    def torque(self, motion):
        return -1e-2 * motion.angular_velocity


class Entry:
    name = "drag"

    def load(self):
        return Drag


@pytest.fixture(scope="module", params=[1, 2])
def flown(request, tmp_path_factory):
    plant = DISTURBED | {"time_step": 0.4 / request.param}
    said = sections(plant=plant, nmpc_controller={"time_step": 0.4})
    bag = fly(tmp_path_factory.mktemp("disturbed"), said)
    return bag, messages_of(bag), said


def check_of(audit, name):
    return next(check for check in audit.checks if check.name == name)


def test_a_disturbed_flight_passes(flown):
    audit = audit_bag(flown[0])
    assert audit.passed, audit.first
    assert check_of(audit, CHECK).examined == {EXTERNAL: 13}
    assert check_of(audit, "integrator, from each state").steps == 12


def test_a_bag_holds_the_columns_of_the_simulation(flown):
    bag, _, said = flown
    simulated = from_sections(said).build().run()
    recorded = read_flight(bag).trajectory
    assert np.abs(simulated.external_torque).min(axis=0).max() > 1e-5
    for name in ("external_torque", "reference_rate", "reference_torque", "torque", "attitude"):
        assert getattr(recorded, name).tobytes() == getattr(simulated, name).tobytes(), name


def test_an_undisturbed_flight_has_none(tmp_path):
    bag = fly(tmp_path)
    assert not read_flight(bag).trajectory.external_torque.any()
    assert check_of(audit_bag(bag), CHECK).verdict == "pass"


@settings(max_examples=20)
@given(step=st.integers(0, 12), component=st.integers(0, 2), bit=st.integers(0, 63))
def test_one_bit_is_caught(flown, tmp_path_factory, step, component, bit):
    bag, messages, _ = flown
    at = 8 * (BYTE + 8 * component) + bit
    changed = [
        (topic, stamp, flipped(data, at))
        if (topic, stamp) == ("/plant_invariants", step * NS)
        else (topic, stamp, data)
        for topic, stamp, data in messages
    ]
    tampered = rewrite(bag, tmp_path_factory.mktemp("tampered") / "bag", changed)
    try:
        audit = audit_bag(tampered)
    except RecordingError as error:  # an exponent of ones is no number: the bag is refused
        assert f"step {step}, field external_torque: received" in str(error)  # noqa: PT017
        return
    assert first_of(audit) == (CHECK, step, f"{EXTERNAL}[{component}]")


def test_a_disturbance_that_the_scenario_does_not_list_is_caught(tmp_path):
    plant = {"disturbances": ["constant"], "constant_torque": [1e-4, 0.0, 0.0]}
    bag = fly(tmp_path, sections(plant=plant), claimed=sections())
    assert first_of(audit_bag(bag)) == (CHECK, 1, f"{EXTERNAL}[0]")


def test_one_that_is_not_installed_is_taken_from_the_recording(tmp_path, monkeypatch):
    plant = {"disturbances": ["drag", "constant"], "constant_torque": [1e-4, 0.0, 0.0]}
    with monkeypatch.context() as installed:
        installed.setattr(
            metadata, "entry_points", lambda group: [Entry()] * (group == registry.GROUP)
        )
        bag = fly(tmp_path, sections(plant=plant))
        assert check_of(audit_bag(bag), CHECK).verdict == "pass"
    audit = audit_bag(bag)
    assert audit.passed, audit.first
    assert check_of(audit, CHECK).verdict == "not applicable"
    assert check_of(audit, CHECK).note == ("not installed: drag; the recorded sum is integrated")
    assert check_of(audit, "integrator, from the start").steps == 13
    changed = [
        (
            topic,
            stamp,
            flipped(data, 8 * BYTE + 40)
            if (topic, stamp) == ("/plant_invariants", 5 * NS)
            else data,
        )
        for topic, stamp, data in messages_of(bag)
    ]
    name, step, _ = first_of(audit_bag(rewrite(bag, tmp_path / "tampered", changed)))
    assert (name, step) == ("integrator, from each state", 5)
