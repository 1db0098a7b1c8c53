"""Every way in which a bag can be wrong ends in one clear line; cut-off bags are saved."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import Writer
from recording.bags import CODEC, announce, flight_messages, random_flight, record
from rosbags.highlevel import AnyReader

from spacecraft_gnc.analysis.reader import load_run, read_flight
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording.recover import rewrite
from spacecraft_gnc.recording.writer import BagWriter

FLIGHT = random_flight(12)
STATE_TYPE = "spacecraft_gnc_msgs/msg/AttitudeState"


def refused(path, reason, **options):
    """Check that reading fails in one line that names the path and the reason."""
    with pytest.raises(RecordingError, match=reason) as caught:
        load_run(path, **options)
    message = str(caught.value)
    assert len(message.splitlines()) == 1
    assert str(path) in message
    assert "required" in message


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return a finished bag in many small chunks."""
    folder = tmp_path_factory.mktemp("bags") / "bag"
    return record(folder, flight_messages(FLIGHT), chunk_size=1500)


@pytest.fixture
def cut(tmp_path, whole):
    """Return a bag without the end of its file and without metadata.yaml."""
    folder = tmp_path / "cut"
    folder.mkdir()
    data = (whole / "bag_0.mcap").read_bytes()
    (folder / "bag_0.mcap").write_bytes(data[: len(data) // 4])
    return folder


def test_nothing_there(tmp_path):
    refused(tmp_path / "none", "no such file or folder")
    refused(tmp_path / "none.npz", "cannot be read as a flight")


def test_a_folder_without_a_bag(tmp_path):
    (tmp_path / "notes.txt").write_text("")
    refused(tmp_path, "received a folder without a bag")


def test_another_kind_of_file(tmp_path):
    path = tmp_path / "flight.csv"
    path.write_text("1,2,3")
    refused(path, "received another kind of file")
    fake = tmp_path / "flight.mcap"
    fake.write_text("1,2,3 and so on")
    refused(fake, "received a file that is not MCAP")


def test_an_empty_file(tmp_path):
    (tmp_path / "flight.mcap").touch()
    refused(tmp_path / "flight.mcap", "received an empty file")
    refused(tmp_path, "received an empty file")


def test_a_file_that_cannot_be_read(tmp_path):
    (tmp_path / "flight.mcap").mkdir()
    refused(tmp_path, "cannot be read")


def test_a_bag_that_was_cut_off(cut):
    refused(cut, "received an unfinished bag .* save what is whole: gnc recover")
    refused(cut / "bag_0.mcap", "received an unfinished bag")


def test_a_bag_without_metadata_is_unfinished_even_if_its_file_is_whole(tmp_path, whole):
    (tmp_path / "bag").mkdir()
    shutil.copy(whole / "bag_0.mcap", tmp_path / "bag")
    refused(tmp_path / "bag", "received an unfinished bag")
    flight = read_flight(tmp_path / "bag", allow_unfinished=True)
    np.testing.assert_array_equal(flight.trajectory.torque, FLIGHT.torque)


def test_what_was_saved_of_a_cut_off_bag_is_read(cut):
    trajectory, info = read_flight(cut, allow_unfinished=True)
    n = trajectory.n_steps
    assert 3 < n < FLIGHT.n_steps
    np.testing.assert_array_equal(trajectory.torque, FLIGHT.torque[:n])
    np.testing.assert_array_equal(trajectory.final_attitude, FLIGHT.attitude[n])
    assert info.unfinished
    assert info.warnings()[0].endswith("the bag was cut off; what was saved is shown")


def test_a_bag_cut_off_before_its_first_message(tmp_path):
    bag = BagWriter(tmp_path / "bag")
    announce(bag)
    bag.flush()
    refused(tmp_path / "bag", "without a whole message", allow_unfinished=True)
    bag.abort()
    head = tmp_path / "head.mcap"
    head.write_bytes(b"\x89MCAP0\r\n" + b"\x01\xff")
    refused(head, "without a whole message", allow_unfinished=True)


def test_a_bag_of_another_package(tmp_path):
    with BagWriter(tmp_path / "bag") as bag:
        bag.add_topic("/chatter", "std_msgs/msg/String", "string data")
        bag.write("/chatter", 0, 0, b"\0\1\0\0\1\0\0\0\0")
    refused(
        tmp_path / "bag", "no topic .*attitude_state or wheel_state; .* topics in the bag: /chatter"
    )


def test_a_bag_of_another_type(tmp_path):
    with BagWriter(tmp_path / "bag") as bag:
        bag.add_topic("/attitude_state", "std_msgs/msg/String", "string data")
        bag.write("/attitude_state", 0, 0, b"\0\1\0\0\1\0\0\0\0")
    refused(tmp_path / "bag", f"has type std_msgs/msg/String; required {STATE_TYPE}")


def test_a_bag_of_another_version_of_the_messages(tmp_path):
    with BagWriter(tmp_path / "bag") as bag:
        bag.add_topic("/attitude_state", STATE_TYPE, "uint64 count\n")
        bag.write("/attitude_state", 0, 0, b"\0\1\0\0" + bytes(8))
    refused(tmp_path / "bag", "with type hash RIHS01_5a90.*; required RIHS01_1e88")


def test_a_definition_that_does_not_fit_its_hash(tmp_path):
    with BagWriter(tmp_path / "bag") as bag:
        text = CODEC.texts[STATE_TYPE]
        bag.add_topic("/attitude_state", STATE_TYPE, text, type_hash="RIHS01_0")
        bag.write("/attitude_state", 0, 0, CODEC.state(0, np.eye(3), np.zeros(3)))
    refused(tmp_path / "bag", "hash mismatch")


def test_two_runs_in_one_bag(tmp_path):
    other = random_flight(12, seed=9)
    bag = record(tmp_path / "bag", flight_messages(FLIGHT) + flight_messages(other))
    refused(bag, "holds two different messages of step 0; required one run")


def test_a_bag_too_short_to_fly(tmp_path):
    states = [item for item in flight_messages(FLIGHT) if item[0] == "attitude_state"]
    refused(record(tmp_path / "bag", states), "received 13 states and 0 torques")
    refused(
        record(tmp_path / "one", flight_messages(FLIGHT)[:5]), "at least one whole control step"
    )


def test_a_file_that_is_not_of_ros_2(tmp_path):
    path = tmp_path / "json.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="")
        schema = writer.register_schema("foo", "jsonschema", b"{}")
        channel = writer.register_channel("/web/notes", "json", schema)
        writer.add_message(channel, 0, b"{}", 0)
        writer.finish()
    refused(path, "no topic .*attitude_state or wheel_state; .* topics in the bag: none")


def test_a_damaged_metadata_yaml(tmp_path, whole):
    shutil.copytree(whole, tmp_path / "bag")
    (tmp_path / "bag" / "metadata.yaml").write_text("rosbag2_bagfile_information: [")
    refused(tmp_path / "bag", r"metadata\.yaml that is no YAML; .*; name the \.mcap file")


@settings(max_examples=60)
@given(data=st.data())
def test_a_damaged_byte_is_harmless_or_one_line(whole, tmp_path_factory, data):
    original = (whole / "bag_0.mcap").read_bytes()
    position = data.draw(st.integers(0, len(original) - 1))
    damaged = bytearray(original)
    damaged[position] ^= data.draw(st.integers(1, 255))
    path = tmp_path_factory.mktemp("damaged") / "bag.mcap"
    path.write_bytes(damaged)
    for allow in (False, True):
        try:
            read_flight(path, allow_unfinished=allow)
        except RecordingError as error:
            assert len(str(error).splitlines()) == 1  # noqa: PT017  # either way is right


@settings(max_examples=60)
@given(share=st.floats(0.0, 1.0))
def test_every_cut_leaves_a_readable_beginning(whole, tmp_path_factory, share):
    folder = tmp_path_factory.mktemp("cut")
    data = (whole / "bag_0.mcap").read_bytes()
    (folder / "cut.mcap").write_bytes(data[: 8 + int(share * (len(data) - 8))])
    saved = rewrite(folder / "cut.mcap", folder / "saved.mcap")
    expected = [item[2] for item in flight_messages(FLIGHT)]
    with (folder / "saved.mcap").open("rb") as stream:
        found = [m.data for *_, m in make_reader(stream).iter_messages(log_time_order=False)]
    assert found == expected[:saved]
    if share == 1.0:
        assert saved == len(expected)


def test_a_recovered_file_is_a_bag_for_others(tmp_path, cut):
    saved = rewrite(cut / "bag_0.mcap", tmp_path / "saved.mcap")
    with AnyReader([tmp_path / "saved.mcap"]) as reader:
        assert reader.message_count == saved > 10
        for connection, _, data in reader.messages():
            assert reader.deserialize(data, connection.msgtype).header.frame_id
