"""Bags as other producers write them: the files are the truth, and what is left out is told."""

from __future__ import annotations

import shutil
import sqlite3
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import zstandard
from mcap.writer import Writer
from recording.bags import announce, flight_messages, random_flight, record
from recording.foreign_bags import (
    FOREIGN,
    SHAPES,
    Contents,
    edit,
    folder_of,
    merged,
    with_another_channel,
    write,
)

from spacecraft_gnc.analysis.reader import load_run, read_flight
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.playback import Playback
from spacecraft_gnc.recording.rebuild import rebuild
from spacecraft_gnc.recording.writer import BagWriter
from spacecraft_gnc.vehicles.known_signals import every_signal

FLIGHT = random_flight(24)
ITEMS = flight_messages(FLIGHT)
END_NS = 24 * 400_000_000
SCENARIO = (
    "plant:\n  ros__parameters:\n    inertia: [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]\n"
)


@pytest.fixture(scope="module")
def ours(tmp_path_factory):
    return record(tmp_path_factory.mktemp("ours") / "bag", ITEMS, scenario=SCENARIO)


def same_flight(path):
    """Check that a bag is read as the flight, and return what is told of it."""
    trajectory, info = read_flight(path)
    np.testing.assert_array_equal(trajectory.attitude, FLIGHT.attitude)
    np.testing.assert_array_equal(trajectory.torque, FLIGHT.torque)
    assert info.scenario_text == SCENARIO
    return info.warnings()


def played(path):
    """Return the span and the messages that a player would publish, without ticks."""
    with open_bag(path) as bag:
        playback = Playback(bag, signals=every_signal())
        moments = list(playback.moments(playback.start_ns))
        assert playback.held == {
            f"/{name}": sum(1 for topic, *_ in ITEMS if topic == name)
            for name in {topic for topic, *_ in ITEMS}
        }
        assert [moment.time_ns for moment in moments] == sorted({m.time_ns for m in moments})
        messages = [item for m in moments for item in m.messages if item[0] != "/clock"]
        return (playback.start_ns, playback.end_ns), sorted(messages), playback.topics


@pytest.mark.parametrize("shape", SHAPES)
def test_the_same_flight_in_another_shape(shape, ours, tmp_path):
    path = SHAPES[shape](ours, tmp_path / "other")
    assert same_flight(path) == same_flight(ours)
    span, messages, topics = played(path)
    assert span == (0, END_NS)
    assert messages == sorted((f"/{topic}", data) for topic, _, data in ITEMS)
    # of the QoS, too, it is the file that counts
    assert topics["/attitude_state"] == played(ours)[2]["/attitude_state"]
    with open_bag(path) as bag:
        bag.verify()


@pytest.mark.parametrize("from_step", [0, 1, 13, 24])
def test_playing_from_within_a_bag_of_several_files(from_step, ours, tmp_path):
    from_ns = from_step * 400_000_000
    expected = sorted((f"/{t}", data) for t, step, data in ITEMS if step >= from_step)
    for shape in ("in twelve files", "without chunks", "lz4"):
        path = SHAPES[shape](ours, tmp_path / shape.replace(" ", "_"))
        with open_bag(path) as bag:
            found = list(bag.timed(bag.topics, from_ns))
        assert [time for time, *_ in found] == sorted(time for time, *_ in found)
        assert sorted(item[1:] for item in found) == expected


@pytest.mark.parametrize("name", FOREIGN)
def test_a_foreign_topic_is_left_out_and_named(name, ours, tmp_path):
    topic, reason, add = FOREIGN[name]
    path = write(tmp_path / "mixed.mcap", Contents.of(ours), add)
    assert same_flight(path) == [f"{path}: {topic} is left out: {reason}"]
    with open_bag(path) as bag:
        playback = Playback(bag)
        assert playback.left_out == {topic: reason}
        assert playback.held[topic] == 1
        assert topic not in playback.topics
        with pytest.raises(RecordingError, match="which cannot be played"):
            Playback(bag, [topic])


@pytest.mark.parametrize(
    ("name", "encoding", "text"),
    [
        ("std_msgs/msg/Empty", "ros2msg", b""),
        (
            "demo_pkg/msg/Thing",
            "ros2idl",
            b"=" * 80
            + b"\nIDL: demo_pkg/msg/Thing\n"
            + b"module demo_pkg { module msg { struct Thing { double x; }; }; };\n",
        ),
    ],
)
def test_other_messages_of_ros_are_played(name, encoding, text, ours, tmp_path):
    add = with_another_channel(name, encoding, text, "/other")
    path = write(tmp_path / "mixed.mcap", Contents.of(ours), add)
    assert same_flight(path) == []
    with open_bag(path) as bag:
        playback = Playback(bag)
        assert playback.topics["/other"].type_name == name
        assert playback.topics["/other"].type_hash.startswith("RIHS01_")


def test_a_definition_that_cannot_be_read_harms_its_topic_alone(ours, tmp_path):
    add = with_another_channel("demo_pkg/msg/Thing", "ros2msg", b"float64[ x\n", "/thing")
    path = write(tmp_path / "mixed.mcap", Contents.of(ours), add)
    assert same_flight(path) == []
    with open_bag(path) as bag:
        playback = Playback(bag)
        assert list(playback.left_out) == ["/thing"]
        assert "cannot be read" in playback.left_out["/thing"]


def test_a_topic_of_two_types_is_told(ours, tmp_path):
    add = with_another_channel("std_msgs/msg/String", "ros2msg", b"string data", "/attitude_state")
    path = write(tmp_path / "mixed.mcap", Contents.of(ours), add)
    with pytest.raises(
        RecordingError, match=r"holds messages of \S+State and of std_msgs/msg/String"
    ):
        load_run(path)


def test_a_file_beside_the_bag_is_left_out_and_named(ours, tmp_path):
    bag = shutil.copytree(ours, tmp_path / "bag")
    shutil.copy(bag / "bag_0.mcap", bag / "bag_0_backup.mcap")
    told = f"{bag}: bag_0_backup.mcap is left out: metadata.yaml does not name it"
    assert same_flight(bag) == [told]
    assert played(bag)[1] == sorted((f"/{topic}", data) for topic, _, data in ITEMS)


def refused(path, *reasons):
    with pytest.raises(RecordingError) as caught:
        load_run(path)
    (line,) = str(caught.value).splitlines()
    for reason in (str(path), *reasons):
        assert reason in line


def test_a_file_that_was_renamed(ours, tmp_path):
    bag = shutil.copytree(ours, tmp_path / "bag")
    (bag / "bag_0.mcap").rename(bag / "flight.mcap")
    refused(bag, "received flight.mcap; required bag_0.mcap")
    assert same_flight(bag / "flight.mcap") == []


@pytest.mark.parametrize("closed", [True, False], ids=["closed", "cut off"])
def test_a_bag_in_sqlite_storage(closed, ours, tmp_path):
    bag = shutil.copytree(ours, tmp_path / "bag")
    (bag / "bag_0.mcap").unlink()
    sqlite3.connect(bag / "bag_0.db3").close()
    if closed:
        edit(bag, lambda about: about.update(storage_identifier="sqlite3"))
    else:
        (bag / "metadata.yaml").unlink()
    convert = f"rosbags-convert --src {bag} --dst {bag}-mcap --dst-storage mcap"
    refused(bag, "storage sqlite3", "required MCAP", convert)
    refused(bag / "bag_0.db3", "storage sqlite3", convert)


def test_the_remedy_for_sqlite_storage_is_one(ours, tmp_path):
    """Run the command that the refusal names; SQLite has no room for attachments."""
    bag = tmp_path / "old"
    program = Path(sys.executable).with_name("rosbags-convert")
    to_sqlite = ["--src", ours, "--dst", bag, "--dst-storage", "sqlite3"]
    subprocess.run([program, *to_sqlite], check=True, timeout=60)
    with pytest.raises(RecordingError) as caught:
        load_run(bag)
    _, _, command = str(caught.value).partition("convert it: rosbags-convert ")
    subprocess.run([program, *command.split()], check=True, timeout=60)
    trajectory, info = read_flight(f"{bag}-mcap")
    np.testing.assert_array_equal(trajectory.torque, FLIGHT.torque)
    assert not info.missing


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "has no rosbag2_bagfile_information"),
        ("[]", "has no rosbag2_bagfile_information"),
        ("a text", "has no rosbag2_bagfile_information"),
        ("a: 1", "has no rosbag2_bagfile_information"),
        ("\0", "is no YAML"),
        ("rosbag2_bagfile_information: {}", "names no file in relative_file_paths"),
        ("rosbag2_bagfile_information: {relative_file_paths: []}", "names no file in"),
        ("rosbag2_bagfile_information: {relative_file_paths: [1]}", "names no file in"),
    ],
)
def test_a_metadata_yaml_that_names_no_files(text, problem, ours, tmp_path):
    bag = shutil.copytree(ours, tmp_path / "bag")
    (bag / "metadata.yaml").write_text(text)
    refused(bag, f"metadata.yaml that {problem}", "(bag_0.mcap); name the .mcap file instead")
    assert load_run(bag / "bag_0.mcap").trajectory.n_steps == FLIGHT.n_steps


def test_a_file_that_is_named_twice_is_read_once(ours, tmp_path):
    bag = shutil.copytree(ours, tmp_path / "bag")
    edit(bag, lambda about: about.update(relative_file_paths=["bag_0.mcap", "bag_0.mcap"]))
    np.testing.assert_array_equal(load_run(bag).trajectory.torque, FLIGHT.torque)
    with open_bag(bag) as twice, open_bag(ours) as once:
        assert twice.counts == once.counts


def test_a_compressed_file_that_was_cut_off_is_named(ours, tmp_path):
    packed = zstandard.ZstdCompressor().compress((ours / "bag_0.mcap").read_bytes())
    cut = tmp_path / "bag_0.mcap.zstd"
    cut.write_bytes(packed[:20])
    refused(cut, f"{cut}: received 20 bytes that decompress to no MCAP file")
    misnamed = tmp_path / "misnamed.mcap"
    misnamed.write_bytes(packed)
    refused(misnamed, "compressed by zstd", "rename it to misnamed.mcap.zstd")


def test_files_of_one_bag_whose_recorder_was_killed(ours, tmp_path):
    bag = folder_of(ours, tmp_path / "split", 12)
    (bag / "metadata.yaml").unlink()
    trajectory, info = read_flight(bag, allow_unfinished=True)
    np.testing.assert_array_equal(trajectory.torque, FLIGHT.torque)
    assert info.unfinished
    rebuilt = rebuild(bag)
    assert rebuilt.messages == len(ITEMS)
    assert not rebuilt.missing_steps
    same_flight(rebuilt.folder)


@pytest.mark.parametrize("names", [("a_0", "b_0"), ("a_0", "a_1"), ("a", "b"), ("a_0", "a_2")])
def test_bags_of_several_flights_are_not_merged(names, tmp_path):
    files = [
        next(record(tmp_path / f"{i}", ITEMS, name=name.rpartition("_")[0]).glob("*.mcap"))
        for i, name in enumerate(names)
    ]
    files = [
        file.rename(file.with_name(f"{name}.mcap")) for file, name in zip(files, names, strict=True)
    ]
    folder = merged(files, tmp_path / "all")
    for read in (rebuild, lambda path: load_run(path, allow_unfinished=True)):
        with pytest.raises(RecordingError, match=r"2 \.mcap files without metadata") as caught:
            read(folder)
        assert ", ".join(f"{name}.mcap" for name in names) in str(caught.value)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["0", "1", "all"]


def test_a_message_before_its_channel_is_left_out_and_counted(tmp_path):
    """Cut off before the summary, which would tell of its topic."""
    path = tmp_path / "cut.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream, use_chunking=False)
        writer.start("ros2")
        writer.add_message(9, 0, b"\0\1\0\0", 0)
        schema = writer.register_schema("std_msgs/msg/String", "ros2msg", b"string data")
        known = writer.register_channel("/words", "cdr", schema)
        writer.add_message(known, 0, b"\0\1\0\0\2\0\0\0a\0", 0)
    rebuilt = rebuild(path)
    assert (rebuilt.topics, rebuilt.orphans) == ({"/words": 1}, 1)


@pytest.mark.parametrize("length", [2**31, 2**32 - 1, 500])
def test_a_length_beyond_the_message(length, tmp_path):
    """Of the frame's name: the first length in a message."""
    with BagWriter(tmp_path / "bag") as bag:
        announce(bag)
        for topic, step, data in ITEMS:
            wrong = data[:12] + length.to_bytes(4, "little") + data[16:]
            bag.write(f"/{topic}", step, step, wrong if topic == "torque_command" else data)
    refused(tmp_path / "bag", "/torque_command", f"string or sequence of {length} elements")


def test_a_message_is_decoded_by_the_definition_in_the_bag(ours):
    with open_bag(ours) as bag:
        topic, data = next(iter(bag.messages(["/attitude_state"])))
        state = bag.decode(topic, data)
    np.testing.assert_array_equal(state.attitude, FLIGHT.attitude[0].ravel())
