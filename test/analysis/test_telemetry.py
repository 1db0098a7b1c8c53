"""What a run tells beside its trajectory."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from analysis.flights import at_rest, case1, scenario
from recording.bags import CODEC, flight_messages, random_flight, record

from spacecraft_gnc.analysis.flown import flown as told
from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.analysis.reader import load_run
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.vehicles.rigid_body.telemetry import computed

FLIGHT = random_flight(6)
LOST = 2


def test_what_the_plant_published_is_kept_by_step(tmp_path):
    items = []
    for topic, step, data in flight_messages(FLIGHT):
        if topic != "plant_invariants":
            items.append((topic, step, data))
        elif step != LOST:
            message = CODEC.make(
                "PlantInvariants",
                header=CODEC.header(step),
                step=step,
                kinetic_energy=0.1 * step,
                inertial_momentum=CODEC.vector([step, 0.5, -1.0]),
                orthogonality_error=1e-16 * step,
                applied_torque=CODEC.vector([0.0, 0.0, 0.0]),
                applied_source=0,
                external_torque=CODEC.vector([0.0, 0.0, 0.0]),
            )
            name = "spacecraft_gnc_msgs/msg/PlantInvariants"
            items.append((topic, step, bytes(CODEC.store.serialize_cdr(message, name))))
    found = told("run", load_run(record(tmp_path / "bag", items)), None).telemetry
    steps = np.arange(7.0)
    steps[LOST] = np.nan
    assert found.invariants_recorded
    np.testing.assert_array_equal(found.kinetic_energy, 0.1 * steps)
    np.testing.assert_array_equal(found.inertial_momentum[:, 0], steps)
    np.testing.assert_array_equal(found.orthogonality_error, 1e-16 * steps)
    assert np.isnan(found.min_curvature).all()
    assert found.min_curvature.shape == found.deadline_slack.shape == (6,)


def test_of_a_file_the_invariants_are_those_of_its_states(tmp_path):
    flown = case1()
    flight = load_run(flown.save(tmp_path / "case1.npz"))
    found = told("run", flight, scenario()).telemetry
    inertia = np.diag([1.0, 0.8, 0.8])
    for k in (0, 30, 374):
        energy = 0.5 * flown.momentum[k] @ np.linalg.inv(inertia) @ flown.momentum[k]
        np.testing.assert_allclose(found.kinetic_energy[k], energy, rtol=1e-14)
        momentum = flown.attitude[k] @ flown.momentum[k]
        np.testing.assert_allclose(found.inertial_momentum[k], momentum, rtol=1e-14, atol=1e-18)
    assert found.orthogonality_error.max() < 1e-12
    assert not found.invariants_recorded


def test_without_an_inertia_the_energy_is_not_known():
    found = computed(at_rest())
    assert np.isnan(found.kinetic_energy).all()
    assert (found.inertial_momentum == 0.0).all()


def test_a_lost_state_does_not_hide_the_error_of_the_neighboring_extremals():
    source = np.full(20, Source.NEIGHBORING_EXTREMAL)
    attitude = np.tile(np.eye(3), (20, 1, 1))
    attitude[4] = np.nan
    flown = replace(at_rest(), source=source, attitude=attitude)
    assert summarize(flown, scenario())["neighboring_error"] < 1e-12
