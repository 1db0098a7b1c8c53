"""Any byte that changes in a recorded file is found by a checksum, and the bag refused."""

from __future__ import annotations

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from recording.bags import flight_messages, random_flight, record

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.columns import read_columns
from spacecraft_gnc.vehicles.rigid_body.signals import SIGNALS

SCENARIO = "plant:\n  ros__parameters:\n    time_step: 0.4\n"


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return the file of a finished bag in several chunks, with an attachment."""
    folder = tmp_path_factory.mktemp("bags") / "bag"
    record(folder, flight_messages(random_flight(12)), scenario=SCENARIO, chunk_size=3000)
    return folder / "bag_0.mcap"


def read_and_verify(path):
    with open_bag(path) as bag:
        bag.verify()
        read_columns(bag, [signal for signal in SIGNALS if signal.is_stepped])


def test_a_whole_file_is_verified(whole):
    read_and_verify(whole)


@settings(max_examples=200)
@given(place=st.floats(0.0, 1.0, exclude_max=True), bit=st.integers(0, 7))
@example(place=0.0, bit=0)
@example(place=0.999999, bit=0)
def test_any_flipped_bit_is_damage(whole, tmp_path_factory, place, bit):
    damaged = bytearray(whole.read_bytes())
    damaged[int(place * len(damaged))] ^= 1 << bit
    path = tmp_path_factory.mktemp("damaged") / "bag.mcap"
    path.write_bytes(damaged)
    with pytest.raises(RecordingError) as caught:
        read_and_verify(path)
    assert len(str(caught.value).splitlines()) == 1
    assert str(path) in str(caught.value)
