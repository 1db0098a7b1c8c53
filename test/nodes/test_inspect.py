"""``gnc inspect`` in a process of its own, against nodes that live here."""

from __future__ import annotations

import json
import os
import select
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

from spacecraft_gnc.nodes.plant import PlantNode

ROOT = Path(__file__).resolve().parents[2]


class Answer(NamedTuple):
    code: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        return json.loads(self.out)

    @property
    def error(self) -> str:
        """The one line of a refusal."""
        assert self.out == ""
        (line,) = self.err.splitlines()
        assert line.startswith("error: ")
        return line


class Graph:
    """A plant and a plain node, spun while a command looks at them."""

    def __init__(self, ros: Any) -> None:
        self.ros = ros
        self.plant = ros.add(PlantNode())
        assert self.plant.trigger_configure().name == "SUCCESS"
        self.plain = ros.add(Node("talker", namespace="elsewhere"))
        self.plain.declare_parameter("gain", 1.5)
        self.words = self.plain.create_publisher(String, "words", 10)
        self.pose = self.plain.create_publisher(PoseStamped, "where", 10)
        self.clock = self.plain.create_publisher(Clock, "/clock", 10)
        self.timer = self.plain.create_timer(0.02, self.talk)
        self.now = 0

    def talk(self) -> None:
        self.now += 1
        tick, pose = Clock(), PoseStamped()
        tick.clock.sec = self.now + 3
        pose.header.stamp.sec = self.now
        pose.pose.position.y = 0.25
        self.clock.publish(tick)
        self.pose.publish(pose)
        self.words.publish(String(data="hello"))

    def inspect(self, *argv: str, path: str = str(ROOT)) -> Answer:
        with self.start(argv, path) as process:
            self.ros.spin_until(lambda: process.poll() is not None)
            return answer_of(process)

    def interrupt(self, *argv: str) -> Answer:
        """Press Ctrl-C once the command has printed something."""
        with self.start(argv, str(ROOT)) as process:
            self.ros.spin_until(lambda: bool(select.select([process.stdout], [], [], 0.0)[0]))
            process.send_signal(signal.SIGINT)
            self.ros.spin_until(lambda: process.poll() is not None)
            return answer_of(process)

    def start(self, argv: tuple[str, ...], path: str) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "spacecraft_gnc", "inspect", *argv]
        command += ["--domain-id", str(self.ros.nodes_domain())]
        return subprocess.Popen(
            command,
            cwd=ROOT,
            env={**os.environ, "PYTHONPATH": path},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )


def answer_of(process: subprocess.Popen[str]) -> Answer:
    assert process.stdout is not None
    assert process.stderr is not None
    return Answer(process.returncode, process.stdout.read(), process.stderr.read())


@pytest.fixture
def graph(ros: Any) -> Iterator[Graph]:
    graph = Graph(ros)
    yield graph
    graph.plain.destroy_timer(graph.timer)
    graph.plant.trigger_shutdown()


def test_nodes(graph: Graph) -> None:
    assert graph.inspect("nodes", "--json").json["nodes"] == ["/elsewhere/talker", "/plant"]


def test_topics_with_qos_and_rates(graph: Graph) -> None:
    deaf = graph.ros.add(Node("deaf"))
    best_effort = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    deaf.create_publisher(String, "noise", best_effort)
    deaf.create_subscription(String, "noise", lambda _: None, QoSProfile(depth=1))
    found = graph.inspect("topics", "--qos", "--rates", "--json").json["topics"]
    topics = {entry["name"]: entry for entry in found}
    words = topics["/elsewhere/words"]
    assert words["types"] == ["std_msgs/msg/String"]
    assert words["published_by"][0]["node"] == "/elsewhere/talker"
    assert words["published_by"][0]["qos"].startswith("reliable, volatile")
    assert words["hz"] > 5.0
    assert words["problems"] == []
    assert topics["/attitude_state"]["hz"] == 0.0
    assert topics["/torque_command"]["hz"] is None  # nobody publishes
    (problem,) = topics["/noise"]["problems"]
    assert problem.startswith("/deaf does not hear /deaf: ")
    assert "reliab" in problem.lower()


def test_echo_a_field_as_json(graph: Graph) -> None:
    argv = ("echo", "/elsewhere/where", "--field", "pose.position.y", "--once", "--json")
    assert graph.inspect(*argv).out == "0.25\n"


def test_echo_lines(graph: Graph) -> None:
    lines = graph.inspect("echo", "/elsewhere/words", "--count", "3", "--json").out.splitlines()
    assert [json.loads(line) for line in lines] == [{"data": "hello"}] * 3


@pytest.mark.parametrize("command", ["echo", "hz", "delay"])
def test_ctrl_c_is_the_end_and_no_error(graph: Graph, command: str) -> None:
    answer = graph.interrupt(command, "/elsewhere/where", "--json")
    assert (answer.code, answer.err) == (0, "")
    assert all(json.loads(line) for line in answer.out.splitlines())


def test_echo_a_field_that_is_not_there(graph: Graph) -> None:
    answer = graph.inspect("echo", "/elsewhere/where", "--field", "pose.positon.y", "--once")
    assert answer.code == 2
    assert "'pose.positon.y'; required of pose one of position, orientation" in answer.error


@pytest.mark.parametrize("command", ["echo", "hz", "delay"])
def test_a_topic_that_is_not_there(graph: Graph, command: str) -> None:
    answer = graph.inspect(command, "nowhere")
    assert answer.code == 1
    assert "/nowhere: no such topic" in answer.error


@pytest.mark.parametrize("name", ["bad//name", "7up", ""])
def test_a_name_that_no_topic_can_have(graph: Graph, name: str) -> None:
    answer = graph.inspect("echo", name)
    assert answer.code == 2
    assert "required the name of a topic" in answer.error


@pytest.mark.parametrize("command", ["echo", "hz", "delay"])
def test_patience_has_an_end(graph: Graph, command: str) -> None:
    answer = graph.inspect(command, "attitude_state", "--timeout", "0.3")
    assert answer.code == 1
    assert "no message within 0.3 s" in answer.error


def test_hz(graph: Graph) -> None:
    rate = graph.inspect("hz", "/elsewhere/words", "-n", "1", "--json").json
    assert rate["messages"] > 1
    assert rate["period_min"] <= 1.0 / rate["hz"] <= rate["period_max"]


def test_delay_is_told_in_simulated_time(graph: Graph) -> None:
    found = graph.inspect("delay", "/elsewhere/where", "-n", "1", "--json").json
    assert found["clock"] == "simulated"
    # The clock is three seconds ahead of the stamps; a message may overtake a tick of one second.
    assert 2.0 <= found["least"] <= found["mean"] <= found["most"] <= 4.0
    assert found["speed"] > 1.0  # a second each fiftieth of a second


def test_delay_needs_a_stamp(graph: Graph) -> None:
    answer = graph.inspect("delay", "/elsewhere/words")
    assert answer.code == 1
    assert "does not begin with a header" in answer.error


def test_parameters_are_listed_got_and_set(graph: Graph) -> None:
    listed = graph.inspect("params", "talker", "--json").json
    assert listed["node"] == "/elsewhere/talker"
    assert listed["parameters"]["gain"] == 1.5
    assert graph.inspect("params", "set", "talker", "gain", "2", "--json").json["value"] == 2.0
    assert graph.plain.get_parameter("gain").value == 2.0
    assert graph.inspect("params", "set", "talker", "gain", "-1.5").code == 0
    shown = graph.inspect("params", "get", "plant", "time_step")
    assert shown.out == "0.4  (step of the integrator [s], read-only)\n"


def test_a_refused_parameter_shows_why(graph: Graph) -> None:
    answer = graph.inspect("params", "set", "plant", "time_step", "0.2")
    assert answer.code == 2
    assert "refused: Trying to set a read-only parameter: time_step" in answer.error
    assert "0.4 stays" in answer.error


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (("get", "plant", "time_stp"), "did you mean time_step?"),
        (("set", "plant", "time_step", "[1, a"), "required one YAML value"),
        (("set", "plant", "nothing", "1"), "no such parameter of /plant"),
        (("set", "talker", "gain", "[x, y]"), "received ['x', True]; required what ROS 2 takes"),
        (("set", "talker", "gain", "[[1.0], [2.0]]"), "required a flat list"),
    ],
)
def test_bad_parameter_requests(graph: Graph, argv: tuple[str, ...], words: str) -> None:
    answer = graph.inspect("params", *argv)
    assert answer.code == 2
    assert words in answer.error


def test_a_node_that_is_not_there(graph: Graph) -> None:
    answer = graph.inspect("params", "nobody")
    assert answer.code == 1
    assert "nobody: no such node" in answer.error
    assert "/elsewhere/talker, /plant" in answer.error


def test_a_full_name_is_one_node(graph: Graph) -> None:
    graph.ros.add(Node("plant", namespace="elsewhere"))
    assert graph.inspect("params", "/plant", "--json").json["node"] == "/plant"
    assert graph.inspect("params", "/nowhere/plant").code == 1


def test_life_cycle(graph: Graph) -> None:
    before = graph.inspect("lifecycle", "plant", "--json").json
    assert before["state"] == "inactive"
    assert before["transitions"]["activate"] == "activating"
    after = graph.inspect("lifecycle", "plant", "activate")
    assert (after.code, after.out.splitlines()[0]) == (0, "/plant: active")
    refused = graph.inspect("lifecycle", "plant", "configure")
    assert refused.code == 2
    assert "received transition 'configure' in state active" in refused.error


def test_a_plain_node_has_no_life_cycle(graph: Graph) -> None:
    answer = graph.inspect("lifecycle", "talker")
    assert answer.code == 1
    assert "/elsewhere/talker: has no life cycle" in answer.error


def test_watch_without_a_flight(graph: Graph) -> None:
    answer = graph.inspect("watch", "--timeout", "4")
    assert answer.code == 1
    assert "nothing received yet from /attitude_state" in answer.error
    assert "a plant is there, but has not begun" in answer.error


def test_watch_refuses_what_is_no_namespace(graph: Graph) -> None:
    answer = graph.inspect("watch", "--namespace", "a//b")
    assert answer.code == 2
    assert "'/a//b/attitude_state': topic name must not contain repeated '/'" in answer.error


MISSING = """
import sys

class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == "geometry_msgs":
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Missing())
"""


def test_a_type_that_is_not_installed_is_told_in_one_line(graph: Graph, tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text(MISSING)
    path = os.pathsep.join((str(tmp_path), str(ROOT)))
    answer = graph.inspect("echo", "/elsewhere/where", "--once", path=path)
    assert answer.code == 1
    assert "geometry_msgs/msg/PoseStamped; required a type that is installed" in answer.error
    assert "install the package geometry_msgs" in answer.error
    rates = graph.inspect("topics", "--rates", "--json", path=path)
    assert rates.code == 0, rates.err
    topics = {entry["name"]: entry["hz"] for entry in rates.json["topics"]}
    assert topics["/elsewhere/where"] is None
    assert topics["/elsewhere/words"] > 0.0
    nested = graph.inspect("echo", "attitude_state", "--once", path=path)
    assert nested.code == 1
    assert "install the package geometry_msgs" in nested.error
