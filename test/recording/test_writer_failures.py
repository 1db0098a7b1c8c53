"""Full disks, bad folders and killed processes: what is left must not look whole."""

from __future__ import annotations

import errno
import os
import shutil
import signal
import subprocess
import sys
from functools import partial
from io import FileIO
from pathlib import Path

import numpy as np
import pytest
from recording.bags import CODEC

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording import metadata as _metadata
from spacecraft_gnc.recording import writer
from spacecraft_gnc.recording._file import RecordFile
from spacecraft_gnc.recording.recover import WholeRecords
from spacecraft_gnc.recording.writer import BagWriter

STRING = "std_msgs/msg/String"
SOURCE = Path(__file__).parents[2]


class FullDisk(FileIO):
    """A file on a disk with room for so many bytes; the last write is cut short, as on Linux."""

    def __init__(self, path, room):
        super().__init__(path, "xb")
        self.room = room

    def write(self, data):
        taken = min(len(data), self.room)
        if not taken and len(data):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        self.room -= taken
        return super().write(bytes(data)[:taken])


@pytest.fixture
def disk(monkeypatch):
    """Return a function that gives the next bags a disk with so much room."""

    def limit(room):
        opener = partial(FullDisk, room=room)
        monkeypatch.setattr(writer, "RecordFile", partial(RecordFile, opener=opener))

    return limit


def messages_in(path):
    with path.open("rb") as stream:
        return [item.data for item in WholeRecords(stream) if type(item).__name__ == "Message"]


def record_until_full(folder):
    """Write random messages until the disk is full; return those written."""
    rng = np.random.default_rng(1)
    written = [rng.bytes(100) for _ in range(1000)]
    bag = BagWriter(folder, chunk_size=2000)
    bag.add_topic("/ready", STRING, CODEC.texts[STRING])

    def write_all():
        for k, data in enumerate(written):
            bag.write("/ready", k, k, data)

    with pytest.raises(RecordingError) as caught:
        write_all()
    return bag, written, str(caught.value)


def test_a_full_disk_ends_in_one_line_and_an_unfinished_bag(tmp_path, disk):
    disk(20_000)
    bag, written, message = record_until_full(tmp_path / "bag")
    assert message.splitlines() == [message]
    assert str(bag.path) in message
    assert "No space left on device" in message
    assert "required a writable folder with free space" in message
    assert sorted(path.name for path in (tmp_path / "bag").iterdir()) == ["bag_0.mcap"]
    saved = messages_in(bag.path)
    assert len(saved) > 100
    assert saved == written[: len(saved)]
    assert f"{len(saved)} messages are saved" in message
    bag.close()  # a writer that failed stays closed, quietly
    assert not (tmp_path / "bag" / "metadata.yaml").exists()
    with pytest.raises(RecordingError, match="the bag is closed"):
        bag.write("/ready", 0, 0, b"")


def test_the_file_ends_with_a_whole_record_after_a_full_disk(tmp_path, disk):
    disk(20_000)
    bag, _, _ = record_until_full(tmp_path / "bag")
    with bag.path.open("rb") as stream:
        for _ in WholeRecords(stream):
            pass
        assert stream.tell() == bag.path.stat().st_size


@pytest.mark.parametrize("room", [0, 20, 100])
def test_a_disk_full_before_the_first_message_leaves_nothing(tmp_path, disk, room):
    def record():
        with BagWriter(tmp_path / "bag") as bag:
            bag.add_topic("/ready", STRING, CODEC.texts[STRING])
            bag.write("/ready", 0, 0, b"\0\1\0\0 lost")

    disk(room)
    with pytest.raises(RecordingError, match="No space left on device"):
        record()
    assert not (tmp_path / "bag").exists()


def test_a_disk_full_at_the_end_leaves_no_metadata(tmp_path, monkeypatch):
    def fail(folder, summary):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(writer, "write_metadata", fail)
    bag = BagWriter(tmp_path / "bag")
    bag.add_topic("/ready", STRING, CODEC.texts[STRING])
    bag.write("/ready", 0, 0, b"\0\1\0\0")
    with pytest.raises(RecordingError, match="No space left on device"):
        bag.close()
    assert [path.name for path in (tmp_path / "bag").iterdir()] == ["bag_0.mcap"]


def test_metadata_yaml_is_there_whole_or_not_at_all(tmp_path, monkeypatch):
    def fail(descriptor):
        raise OSError(errno.EIO, "input/output error")

    monkeypatch.setattr(_metadata.os, "fsync", fail)
    with pytest.raises(OSError, match="input/output error"):
        _metadata.write_metadata(tmp_path, _metadata.BagSummary("x.mcap", 0, 0, [], "jazzy"))
    assert not list(tmp_path.iterdir())


def test_a_folder_with_something_in_it_is_refused(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(RecordingError, match="exists and is not an empty folder; required a new"):
        BagWriter(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


def test_a_folder_that_cannot_be_made_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordingError, match=r"file/bag: cannot be created \(Not a directory\)"):
        BagWriter(tmp_path / "file" / "bag")
    with pytest.raises(RecordingError, match="exists and is not an empty folder"):
        BagWriter(tmp_path / "file")


def test_an_empty_folder_stays_when_nothing_was_recorded(tmp_path, disk):
    disk(0)
    with pytest.raises(RecordingError):
        BagWriter(tmp_path)
    assert tmp_path.exists()
    assert not list(tmp_path.iterdir())


def test_an_exception_leaves_the_bag_unfinished_but_saved(tmp_path):
    def fail():
        with BagWriter(tmp_path / "bag") as bag:
            bag.add_topic("/ready", STRING, CODEC.texts[STRING])
            bag.write("/ready", 0, 0, b"\0\1\0\0 saved")
            raise KeyError("elsewhere")

    with pytest.raises(KeyError):
        fail()
    assert messages_in(tmp_path / "bag" / "bag_0.mcap") == [b"\0\1\0\0 saved"]
    assert not (tmp_path / "bag" / "metadata.yaml").exists()


def test_an_exception_before_the_first_message_leaves_nothing(tmp_path):
    def fail():
        with BagWriter(tmp_path / "bag"):
            raise KeyError("elsewhere")

    with pytest.raises(KeyError):
        fail()
    assert not (tmp_path / "bag").exists()


def test_a_copy_taken_while_writing_holds_everything_up_to_the_last_flush(tmp_path):
    bag = BagWriter(tmp_path / "bag")
    bag.add_topic("/ready", STRING, CODEC.texts[STRING])
    flushed = [b"\0\1\0\0 %d" % k for k in range(50)]
    for k, data in enumerate(flushed):
        bag.write("/ready", k, k, data)
    bag.flush()
    bag.write("/ready", 50, 50, b"\0\1\0\0 too late")
    shutil.copy(bag.path, tmp_path / "copy.mcap")
    bag.close()
    assert messages_in(tmp_path / "copy.mcap") == flushed


CHILD = """
import os, signal
from spacecraft_gnc.recording.writer import BagWriter
bag = BagWriter("bag")
bag.add_topic("/ready", "std_msgs/msg/String", "string data")
for k in range(1000):
    bag.write("/ready", k, k, b"%d" % k)
bag.flush()
for k in range(1000, 1010):
    bag.write("/ready", k, k, b"%d" % k)
os.kill(os.getpid(), signal.SIGKILL)
"""

FULL_CHILD = """
import resource
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording.writer import BagWriter
resource.setrlimit(resource.RLIMIT_FSIZE, (30_000, 30_000))
bag = BagWriter("bag", compression="none", chunk_size=1000)
bag.add_topic("/ready", "std_msgs/msg/String", "string data")
try:
    for k in range(1000):
        bag.write("/ready", k, k, bytes(100))
except RecordingError as error:
    print(error)
"""


def run_child(code, folder):
    environment = {**os.environ, "PYTHONPATH": str(SOURCE)}
    return subprocess.run(
        [sys.executable, "-c", code],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def test_sigkill_loses_nothing_that_was_flushed(tmp_path):
    child = run_child(CHILD, tmp_path)
    assert child.returncode == -signal.SIGKILL
    assert messages_in(tmp_path / "bag" / "bag_0.mcap") == [b"%d" % k for k in range(1000)]
    assert not (tmp_path / "bag" / "metadata.yaml").exists()


def test_a_limit_of_the_operating_system_ends_in_one_line(tmp_path):
    child = run_child(FULL_CHILD, tmp_path)
    assert child.returncode == 0
    assert child.stderr == ""
    assert "bag_0.mcap: recording stopped (File too large)" in child.stdout
    assert len(child.stdout.splitlines()) == 1
    assert len(messages_in(tmp_path / "bag" / "bag_0.mcap")) > 100
