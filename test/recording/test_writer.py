"""A bag as others see it: rosbags, mcap-ros2-support and a YAML parser."""

from __future__ import annotations

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from recording.bags import CODEC, announce, flight_messages, random_flight, record
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosDurability, QosReliability

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording import writer as writer_module
from spacecraft_gnc.recording.qos import qos_yaml
from spacecraft_gnc.recording.stamps import step_of
from spacecraft_gnc.recording.writer import BagWriter
from spacecraft_gnc.signals.qos import QosProfile

STRING = "std_msgs/msg/String"
FLIGHT = random_flight(12)


def as_list(reader):
    return [(connection.topic, bytes(data)) for connection, _, data in reader.messages()]


@pytest.mark.parametrize("compression", ["zstd", "lz4", "none"])
@pytest.mark.parametrize("single_file", [False, True], ids=["folder", "file"])
def test_rosbags_reads_every_byte_back(tmp_path, compression, single_file):
    items = flight_messages(FLIGHT)
    bag = record(tmp_path / "bag", items, compression=compression)
    source = bag / "bag_0.mcap" if single_file else bag
    with AnyReader([source]) as reader:
        assert as_list(reader) == [(f"/{topic}", data) for topic, _, data in items]
        connection, _, state = next(reader.messages(reader.topics["/attitude_state"].connections))
        decoded = reader.deserialize(state, connection.msgtype)
    np.testing.assert_array_equal(decoded.attitude.reshape(3, 3), FLIGHT.attitude[0])


def test_mcap_ros2_support_decodes_every_message(tmp_path):
    items = flight_messages(FLIGHT)
    bag = record(tmp_path / "bag", items)
    with (bag / "bag_0.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        decoded = list(reader.iter_decoded_messages())
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
    assert [(m.channel.topic, m.decoded_message.step) for m in decoded] == [
        (f"/{topic}", step) for topic, step, _ in items
    ]
    torque = next(m for m in decoded if m.channel.topic == "/torque_command")
    assert torque.decoded_message.torque.x == FLIGHT.torque[0, 0]
    assert summary.statistics.message_count == len(items)
    assert {channel.message_encoding for channel in summary.channels.values()} == {"cdr"}
    assert {schema.encoding for schema in summary.schemas.values()} == {"ros2msg"}


def test_sequence_numbers_count_the_messages_of_a_topic(tmp_path):
    bag = record(tmp_path / "bag", flight_messages(FLIGHT))
    with (bag / "bag_0.mcap").open("rb") as stream:
        found = [m.sequence for _, c, m in make_reader(stream).iter_messages("/attitude_state")]
    assert found == list(range(FLIGHT.n_steps + 1))


def test_metadata_yaml_says_what_is_in_the_bag(tmp_path):
    bag = record(tmp_path / "bag", flight_messages(FLIGHT))
    information = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert information["version"] == 9
    assert information["storage_identifier"] == "mcap"
    assert information["relative_file_paths"] == ["bag_0.mcap"]
    assert information["starting_time"] == {"nanoseconds_since_epoch": 0}
    assert information["duration"] == {"nanoseconds": 4_800_000_000}
    with AnyReader([bag]) as reader:
        (entry,) = reader.readers
        assert entry.message_count == 6 * FLIGHT.n_steps + 2
        counts = {name: topic.msgcount for name, topic in entry.topics.items()}
        qos = entry.topics["/attitude_state"].connections[0].ext.offered_qos_profiles[0]
    assert counts["/attitude_state"] == FLIGHT.n_steps + 1
    assert counts["/torque_command"] == FLIGHT.n_steps
    assert (qos.depth, qos.reliability, qos.durability) == (
        1000,
        QosReliability.RELIABLE,
        QosDurability.VOLATILE,
    )


def test_the_file_alone_carries_the_bag_metadata(tmp_path):
    bag = record(tmp_path / "bag", flight_messages(FLIGHT))
    with (bag / "bag_0.mcap").open("rb") as stream:
        records = [item for item in make_reader(stream).iter_metadata() if item.name == "rosbag2"]
    inside = yaml.safe_load(records[-1].metadata["serialized_metadata"])
    outside = yaml.safe_load((bag / "metadata.yaml").read_text())
    assert inside == outside["rosbag2_bagfile_information"]


def test_attachments_and_metadata_come_back(tmp_path):
    with BagWriter(tmp_path / "bag") as bag:
        bag.attach("scenario.yaml", "application/yaml", b"plant: {}\n")
        bag.metadata("versions", {"spacecraft_gnc": "0.1.0"})
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as stream:
        reader = make_reader(stream)
        (attachment,) = reader.iter_attachments()
        stored = {item.name: item.metadata for item in reader.iter_metadata()}
    assert (attachment.name, attachment.data) == ("scenario.yaml", b"plant: {}\n")
    assert stored["versions"] == {"spacecraft_gnc": "0.1.0"}


def test_a_bag_without_messages_is_a_bag(tmp_path):
    with BagWriter(tmp_path / "bag") as bag:
        announce(bag)
    with AnyReader([tmp_path / "bag"]) as reader:
        assert reader.message_count == 0
        assert "/attitude_state" in reader.topics


def test_lost_and_repeated_steps_are_counted(tmp_path):
    torque = np.zeros(3)
    with BagWriter(tmp_path / "bag") as bag:
        announce(bag)
        for step in (2, 3, 3, 7):
            bag.write("/torque_command", step, step, CODEC.torque(step, torque))
        assert bag.counts["/torque_command"] == (4, 5, 1, 5)  # 0, 1, 4, 5, 6 never came
        assert bag.counts["/attitude_state"] == (0, 0, 0, 0)
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as stream:
        stored = {item.name: item.metadata for item in make_reader(stream).iter_metadata()}
    assert stored["losses"]["/torque_command"] == "5"


def test_messages_without_a_step_are_not_searched_for_one(tmp_path):
    with BagWriter(tmp_path / "bag") as bag:
        bag.add_topic("/ready", STRING, CODEC.texts[STRING])
        bag.write("/ready", 0, 0, b"\0\1\0\0" + bytes(60))
        assert bag.counts["/ready"] == (1, 0, 0, 0)


@given(step=st.integers(0, 2**64 - 1), frame=st.text(max_size=20))
def test_the_step_is_found_behind_any_frame_name(step, frame):
    header = CODEC.header(0, frame.replace("\0", ""))
    data = CODEC.dump(
        "TorqueCommand", header=header, step=step, torque=CODEC.vector(np.zeros(3)), source=0
    )
    assert step_of(data) == step


@given(data=st.binary(max_size=40))
def test_garbage_has_a_step_or_none_but_never_raises(data):
    assert step_of(data) is None or len(data) >= 24


def test_two_topics_may_share_a_type(tmp_path):
    name = "spacecraft_gnc_msgs/msg/AttitudeReference"
    with BagWriter(tmp_path / "bag") as bag:
        announce(bag)
        bag.add_topic("/target_attitude", name, CODEC.texts[name])
        bag.write("/target_attitude", 0, 0, CODEC.reference(0, np.eye(3)))
    with AnyReader([tmp_path / "bag"]) as reader:
        assert reader.topics["/target_attitude"].msgtype == name


def test_several_profiles_survive(tmp_path):
    profiles = qos_yaml(QosProfile(), QosProfile(durability="transient_local", deadline_ns=10**9))
    with BagWriter(tmp_path / "bag") as bag:
        bag.add_topic("/ready", STRING, CODEC.texts[STRING], qos_yaml=profiles)
        bag.write("/ready", 0, 0, b"\0\1\0\0\1\0\0\0\0")
    with AnyReader([tmp_path / "bag"]) as reader:
        first, second = reader.connections[0].ext.offered_qos_profiles
        assert len(as_list(reader)) == 1
    assert (first.deadline.sec, second.deadline.sec) == (9_223_372_036, 1)
    assert second.durability == QosDurability.TRANSIENT_LOCAL
    assert qos_yaml() == ""


def test_chunks_close_by_size(tmp_path):
    payload = b"\0\1\0\0" + bytes(1000)
    with BagWriter(tmp_path / "bag", chunk_size=10_000) as bag:
        bag.add_topic("/ready", STRING, CODEC.texts[STRING])
        for k in range(100):
            bag.write("/ready", k, k, payload)
    with (tmp_path / "bag" / "bag_0.mcap").open("rb") as stream:
        statistics = make_reader(stream).get_summary().statistics
    assert (statistics.message_count, statistics.chunk_count) == (100, 10)


def test_a_chunk_closes_when_it_is_old(tmp_path, monkeypatch):
    now = 100.0
    monkeypatch.setattr(writer_module.time, "monotonic", lambda: now)
    with BagWriter(tmp_path / "bag") as bag:
        bag.add_topic("/ready", STRING, CODEC.texts[STRING])
        bag.write("/ready", 0, 0, b"\0\1\0\0")
        before = bag.path.stat().st_size
        now += writer_module.FLUSH_PERIOD
        bag.write("/ready", 1, 1, b"\0\1\0\0")
        assert bag.path.stat().st_size > before


def test_writing_wrongly_names_what_is_wrong(tmp_path):
    bag = BagWriter(tmp_path / "bag")
    bag.add_topic("/ready", STRING, CODEC.texts[STRING])
    with pytest.raises(RecordingError, match=r"/other: not announced to .*; call add_topic first"):
        bag.write("/other", 0, 0, b"")
    with pytest.raises(RecordingError, match=r"received log time -1 ns .*; required not negative"):
        bag.write("/ready", -1, 0, b"")
    bag.write("/ready", 0, 0, b"\0\1\0\0")
    bag.close()
    bag.close()
    with pytest.raises(RecordingError, match="the bag is closed"):
        bag.write("/ready", 1, 1, b"\0\1\0\0")
    with pytest.raises(RecordingError, match="the bag is closed"):
        bag.metadata("late", {})
