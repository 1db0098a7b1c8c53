"""Columns hold exactly what decoding message by message finds, whatever their layouts."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from recording.bags import CODEC, announce, flight_messages, random_flight, record

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording import steps
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.columns import iter_columns, read_columns
from spacecraft_gnc.recording.steps import flight_topics
from spacecraft_gnc.recording.writer import BagWriter
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.signals.graph import WALL_TIMING
from spacecraft_gnc.vehicles.rigid_body.signals import SOLVER_STATUS, STATE, TORQUE

FLIGHT = random_flight(12)
numbers = st.floats(allow_nan=False, allow_infinity=False, width=64)
words = st.text("abc_ é", max_size=9)


@st.composite
def statuses(draw):
    """Return a SolverStatus with words and sequences of any length."""

    def several(most=7):
        return np.array(draw(st.lists(numbers, max_size=most)))

    step = draw(st.integers(0, 40))
    return CODEC.make(
        "SolverStatus",
        header=CODEC.header(step, draw(words)),
        step=step,
        method=draw(words),
        formulation=draw(words),
        status=draw(st.integers(0, 255)),
        iterations=draw(st.integers(0, 2**32 - 1)),
        residual=draw(numbers),
        cost=draw(numbers),
        first_costate=np.array(draw(st.lists(numbers, min_size=6, max_size=6))),
        torque_margin=draw(numbers),
        zone_margins=several(),
        min_curvature=draw(st.floats()),
        closed_loop_radius=draw(st.floats()),
        active_constraint=draw(words),
        predicted_attitudes=several(),
        predicted_momenta=several(),
        predicted_torques=several(),
        wall_solve_time=draw(st.floats()),
        wall_deadline_slack=draw(st.floats()),
    )


def padded(values, longest):
    return np.pad(values, (0, longest - len(values)), constant_values=np.nan)


@settings(max_examples=50)
@given(messages=st.lists(statuses(), min_size=1, max_size=12))
def test_any_messages_come_back_as_decoded_one_by_one(tmp_path_factory, messages):
    folder = tmp_path_factory.mktemp("columns") / "bag"
    name = "spacecraft_gnc_msgs/msg/SolverStatus"
    data = [bytes(CODEC.store.serialize_cdr(message, name)) for message in messages]
    state = ("attitude_state", 0, CODEC.state(0, np.eye(3), np.zeros(3)))
    record(folder, [state, *[("solver_status", 0, item) for item in data]])
    with open_bag(folder) as bag:
        columns = read_columns(bag, [SOLVER_STATUS])[SOLVER_STATUS]
    first = {}
    for message in messages:
        first.setdefault(message.step, message)
    assert columns.steps.tolist() == sorted(first)
    assert columns.repeats == len(messages) - len(first)
    for row, step in enumerate(sorted(first)):
        message = first[step]
        assert columns.stamps[row] == message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
        for key, values in columns.fields.items():
            expected = getattr(message, key)
            if isinstance(expected, np.ndarray):
                expected = padded(expected, values.shape[1])
            np.testing.assert_array_equal(values[row], expected, err_msg=key)


def test_vectors_and_quaternions_are_arrays_in_their_order(tmp_path):
    with open_bag(record(tmp_path / "bag", flight_messages(FLIGHT))) as bag:
        columns = read_columns(bag, [STATE, TORQUE, WALL_TIMING])
    states = columns[STATE]
    np.testing.assert_array_equal(states.fields["attitude"][:-1], FLIGHT.attitude.reshape(-1, 9))
    np.testing.assert_array_equal(states.fields["angular_momentum"][:-1], FLIGHT.momentum)
    quaternion = CODEC.quaternion(FLIGHT.attitude[3])
    expected = [quaternion.x, quaternion.y, quaternion.z, quaternion.w]
    np.testing.assert_array_equal(states.fields["orientation"][3], expected)
    np.testing.assert_array_equal(states.stamps[:3], [0.0, 0.4, 0.8])
    assert columns[WALL_TIMING].steps.size == 0
    assert columns[WALL_TIMING].missing(0, 1) == (0, 1)


def test_big_endian_messages_are_read(tmp_path):
    name = "spacecraft_gnc_msgs/msg/TorqueCommand"
    message = CODEC.store.deserialize_cdr(CODEC.torque(5, [1.0, -2.0, 3.0], 3), name)
    data = bytes(CODEC.store.serialize_cdr(message, name, little_endian=False))
    state = ("attitude_state", 0, CODEC.state(0, np.eye(3), np.zeros(3)))
    with open_bag(record(tmp_path / "bag", [state, ("torque_command", 5, data)])) as bag:
        columns = read_columns(bag, [TORQUE])[TORQUE]
    assert columns.steps.tolist() == [5]
    assert columns.fields["torque"].tolist() == [[1.0, -2.0, 3.0]]
    assert columns.fields["source"].tolist() == [3]


def test_blocks_come_in_the_order_of_recording(tmp_path):
    flight = random_flight(4100)
    names = [STATE, TORQUE]
    with open_bag(record(tmp_path / "bag", flight_messages(flight))) as bag:
        seen = []
        blocks = list(
            iter_columns(bag, names, progress=lambda done, total: seen.append((done, total)))
        )
        whole = read_columns(bag, names)
    sizes = [(name, block.steps[0], block.steps.size) for name, block in blocks]
    assert sizes == [
        (STATE, 0, 4096),
        (TORQUE, 0, 4096),
        (STATE, 4096, 5),
        (TORQUE, 4096, 4),
    ]
    np.testing.assert_array_equal(whole[TORQUE].fields["torque"], flight.torque)
    assert sorted(seen) == seen
    assert 0 < seen[-1][0] <= seen[-1][1]


def test_blocks_of_long_messages_hold_fewer_of_them(tmp_path, monkeypatch):
    monkeypatch.setattr("spacecraft_gnc.recording.columns._BLOCK_BYTES", 1000)
    messages = flight_messages(FLIGHT)
    with open_bag(record(tmp_path / "bag", messages)) as bag:
        sizes = [block.steps.size for _, block in iter_columns(bag, [STATE])]
    assert sizes == [6, 6, 1]  # of 188 bytes each


def test_fields_can_be_left_out(tmp_path):
    with open_bag(record(tmp_path / "bag", flight_messages(FLIGHT))) as bag:
        columns = read_columns(bag, [SOLVER_STATUS], leave_out=["predicted_attitudes"])
    assert "predicted_attitudes" not in columns[SOLVER_STATUS].fields
    assert "predicted_torques" in columns[SOLVER_STATUS].fields


@pytest.mark.parametrize(
    "data", [b"", b"\0\1\0\0", b"\0\1\0\0" + bytes(40), b"\0\1\0\0" + bytes(400)]
)
def test_a_message_that_does_not_follow_its_definition(tmp_path, data):
    with BagWriter(tmp_path / "bag") as writer:
        announce(writer)
        writer.write("/attitude_state", 0, 0, data)
    with (
        open_bag(tmp_path / "bag") as bag,
        pytest.raises(RecordingError, match=r"/attitude_state: received a message of \d+ bytes"),
    ):
        read_columns(bag, [STATE])


def test_a_topic_of_a_vehicle_that_is_not_installed_is_read_by_its_definition(tmp_path):
    other = Signal(name="solver_status", type=SOLVER_STATUS.type, fields={})
    with open_bag(record(tmp_path / "bag", flight_messages(FLIGHT))) as bag:
        known = read_columns(bag, [SOLVER_STATUS])[SOLVER_STATUS]
        columns = read_columns(bag, [other])[other]
    assert columns.fields.keys() == known.fields.keys()
    np.testing.assert_array_equal(columns.fields["residual"], known.fields["residual"])


def test_a_signal_of_the_graph_lies_above_its_agents(tmp_path, monkeypatch):
    with open_bag(record(tmp_path / "bag", flight_messages(FLIGHT), namespace="/sc1")) as bag:
        names = flight_topics(bag, [STATE, TORQUE], "sc1")
        assert names == {"/sc1/attitude_state": STATE, "/sc1/torque_command": TORQUE}
        bag.topics["/wall_timing"] = WALL_TIMING.type
        monkeypatch.setattr(steps, "_check_type", lambda *_: None)
        assert flight_topics(bag, [STATE, WALL_TIMING], "sc1")["/wall_timing"] is WALL_TIMING
        assert flight_topics(bag, [WALL_TIMING], "sc1") == {"/wall_timing": WALL_TIMING}
