"""Flights read back from bags: aligned by step, honest about what is missing."""

from __future__ import annotations

import random
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from recording.bags import CODEC, announce, flight_messages, random_flight, record

from spacecraft_gnc.analysis.reader import load_run, read_flight
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording.writer import BagWriter
from spacecraft_gnc.vehicles.rigid_body.flight import RigidBodyFlight

FLIGHT = random_flight(12)
SCENARIO = """
plant:
  ros__parameters:
    inertia: [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]
    time_step: 0.4
nmpc_controller:
  ros__parameters:
    max_torque: 0.02
    zone_names: [star]
    zones:
      star: {body_axis: [1.0, 0.0, 0.0], inertial_axis: [0.0, 1.0, 0.0], half_angle_deg: 5.0}
"""


def assert_same(read, flown):
    for item in fields(RigidBodyFlight):
        np.testing.assert_array_equal(
            getattr(read, item.name), getattr(flown, item.name), err_msg=item.name
        )


def lose(*lost):
    """Return the messages of the flight without those of (topic, step); None: a whole topic."""
    return [
        item
        for item in flight_messages(FLIGHT)
        if item[:2] not in lost and (item[0], None) not in lost
    ]


def test_a_flight_comes_back_bit_for_bit(tmp_path):
    trajectory, info = read_flight(record(tmp_path / "bag", flight_messages(FLIGHT)))
    assert_same(trajectory, FLIGHT)
    assert info.warnings() == []
    assert info.scenario is None
    assert info.metadata["losses"]["/attitude_state"] == "0"


def test_a_single_file_is_read_too(tmp_path):
    bag = record(tmp_path / "bag", flight_messages(FLIGHT))
    assert_same(read_flight(bag / "bag_0.mcap").trajectory, FLIGHT)


@settings(max_examples=20)
@given(seed=st.integers(0, 1000), n=st.integers(1, 6))
def test_neither_order_nor_time_stamps_decide_what_belongs_together(tmp_path_factory, seed, n):
    flight = random_flight(n, seed)
    items = flight_messages(flight)
    random.Random(seed).shuffle(items)
    folder = tmp_path_factory.mktemp("bags") / "bag"
    with BagWriter(folder) as bag:
        announce(bag)
        for topic, _, data in items:
            bag.write(f"/{topic}", 7, 7, data)
    assert_same(read_flight(folder).trajectory, flight)


def test_repeated_messages_count_once(tmp_path):
    items = flight_messages(FLIGHT)
    bag = record(tmp_path / "bag", sorted([*items, *items[10:30]], key=lambda item: item[1]))
    assert_same(read_flight(bag).trajectory, FLIGHT)


def test_commands_stand_in_where_the_plant_says_nothing(tmp_path):
    bag = record(tmp_path / "bag", lose(("plant_invariants", None)))
    unknown = np.full_like(FLIGHT.external_torque, np.nan)
    assert_same(read_flight(bag).trajectory, replace(FLIGHT, external_torque=unknown))


def test_the_torque_that_acted_counts_not_the_command(tmp_path):
    zero = [("plant_invariants", 5, CODEC.invariants(5, np.zeros(3), source=4))]
    bag = record(tmp_path / "bag", lose(("plant_invariants", 5)) + zero)
    trajectory, info = read_flight(bag)
    np.testing.assert_array_equal(trajectory.torque[4], np.zeros(3))
    assert trajectory.source[4] == 4
    assert info.overridden == (4,)
    assert "applied another torque than commanded in step 4" in info.warnings()[0]


def test_a_lost_state_and_a_lost_torque_are_reported_and_nan(tmp_path):
    lost = ("attitude_state", 3), ("torque_command", 6), ("plant_invariants", 7)
    trajectory, info = read_flight(record(tmp_path / "bag", lose(*lost)))
    assert trajectory.n_steps == FLIGHT.n_steps
    assert np.isnan(trajectory.attitude[3]).all()
    assert np.isnan(trajectory.torque[6]).all()
    assert trajectory.source[6] == -1
    assert np.isfinite(trajectory.attitude[[2, 4]]).all()
    assert info.missing == {"attitude_state": (3,), "torque_command": (6,)}
    assert [line.split(": ")[1] for line in info.warnings()] == [
        "attitude_state lacks step 3",
        "torque_command lacks step 6",
        "/plant_invariants lost 1 on the way to the recorder",
    ]
    np.testing.assert_array_equal(trajectory.time, FLIGHT.time)


def test_a_flight_without_its_last_state_ends_a_step_earlier(tmp_path):
    trajectory, info = read_flight(record(tmp_path / "bag", lose(("attitude_state", 12))))
    assert trajectory.n_steps == 11
    np.testing.assert_array_equal(trajectory.final_attitude, FLIGHT.attitude[11])
    np.testing.assert_array_equal(trajectory.final_reference, FLIGHT.reference[10])
    assert info.missing == {"attitude_state": (12,)}


def test_a_flight_without_its_last_torque_ends_there(tmp_path):
    lost = ("torque_command", 11), ("plant_invariants", 12), ("attitude_state", 12)
    trajectory, info = read_flight(record(tmp_path / "bag", lose(*lost)))
    assert trajectory.n_steps == 11
    assert info.missing == {}


def test_without_references_and_solves_the_rows_say_so(tmp_path):
    lost = ("attitude_reference", None), ("solver_status", None)
    trajectory, info = read_flight(record(tmp_path / "bag", lose(*lost)))
    np.testing.assert_array_equal(trajectory.reference[7], np.eye(3))
    assert (trajectory.status == -1).all()
    assert (trajectory.iterations == 0).all()
    assert np.isnan(trajectory.solve_time).all()
    assert info.missing == {}


def test_many_lost_steps_are_summed_up(tmp_path):
    lost = [("attitude_reference", step) for step in (2, 3, 9)]
    _, info = read_flight(record(tmp_path / "bag", lose(*lost)))
    assert info.warnings()[0].endswith("attitude_reference lacks 3 steps (first 2, last 9)")


def test_the_recorded_scenario_is_loaded(tmp_path):
    bag = record(tmp_path / "bag", flight_messages(FLIGHT), scenario=SCENARIO)
    info = read_flight(bag).info
    assert info.scenario.controller.max_torque == 0.02
    assert [zone.name for zone in info.scenario.controller.zones] == ["star"]
    assert info.scenario_text == SCENARIO
    assert info.scenario.path == f"{bag}/scenario.yaml"


def test_the_scenario_of_a_flight_cut_short_is_loaded(tmp_path):
    """`gnc launch --duration` records the short duration as that of the file."""
    short = SCENARIO.replace(
        "time_step: 0.4", "duration: 4.8\n    initial_momentum: [0.0, 0.0, 0.2]"
    )
    info = read_flight(record(tmp_path / "bag", flight_messages(FLIGHT), scenario=short)).info
    assert info.warnings() == []
    assert info.scenario.plant.duration == 4.8


def test_a_scenario_that_this_version_refuses_is_a_warning(tmp_path):
    bag = record(
        tmp_path / "bag", flight_messages(FLIGHT), scenario=SCENARIO.replace("max_torque", "thrust")
    )
    trajectory, info = read_flight(bag)
    assert_same(trajectory, FLIGHT)
    assert info.scenario is None
    (warning,) = info.warnings()
    assert "recorded scenario not used: scenario.yaml" in warning
    assert "thrust" in warning


def test_a_namespace_tells_spacecraft_apart(tmp_path):
    other = random_flight(12, seed=5)
    with BagWriter(tmp_path / "bag") as bag:
        for name, flight in (("/chaser", FLIGHT), ("/target", other)):
            announce(bag, name)
            for topic, step, data in flight_messages(flight):
                bag.write(f"{name}/{topic}", step, step, data)
    assert_same(read_flight(tmp_path / "bag", namespace="target").trajectory, other)
    with pytest.raises(RecordingError, match=r"several spacecraft \(/chaser, /target\)"):
        read_flight(tmp_path / "bag")
    with pytest.raises(RecordingError, match=r"no topic .*attitude_state or .* in namespace third"):
        read_flight(tmp_path / "bag", namespace="third")


def test_stamps_that_leave_the_grid_are_believed(tmp_path):
    late = CODEC.state(3, FLIGHT.attitude[3], FLIGHT.momentum[3], stamp_ns=1_234_567_890)
    bag = record(tmp_path / "bag", [*lose(("attitude_state", 3)), ("attitude_state", 3, late)])
    times = read_flight(bag).trajectory.time
    assert times[3] == pytest.approx(1.23456789, abs=1e-15)
    assert times[4] == FLIGHT.time[4]


def test_load_run_reads_what_simulate_writes(tmp_path):
    flown = replace(FLIGHT, period=0.1)
    path = flown.save(tmp_path / "flight.npz")
    trajectory, info = load_run(path)
    assert_same(trajectory, flown)
    assert info.warnings() == []
    bag = record(tmp_path / "bag", flight_messages(FLIGHT))
    assert_same(load_run(bag).trajectory, FLIGHT)
