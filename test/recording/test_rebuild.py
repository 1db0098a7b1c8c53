"""A bag that was cut off becomes a whole one: nothing that was saved is changed or left out."""

from __future__ import annotations

import errno
import os

import numpy as np
import pytest
import yaml
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from recording.bags import CODEC, announce, flight_messages, random_flight
from rosbags.highlevel import AnyReader

from spacecraft_gnc.analysis.reader import read_flight
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording import rebuild as module
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.rebuild import rebuild
from spacecraft_gnc.recording.writer import BagWriter

FLIGHT = random_flight(40)
ITEMS = [(f"/{topic}", step, data) for topic, step, data in flight_messages(FLIGHT)]
CHUNK = 2000  # [bytes]
IN_TWO_CHUNKS = 50  # messages, at least
SCENARIO = b"plant: {}\n"


def cut_bag(folder, items=ITEMS, keep=1.0, **options):
    """Write a bag as a recorder does that is killed when a share of its messages was written."""
    bag = BagWriter(folder, chunk_size=CHUNK, **options)
    bag.attach("scenario.yaml", "application/yaml", SCENARIO)
    bag.metadata("run", {"host": "here"})
    announce(bag)
    begun = 0
    for topic, step, data in items:
        bag.write(topic, 1000 * step, 1000 * step, data)
        if not begun:
            bag.flush()  # the definitions are in the first chunk
            begun = bag.path.stat().st_size
    bag.abort()
    os.truncate(bag.path, begun + int(keep * (bag.path.stat().st_size - begun)))
    return folder


def messages(path):
    with AnyReader([path]) as reader:
        return [(connection.topic, bytes(data)) for connection, _, data in reader.messages()]


@pytest.mark.parametrize("compression", ["none", "zstd"])
@pytest.mark.parametrize("keep", [0.3, 0.77, 1.0])
def test_every_whole_chunk_is_saved(tmp_path, compression, keep):
    source = cut_bag(tmp_path / "cut", keep=keep, compression=compression)
    rebuilt = rebuild(source)
    assert rebuilt.folder == tmp_path / "cut-recovered"
    saved = messages(rebuilt.folder)
    assert saved == [(topic, data) for topic, _, data in ITEMS[: len(saved)]]
    assert len(saved) == rebuilt.messages > keep * len(ITEMS) - IN_TWO_CHUNKS
    assert (rebuilt.cut_bytes > 0) == (keep < 1.0)
    assert rebuilt.topics == {
        name: sum(topic == name for topic, _ in saved) for name in rebuilt.topics
    }


def test_the_new_bag_is_a_rosbag2_bag(tmp_path):
    rebuilt = rebuild(cut_bag(tmp_path / "cut", keep=0.5), tmp_path / "new")
    told = yaml.safe_load((tmp_path / "new" / "metadata.yaml").read_text())
    information = told["rosbag2_bagfile_information"]
    assert information["relative_file_paths"] == ["new_0.mcap"]
    assert information["message_count"] == rebuilt.messages
    assert information["custom_data"]["recovered"] == str(tmp_path / "cut")
    state = information["topics_with_message_count"][0]["topic_metadata"]
    assert state["offered_qos_profiles"][0]["depth"] == 1000
    assert state["type_description_hash"].startswith("RIHS01_")
    with (tmp_path / "new" / "new_0.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        assert len(list(reader.iter_decoded_messages())) == rebuilt.messages
        assert reader.get_summary().statistics.message_count == rebuilt.messages


def test_attachments_and_records_are_kept_and_the_bag_is_marked(tmp_path):
    rebuilt = rebuild(cut_bag(tmp_path / "cut", keep=0.6))
    with open_bag(rebuilt.folder) as bag:
        assert not bag.unfinished
        assert bag.attachments() == {"scenario.yaml": SCENARIO}
        records = bag.metadata()
    assert records["run"] == {"host": "here"}
    assert records["recovered"]["source"] == str(tmp_path / "cut")
    assert records["recovered"]["messages"] == str(rebuilt.messages)
    assert records["recovered"]["cut_bytes"] == str(rebuilt.cut_bytes)


def test_the_last_whole_step_and_the_gaps_are_told(tmp_path):
    items = [item for item in ITEMS if item[:2] != ("/torque_command", 3) and item[1] < 20]
    items += [item for item in ITEMS if item[1] == 20 and item[0] != "/solver_status"]
    rebuilt = rebuild(cut_bag(tmp_path / "cut", items))
    assert rebuilt.last_whole_step == 19
    assert rebuilt.missing_steps == {"/torque_command": 1}
    assert rebuilt.last_stamp == pytest.approx(20e-6)
    with open_bag(rebuilt.folder) as bag:
        assert bag.metadata()["losses"]["/torque_command"] == "1"
    flown = read_flight(rebuilt.folder).trajectory
    np.testing.assert_array_equal(flown.attitude, FLIGHT.attitude[: len(flown.time)])


def test_a_damaged_chunk_is_left_out_and_told(tmp_path):
    source = cut_bag(tmp_path / "cut", compression="none")
    file = source / "cut_0.mcap"
    data = bytearray(file.read_bytes())
    spoilt = CODEC.state(20, FLIGHT.attitude[20], FLIGHT.momentum[20])
    data[data.find(spoilt) + 60] ^= 1
    file.write_bytes(bytes(data))
    rebuilt = rebuild(source)
    assert rebuilt.damaged_chunks == 1
    assert 0 < len(ITEMS) - rebuilt.messages < 30
    assert set(messages(rebuilt.folder)) < {(topic, data) for topic, _, data in ITEMS}


def test_a_file_without_its_folder(tmp_path):
    source = cut_bag(tmp_path / "cut", keep=0.5)
    rebuilt = rebuild(source / "cut_0.mcap", tmp_path / "new")
    assert messages(rebuilt.folder) == messages(rebuild(source).folder)


def test_several_files_become_one(tmp_path):
    first = cut_bag(tmp_path / "cut", ITEMS[:100])
    second = cut_bag(tmp_path / "cut_1", ITEMS[100:])
    (second / "cut_1_0.mcap").rename(first / "cut_1.mcap")
    rebuilt = rebuild(first)
    assert messages(rebuilt.folder) == [(topic, data) for topic, _, data in ITEMS]
    with AnyReader([rebuilt.folder]) as reader:
        names = [connection.topic for connection in reader.connections]
    assert len(names) == len(set(names))


def test_progress_counts_the_bytes(tmp_path):
    source = cut_bag(tmp_path / "cut")
    told = []
    rebuild(source, progress=lambda done, total: told.append((done, total)))
    size = (source / "cut_0.mcap").stat().st_size
    assert told
    assert all(done <= total == size for done, total in told)


def refused(reason, source, folder=None):
    with pytest.raises(RecordingError, match=reason) as caught:
        rebuild(source, folder)
    assert len(str(caught.value).splitlines()) == 1


def test_what_cannot_be_recovered(tmp_path):
    whole = rebuild(cut_bag(tmp_path / "cut")).folder
    refused("received a whole bag; required one that was cut off", whole)
    refused("no such file or folder", tmp_path / "nothing")
    (tmp_path / "empty").mkdir()
    refused("received a folder without a bag", tmp_path / "empty")
    (tmp_path / "text.txt").write_text("text")
    refused("received another kind of file", tmp_path / "text.txt")
    (tmp_path / "text.mcap").write_text("no bag, only a name that looks like one")
    refused("not MCAP", tmp_path / "text.mcap")
    refused("exists and is not an empty folder", tmp_path / "cut", whole)
    assert whole.exists()


def test_no_whole_message_leaves_nothing(tmp_path):
    source = cut_bag(tmp_path / "cut", keep=-0.02)  # in the first chunk
    refused("without a whole message", source, tmp_path / "new")
    assert not (tmp_path / "new").exists()


def test_a_full_disk_leaves_nothing(tmp_path, monkeypatch):
    def fail(folder, summary):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(module, "write_metadata", fail)
    refused("No space left on device", cut_bag(tmp_path / "cut"), tmp_path / "new")
    assert not (tmp_path / "new").exists()
