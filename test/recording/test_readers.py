"""Bags as readers of other houses see them: Foxglove's libraries for Node, and Rerun's checker.

Where they are not installed the tests are skipped, and the reason says how to install them; with
the environment variable GNC_REQUIRE_READERS=1, as in CI, they fail.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from flown_bags import fly
from recording.bags import record

from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.writer import BagWriter
from spacecraft_gnc.signals import graph
from spacecraft_gnc.vehicles.rigid_body import signals as rigid_body

ROOT = Path(__file__).resolve().parents[2]
READERS = ROOT / "test" / "readers"
REQUIRE = "GNC_REQUIRE_READERS"
PATIENCE = 120.0  # [s] of a program, most of which is its start


def missing(reason: str) -> None:
    """Skip a test for want of a program; fail where it is required."""
    if os.environ.get(REQUIRE) == "1":
        pytest.fail(f"{reason}, and {REQUIRE}=1 asks for it")
    pytest.skip(reason)


def run(*command: object, home: Path) -> subprocess.CompletedProcess[str]:
    """Run a program that keeps its settings in a folder of ours."""
    env = os.environ | {"HOME": str(home), "XDG_CONFIG_HOME": str(home), "XDG_DATA_HOME": str(home)}
    return subprocess.run(
        [str(word) for word in command],
        env=env,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return fly(tmp_path_factory.mktemp("flown"))


def counts(bag: Path) -> dict[str, int]:
    """Return the messages of each topic that has any."""
    with open_bag(bag) as opened:
        return {topic: count for topic, count in opened.counts.items() if count}


@pytest.fixture
def decode(tmp_path: Path):
    """Return a function that runs the reader for Node on files."""
    node = shutil.which("node")
    if node is None or not (READERS / "node_modules").is_dir():
        missing("Foxglove's libraries are not installed (Node >= 20; npm ci --prefix test/readers)")
    return lambda *files: run(node, READERS / "decode.mjs", *files, home=tmp_path)


@pytest.fixture
def check(tmp_path: Path):
    """Return a function that runs Rerun's checker on a file; it sends nothing anywhere."""
    rerun = shutil.which("rerun", path=f"{ROOT / '.venv-readers' / 'bin'}:{os.environ['PATH']}")
    if rerun is None:
        missing("rerun-sdk is not installed (see test/readers/requirements.txt)")
    done = run(rerun, "analytics", "disable", home=tmp_path)
    assert done.returncode == 0, done.stderr
    return lambda file: run(rerun, "mcap", "check", "--full", file, home=tmp_path)


def test_foxglove_decodes_every_message(bag: Path, decode) -> None:
    (file,) = bag.glob("*.mcap")
    done = decode(file)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["topics"] == counts(bag)
    assert sum(found["topics"].values()) > 60
    assert found["metadata"]["rosbag2"] == 1  # readers join records of one name


@pytest.fixture(scope="module")
def every_type(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a bag with two messages of each topic of the graph, as the recorder announces it."""
    pytest.importorskip("rclpy")
    from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
    from rclpy.serialization import serialize_message
    from visualization_msgs.msg import Marker, MarkerArray

    from spacecraft_gnc.ros.bag_topics import announce
    from spacecraft_gnc.ros.endpoints import message_type

    nested = {
        MarkerArray: MarkerArray(markers=[Marker(ns="zone", text="star")]),
        DiagnosticArray: DiagnosticArray(
            status=[DiagnosticStatus(name="plant", values=[KeyValue(key="step", value="3")])]
        ),
    }
    folder = tmp_path_factory.mktemp("types") / "bag"
    with BagWriter(folder) as writer:
        for signal in (*rigid_body.SIGNALS, *graph.SIGNALS):
            name, kind = f"/{signal.name.strip('/')}", message_type(signal.type)
            announce(writer, name, signal.type, [signal.qos], gapless=False)
            data = bytes(serialize_message(nested.get(kind, kind())))
            for step in range(2):
                writer.write(name, step, step, data)
    return folder


def test_foxglove_decodes_every_type_of_the_graph(every_type: Path, decode) -> None:
    done = decode(*every_type.glob("*.mcap"))
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)["topics"]
    assert found == counts(every_type)
    assert {"/pose", "/zone_markers", "/diagnostics", "/attitude_error", "/clock"} <= set(found)


def test_foxglove_reader_notices_damage(bag: Path, decode, tmp_path: Path) -> None:
    """Of a definition, a message and the end of the file: the test can fail."""
    plain = record(tmp_path / "plain", [("attitude_state", 0, b"\0\1\0\0")], compression="none")
    data = next(plain.glob("*.mcap")).read_bytes()
    (whole,) = bag.glob("*.mcap")
    for i, damaged in enumerate(
        (data, data.replace(b"float64[9] attitude", b"float64[9] @ttitud"), whole.read_bytes()[:-9])
    ):
        path = tmp_path / f"{i}.mcap"
        path.write_bytes(damaged)
        assert decode(path).returncode != 0


def test_rerun_finds_no_issue(bag: Path, check) -> None:
    (file,) = bag.glob("*.mcap")
    done = check(file)
    assert done.returncode == 0, done.stderr
    assert "WARN" not in done.stderr
    assert set(rows(done.stdout)) == {("ok", topic) for topic in counts(bag)}


def test_rerun_finds_a_bag_out_of_order(bag: Path, check, tmp_path: Path) -> None:
    with open_bag(bag) as opened:
        items = [(topic.strip("/"), data) for topic, data in opened.messages(["/attitude_state"])]
    backwards = [(topic, step, data) for step, (topic, data) in enumerate(items)][::-1]
    done = check(record(tmp_path / "bag", backwards, chunk_size=500) / "bag_0.mcap")
    assert rows(done.stdout) == [("PROBLEM", "/attitude_state")]


def rows(table: str) -> list[tuple[str, str]]:
    """Return (verdict, topic) of each line of the checker's table."""
    return re.findall(r"^(ok|PROBLEM)\s+\d+\s+\d+\s+(/\S+)", table, flags=re.MULTILINE)
