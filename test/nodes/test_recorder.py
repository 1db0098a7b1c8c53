"""The recorder takes topics of any type, keeps every message, and says what it missed."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Vector3Stamped
from node_messages import PERIOD_NS, tell
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from rosbags.highlevel import AnyReader
from spacecraft_gnc_msgs.msg import AttitudeReference
from std_msgs.msg import Header, String

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.nodes.recorder import RecorderNode
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.ros.qos import ros_qos
from spacecraft_gnc.signals import graph
from spacecraft_gnc.signals.attitude import ACCEPTED_TARGET, TARGET, at_rest
from spacecraft_gnc.signals.members import foreign
from spacecraft_gnc.signals.message import stamp_of
from spacecraft_gnc.signals.qos import RECORD
from spacecraft_gnc.vehicles.rigid_body.signals import SIGNALS, STATE

MANY = RECORD.depth + 500  # messages: more than the recorder's reader keeps


@pytest.fixture
def recorder(ros: Any) -> Iterator[Callable[..., RecorderNode]]:
    """Yield a function that starts a recorder of some topics."""
    started: list[RecorderNode] = []

    def start(*topics: str) -> RecorderNode:
        node = ros.add(RecorderNode())
        node._parameter_overrides["topics"] = Parameter("topics", value=list(topics))
        for transition in (node.trigger_configure, node.trigger_activate):
            assert transition().name == "SUCCESS", node.failure
        started.append(node)
        return node

    yield start
    for node in started:
        node.trigger_shutdown()


@pytest.fixture
def sender(ros: Any) -> Iterator[Node]:
    return ros.add(Node("sender"))


def matched(ros: Any, publisher: Any) -> Any:
    ros.spin_until(lambda: publisher.get_subscription_count() > 0)
    return publisher


def closed(ros: Any, recorder: RecorderNode, written: int) -> Path:
    """Wait for messages, close the bag and return its folder."""
    ros.spin_until(lambda: recorder.progress() >= written)
    recorder.trigger_deactivate()
    recorder.trigger_cleanup()
    assert recorder.failure is None
    return Path(recorder._bag.folder)


def test_topics_that_are_not_of_the_graph() -> None:
    known = [("", signal) for signal in (*SIGNALS, *graph.SIGNALS)]
    wanted = ["attitude_state", "/pose", "/clock", "*", "/mine", "yours"]
    assert foreign(known, wanted) == ("/mine", "yours")
    of_an_agent = [("sc1", signal) for signal in SIGNALS]
    assert foreign(of_an_agent, ["sc1/pose", "pose", "/sc2/pose"]) == ("/sc2/pose",)
    assert STATE.is_recorded([])
    assert STATE.is_recorded(["*", "/mine"])
    assert not STATE.is_recorded(["/mine"])


def test_messages_of_other_types(ros: Any, recorder: Any, sender: Node) -> None:
    node = recorder("/words", "force")
    words = matched(ros, sender.create_publisher(String, "words", 10))
    forces = matched(ros, sender.create_publisher(Vector3Stamped, "force", 10))
    for number in range(5):
        words.publish(String(data="the same"))
        force = Vector3Stamped()
        force.vector.x = float(number)
        forces.publish(force)
    bag = closed(ros, node, 10)
    with AnyReader([bag]) as reader:
        types = {name: topic.msgtype for name, topic in reader.topics.items()}
        found = [(c.topic, reader.deserialize(data, c.msgtype)) for c, _, data in reader.messages()]
        qos = reader.topics["/words"].connections[0].ext.offered_qos_profiles[0]
    assert types == {"/words": "std_msgs/msg/String", "/force": "geometry_msgs/msg/Vector3Stamped"}
    assert [m.data for topic, m in found if topic == "/words"] == ["the same"] * 5
    assert [m.vector.x for topic, m in found if topic == "/force"] == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert qos.reliability.name == "RELIABLE"


def test_all_of_the_graph_and_one_more(ros: Any, recorder: Any, sender: Node) -> None:
    node = recorder("*", "/words")
    words = matched(ros, sender.create_publisher(String, "words", 10))
    words.publish(String(data="word"))
    bag = closed(ros, node, 1)
    with open_bag(bag) as opened:
        assert {"/words", "/attitude_state", "/clock", "/diagnostics"} <= opened.topics.keys()


def test_nodes_that_do_not_answer_are_named(ros: Any, recorder: Any, sender: Node) -> None:
    node = recorder("/words")
    words = matched(ros, sender.create_publisher(String, "words", 10))
    words.publish(String(data="word"))
    bag = closed(ros, node, 1)
    with open_bag(bag) as opened:
        text = opened.attachments()["parameters.yaml"].decode()
    silent = {"plant", "nmpc_controller", "reference_governor"}
    assert {line for line in text.splitlines() if line.startswith("#")} == {
        f"# {name}: did not answer" for name in silent
    }
    own = yaml.safe_load(text)["recorder"]["ros__parameters"]
    assert own["topics"] == ["/words"]
    assert own["use_sim_time"] is True


def test_what_a_latched_topic_said_before(ros: Any, recorder: Any, sender: Node) -> None:
    qos = QoSProfile(depth=3, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    publisher = sender.create_publisher(String, "latched", qos)
    for word in ("one", "two", "three"):
        publisher.publish(String(data=word))
    bag = closed(ros, recorder("/latched"), 3)
    with AnyReader([bag]) as reader:
        words = [reader.deserialize(data, c.msgtype).data for c, _, data in reader.messages()]
    assert words == ["one", "two", "three"]


def test_a_best_effort_publisher(ros: Any, recorder: Any, sender: Node) -> None:
    node = recorder("/quick")
    publisher = sender.create_publisher(String, "quick", qos_profile_sensor_data)
    matched(ros, publisher).publish(String(data="word"))
    bag = closed(ros, node, 1)
    with AnyReader([bag]) as reader:
        (connection,) = reader.connections
    assert connection.ext.offered_qos_profiles[0].reliability.name == "BEST_EFFORT"


def test_a_type_that_is_not_installed(ros: Any, recorder: Any, monkeypatch: Any) -> None:
    node = recorder("/odd")
    told = [type("Endpoint", (), {"topic_type": "nowhere_msgs/msg/Odd"})]
    monkeypatch.setattr(node, "get_publishers_info_by_topic", lambda _: told)
    ros.spin_until(lambda: node.finished)
    assert isinstance(node.failure, RecordingError)
    assert "/odd: received messages of type nowhere_msgs/msg/Odd; required a type that is" in str(
        node.failure
    )


def test_a_name_that_cannot_be_one(ros: Any) -> None:
    node = ros.add(RecorderNode())
    node._parameter_overrides["topics"] = Parameter("topics", value=["no topic"])
    assert node.trigger_configure().name == "FAILURE"
    assert "recorder.topics: received 'no topic'" in str(node.failure)


def test_a_topic_without_a_publisher_leaves_no_bag_and_is_named(
    ros: Any, recorder: Any, tmp_path: Path
) -> None:
    node = recorder("/silent")
    assert node._foreign.waiting == ["/silent"]
    node.trigger_deactivate()
    node.trigger_cleanup()
    assert not (tmp_path / "bag").exists()


def test_a_full_disk_ends_the_node_with_one_line(
    ros: Any, recorder: Any, sender: Node, monkeypatch: Any
) -> None:
    node = recorder("/words")
    words = matched(ros, sender.create_publisher(String, "words", 10))
    words.publish(String(data="saved"))
    ros.spin_until(lambda: node.progress() == 1)
    node._flush()

    def fail(_: bytes) -> int:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(node._bag._file, "write", fail)
    words.publish(String(data="lost"))
    ros.spin_until(lambda: node.finished)
    assert "No space left on device); 1 messages are saved" in str(node.failure)
    node.trigger_deactivate()
    assert node.trigger_cleanup().name == "SUCCESS"
    assert [path.name for path in Path(node._bag.folder).iterdir()] == ["bag_0.mcap"]


def test_losses_are_counted_shouted_and_kept(ros: Any, recorder: Any, sender: Node) -> None:
    shouts: list[DiagnosticArray] = []
    sender.create_subscription(DiagnosticArray, "/diagnostics", shouts.append, 100)
    node = recorder("/words")
    words = matched(ros, sender.create_publisher(String, "words", 2 * MANY))
    words.publish(String(data="first"))
    ros.spin_until(lambda: node.progress() == 1)
    for number in range(MANY):  # nobody spins: the reader's queue overflows
        words.publish(String(data=str(number)))
    watch = node._watches["/words"]
    ros.spin_until(lambda: node.progress() + watch.lost == MANY + 1)
    assert watch.lost >= MANY - RECORD.depth
    ros.spin_until(lambda: bool(shouts))
    status = shouts[0].status[0]
    assert status.level == b"\2"
    assert "MESSAGES LOST on the way to the recorder" in status.message
    lost, saved = watch.lost, node.progress()
    bag = closed(ros, node, saved)
    with open_bag(bag) as opened:
        assert opened.metadata()["losses"] == {"/words": str(lost)}
        assert sum(1 for _ in opened.messages(["/words"])) == saved
    told = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert told["custom_data"] == {"messages_lost": str(lost), "messages_lost /words": str(lost)}


@pytest.mark.parametrize(("signal", "lost"), [(TARGET, 0), (ACCEPTED_TARGET, 5)], ids=str)
def test_a_gap_in_what_a_user_numbers_is_no_loss_of_the_flight(
    ros: Any, recorder: Any, signal: Any, lost: int
) -> None:
    """The accepted target comes from a node of the flight, and its gap is one."""
    node = recorder(signal.name)
    for step, number in ((40, 1), (90, 7)):
        data = signal.encode(stamp_of(step, PERIOD_NS), step, at_rest(np.eye(3)))
        tell(node, signal.name, (data, {"publication_sequence_number": number}))
    bag = closed(ros, node, 2)
    with open_bag(bag) as found:
        assert found.metadata()["losses"] == {f"/{signal}": str(lost)}


def test_a_target_now_and_then_is_no_loss(ros: Any, recorder: Any, sender: Node) -> None:
    """Its steps are those of a flight, and most of them have none."""
    node = recorder("target_attitude", "accepted_target")
    topics = [
        matched(ros, sender.create_publisher(AttitudeReference, topic.name, ros_qos(topic.qos)))
        for topic in (TARGET, ACCEPTED_TARGET)
    ]
    for step in (40, 90):
        seconds, nanoseconds = stamp_of(step, PERIOD_NS)
        header = Header(stamp=Time(sec=seconds, nanosec=nanoseconds))
        for topic in topics:
            topic.publish(AttitudeReference(header=header, step=step))
    bag = closed(ros, node, 4)
    with open_bag(bag) as found:
        losses = found.metadata()["losses"]
    assert losses == {"/target_attitude": "0", "/accepted_target": "0"}
