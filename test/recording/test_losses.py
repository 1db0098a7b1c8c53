"""The writer keeps what its receiver says was lost, at the end and while it records."""

from __future__ import annotations

import shutil

import numpy as np
import pytest
import yaml
from recording.bags import CODEC

from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.metadata import read_losses
from spacecraft_gnc.recording.writer import BagWriter

STRING = "std_msgs/msg/String"
STATE = "spacecraft_gnc_msgs/msg/AttitudeState"


@pytest.fixture
def bag(tmp_path):
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic("/words", STRING, CODEC.texts[STRING])
        writer.add_topic("/free", STATE, CODEC.texts[STATE], gapless=False)
        writer.add_topic("/every", STATE, CODEC.texts[STATE])
        for step in (0, 1, 5):
            data = CODEC.state(step, np.eye(3), np.zeros(3))
            writer.write("/free", step, step, data)
            writer.write("/every", step, step, data)
        writer.write("/words", 5, 5, b"\0\1\0\0\2\0\0\0a\0")
        yield writer


def losses(path):
    with open_bag(path, allow_unfinished=True) as opened:
        return {name: int(lost) for name, lost in opened.metadata()["losses"].items()}


def test_a_missing_step_is_a_loss_where_every_step_speaks(bag):
    assert {name: count.lost for name, count in bag.counts.items()} == {
        "/words": 0,
        "/free": 0,
        "/every": 3,
    }


def test_what_the_receiver_missed_is_in_the_bag(bag):
    bag.report_loss("/words", 7)
    bag.report_loss("/every", 2)  # two of the same three
    bag.close()
    assert losses(bag.folder) == {"/words": 7, "/free": 0, "/every": 3}
    told = yaml.safe_load((bag.folder / "metadata.yaml").read_text())
    assert read_losses(bag.folder) == {"/words": 7, "/every": 3}
    assert told["rosbag2_bagfile_information"]["custom_data"] == {
        "messages_lost": "10",
        "messages_lost /words": "7",
        "messages_lost /every": "3",
    }


def test_a_bag_that_is_cut_off_tells_of_losses_before(bag, tmp_path):
    bag.report_loss("/words", 7)
    bag.flush()
    shutil.copy(bag.path, tmp_path / "cut.mcap")
    assert losses(tmp_path / "cut.mcap")["/words"] == 7
