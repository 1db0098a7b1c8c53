"""The order in which a bag is played."""

from __future__ import annotations

import random
import struct

import pytest
from recording.bags import CODEC, announce, flight_messages, random_flight, record

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.playback import Playback, strongest
from spacecraft_gnc.recording.qos import qos_yaml
from spacecraft_gnc.recording.stamps import step_of
from spacecraft_gnc.recording.writer import BagWriter
from spacecraft_gnc.signals import graph
from spacecraft_gnc.signals.qos import QosProfile
from spacecraft_gnc.vehicles.known_signals import every_signal

CLOCK = graph.CLOCK.name

ORDER = [
    "/attitude_state",
    "/plant_invariants",
    CLOCK,
    "/attitude_reference",
    "/governor_status",
    "/torque_command",
    "/solver_status",
]
STRING = "std_msgs/msg/String"


def play(folder, wanted=(), from_ns=0):
    with open_bag(folder) as bag:
        return list(Playback(bag, wanted, every_signal()).moments(from_ns))


def shuffled(n, seed):
    items = flight_messages(random_flight(n))
    random.Random(seed).shuffle(items)
    return items


@pytest.mark.parametrize("seed", range(5))
def test_messages_of_one_stamp_follow_cause_and_effect(tmp_path, seed):
    moments = play(record(tmp_path / "bag", shuffled(6, seed), chunk_size=500))
    assert [moment.time_ns for moment in moments] == [k * 400_000_000 for k in range(7)]
    for moment in moments[:-1]:
        assert [name for name, _ in moment.messages] == ORDER
    assert [name for name, _ in moments[-1].messages] == ORDER[:3]


def test_of_one_stamp_the_steps_come_in_order(tmp_path):
    """A bag that was stamped by wall time may have many steps at one stamp."""
    items = [(topic, 0, data) for topic, _, data in shuffled(4, 3)]
    (moment,) = play(record(tmp_path / "bag", items))
    steps = [step_of(data) for name, data in moment.messages if name != CLOCK]
    assert steps == sorted(steps)
    states = [data for name, data in moment.messages if name == "/attitude_state"]
    assert len(states) == 5


def test_every_message_is_played_once_and_unchanged(tmp_path):
    items = shuffled(5, 1)
    moments = play(record(tmp_path / "bag", items))
    played = [(n, d) for moment in moments for n, d in moment.messages if n != CLOCK]
    assert sorted(played) == sorted((f"/{topic}", data) for topic, _, data in items)


def test_a_clock_is_made_where_none_was_recorded(tmp_path):
    moments = play(record(tmp_path / "bag", shuffled(3, 0)))
    ticks = [data for moment in moments for name, data in moment.messages if name == CLOCK]
    read = [struct.unpack("<4siI", tick)[1:] for tick in ticks]
    assert read == [(0, 0), (0, 400_000_000), (0, 800_000_000), (1, 200_000_000)]


def test_the_recorded_clock_is_played_even_if_other_topics_are_not(tmp_path):
    definition = "builtin_interfaces/Time clock\n" + "=" * 80 + "\nMSG: builtin_interfaces/Time\n"
    with BagWriter(tmp_path / "bag") as writer:
        announce(writer)
        writer.add_topic(CLOCK, "rosgraph_msgs/msg/Clock", definition + "int32 sec\nuint32 nanosec")
        for topic, step, data in shuffled(2, 0):
            writer.write(f"/{topic}", step, step, data)
        writer.write(CLOCK, 1, 1, struct.pack("<4siI", b"\0\1\0\0", 7, 8))
    moments = play(tmp_path / "bag", ["torque_command"])
    assert [name for moment in moments for name, _ in moment.messages] == [
        "/torque_command",
        CLOCK,
        "/torque_command",
    ]


def test_playing_starts_anywhere(tmp_path):
    folder = record(tmp_path / "bag", shuffled(5, 2))
    assert [m.time_ns for m in play(folder, from_ns=800_000_000)] == [
        800_000_000,
        1_200_000_000,
        1_600_000_000,
        2_000_000_000,
    ]
    with open_bag(folder) as bag:
        playback = Playback(bag)
        assert playback.duration == 2.0
        assert playback.position(playback.time_ns(1.3)) == pytest.approx(1.3)


def test_topics_are_chosen_by_full_name_or_last_part(tmp_path):
    folder = record(tmp_path / "bag", shuffled(2, 0), namespace="/one")
    with open_bag(folder) as bag:
        chosen = Playback(bag, ["/one/torque_command", "attitude_state"]).topics
        assert set(chosen) == {"/one/torque_command", "/one/attitude_state", CLOCK}
        with pytest.raises(RecordingError, match=r"--topics: received 'bogus'; .*attitude_state"):
            Playback(bag, ["bogus"])


def text(number):
    length = len(str(number)) + 1
    return b"\0\1\0\0" + struct.pack("<I", length) + str(number).encode() + b"\0"


def test_what_is_latched_is_there_wherever_playing_starts(tmp_path):
    latched = QosProfile(depth=2, durability="transient_local")
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic("/kept", STRING, CODEC.texts[STRING], qos_yaml=qos_yaml(latched))
        writer.add_topic("/gone", STRING, CODEC.texts[STRING], qos_yaml=qos_yaml(QosProfile()))
        for number in range(6):
            writer.write("/kept", number, number, text(number))
            writer.write("/gone", number, number, text(number))
    with open_bag(tmp_path / "bag") as bag:
        playback = Playback(bag)
        assert playback.latched(0) == []
        assert playback.latched(4) == [("/kept", text(2)), ("/kept", text(3))]


def test_a_bag_without_a_message_is_refused(tmp_path):
    folder = record(tmp_path / "bag", [])
    with open_bag(folder) as bag, pytest.raises(RecordingError, match="without a message"):
        Playback(bag)


def test_the_recorded_qos_is_offered(tmp_path):
    with open_bag(record(tmp_path / "bag", shuffled(2, 0))) as bag:
        assert Playback(bag).topics["/attitude_state"].qos == QosProfile(depth=1000)


def test_several_publishers_are_served_by_the_strongest_offer():
    weak = QosProfile(depth=5, reliability="best_effort", deadline_ns=10**9)
    kept = QosProfile(depth=1, durability="transient_local", lifespan_ns=10**9)
    both = strongest([weak, kept])
    assert (both.reliability, both.durability, both.depth) == ("reliable", "transient_local", 5)
    assert (both.deadline_ns, both.lifespan_ns) == (10**9, QosProfile().lifespan_ns)
    assert strongest([]) == QosProfile()
    assert strongest([QosProfile(history="unknown", depth=0)]).depth == 100


def test_a_log_time_that_no_clock_can_tell(tmp_path):
    (topic, _, data), *_ = flight_messages(random_flight(1))
    with BagWriter(tmp_path / "bag") as bag:
        announce(bag)
        bag.write(f"/{topic}", 2**31 * 10**9, 0, data)
    with pytest.raises(RecordingError, match="received a message of log time 2147483648 s; requ"):
        play(tmp_path / "bag")
