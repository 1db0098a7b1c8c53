"""``gnc replay --publish``: a player process, and listeners in this one."""

from __future__ import annotations

import os
import pty
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from graph.players import (
    PATIENCE,
    ROOT,
    STEPS,
    TYPES,
    Listener,
    Player,
    padded,
    recorded,
    stamp,
    text,
)
from recording.foreign_bags import edit, with_the_span_of_the_end, without_qos
from std_msgs.msg import String

from spacecraft_gnc.analysis.reader import read_flight
from spacecraft_gnc.launcher import environment
from spacecraft_gnc.ros.qos import ros_qos
from spacecraft_gnc.signals.qos import latched
from spacecraft_gnc.vehicles.rigid_body.signals import TORQUE

pytestmark = pytest.mark.graph


@pytest.fixture
def play(tmp_path: Path) -> Iterator[Callable[..., tuple[Player, Listener]]]:
    """Start a player of a bag, and a listener on its domain."""
    started: list[Any] = []

    def start(*options: str, bag: Path | None = None) -> tuple[Player, Listener]:
        if bag is None:
            bag = tmp_path / "bag"
            recorded(bag)
        player = Player(bag, *options)
        started.append(player.process)
        listener = Listener(player.domain_id)
        started.append(listener)
        return player, listener

    yield start
    for item in reversed(started):
        if isinstance(item, Listener):
            item.close()
        elif item.poll() is None:
            with item:
                item.kill()


def test_all_messages_arrive_as_recorded(play: Any, tmp_path: Path) -> None:
    bag = tmp_path / "all"
    payloads = recorded(bag, unplayable=True)
    edit(bag, without_qos)
    edit(bag, with_the_span_of_the_end)
    heard = (*TYPES, "/note")  # some topics are announced and hold nothing
    expected_readers = [word for name in heard for word in ("--wait-for", name)]
    player, listener = play("--rate", "max", *expected_readers, bag=bag)
    listener.listen(*TYPES)
    listener.listen("/note", kind=String, qos=ros_qos(latched(1)))
    count = sum(len(messages) for messages in payloads.values()) + STEPS + 2
    listener.spin_until(lambda: sum(map(len, listener.heard.values())) >= count)
    for topic, expected in payloads.items():
        assert listener.heard[topic] == [padded(data) for data in expected]
    assert listener.heard["/note"] == [text("remember")]
    out, err = player.end(code=1)
    assert f"played to its end, {6 * STEPS + 4 + STEPS} messages" in out
    changed = "std_msgs/msg/Int32 is installed in another version than was recorded"
    remedy = "required all that it holds; name what is to be played with --topics"
    assert err.splitlines() == [
        f"warning: {bag}: /foreign is left out: absent_msgs/msg/Thing is not installed",
        f"warning: {bag}: /other is left out: {changed}",
        f"error: {bag}: /foreign, /other not played; {remedy}",
    ]


def test_who_joins_late_gets_what_is_latched(play: Any) -> None:
    player, listener = play("--start", "8", "--wait-for", "attitude_state")
    listener.listen("/attitude_state")
    listener.spin_until(lambda: listener.heard["/attitude_state"])
    listener.listen("/note", kind=String, qos=ros_qos(latched(1)))
    listener.spin_until(lambda: listener.heard["/note"])
    assert listener.heard["/note"] == [text("remember")]
    assert listener.steps("/attitude_state")[0] == 20
    player.process.send_signal(signal.SIGINT)
    out, _ = player.end()
    assert "ended at" in out


def test_its_parameters_control_it(play: Any) -> None:
    player, listener = play("--paused", "--wait-for", "attitude_state", "--wait-for", "clock")
    listener.listen("/attitude_state", "/clock")
    assert listener.get("paused") is True
    assert listener.set("position", 12.0).successful
    assert listener.set("rate", 50.0).successful
    assert not listener.heard["/attitude_state"]
    assert listener.set("paused", False).successful
    expected = list(range(30, STEPS + 1))
    listener.spin_until(lambda: len(listener.heard["/attitude_state"]) == len(expected))
    assert listener.steps("/attitude_state") == expected
    ticks = [int.from_bytes(data[4:8], "little") for data in listener.heard["/clock"]]
    assert ticks == sorted(ticks)
    assert ticks[0] == 12
    player.end()


def test_what_it_refuses_changes_nothing(play: Any) -> None:
    player, listener = play("--paused", "--rate", "3", "--wait-for", "clock")
    listener.listen("/clock")
    for name, value in (("rate", -1.0), ("rate", float("nan")), ("position", 17.0)):
        result = listener.set(name, value)
        assert not result.successful
        assert result.reason.startswith(f"{name}: received ")
        assert "required" in result.reason
    assert listener.get("rate") == 3.0
    assert listener.get("position") == 0.0
    player.process.send_signal(signal.SIGINT)
    player.end()


def test_it_begins_again_and_can_be_taken_back(play: Any) -> None:
    player, listener = play("--rate", "100", "--loop", "--wait-for", "attitude_state")
    listener.listen("/attitude_state")
    listener.spin_until(lambda: listener.steps("/attitude_state").count(0) >= 3)
    steps = listener.steps("/attitude_state")
    assert steps[: 2 * (STEPS + 1)] == [*range(STEPS + 1)] * 2
    assert listener.set("loop", False).successful
    player.end()


def test_only_what_is_wanted_is_played(play: Any) -> None:
    wanted = ("/torque_command", "/clock")
    player, listener = play("--topics", "torque_command", "--rate", "max")
    listener.listen(*wanted)
    out, err = player.end()
    assert f"played to its end, {2 * STEPS} messages" in out  # the clock ticks beside it
    assert err == ""
    listener.spin_until(lambda: all(len(listener.heard[n]) >= STEPS for n in wanted))
    ticks = [data[4:] for data in listener.heard["/clock"]]
    assert ticks == [stamp(k) for k in range(STEPS)]


def test_a_live_controller_answers_a_replay_as_it_did_in_flight(
    play: Any, graph: Any, tmp_path: Path
) -> None:
    """The recorded states and references, into a controller: its torques are those recorded."""
    flown = graph.fly("plant.duration=8.0") / "bag"
    player, listener = play(
        "--rate", "20", "--paused", "--topics", "attitude_state", "--topics", "attitude_reference",
        "--wait-for", "attitude_state", "--wait-for", "attitude_reference",
        bag=flown,
    )  # fmt: skip
    listener.listen("/torque_command")
    env = environment.for_node(os.environ, player.domain_id)
    env["PYTHONPATH"] = str(ROOT)
    file = ROOT / "config" / "gupta2015_case1.yaml"
    command = [sys.executable, "-m", "spacecraft_gnc.nodes.nmpc_controller"]
    controller = subprocess.Popen(
        [*command, "--ros-args", "--params-file", str(file)],
        env=env,
        stdin=subprocess.PIPE,
    )
    try:
        listener.spin_until(lambda: listener.node.count_subscribers("/attitude_reference") == 1)
        listener.spin_until(lambda: listener.node.count_publishers("/torque_command") == 1)
        listener.set("paused", False)
        listener.spin_until(lambda: len(listener.heard["/torque_command"]) == 20)
    finally:
        assert controller.stdin is not None
        controller.stdin.close()
        controller.wait(PATIENCE)
    player.end()
    answers = [TORQUE.decode(data) for data in listener.heard["/torque_command"]]
    assert [answer.step for answer in answers] == list(range(20))
    commanded = read_flight(flown).trajectory.torque
    assert np.array_equal([answer["torque"] for answer in answers], commanded)


def test_without_a_subscriber_it_begins_when_its_patience_is_over(tmp_path: Path) -> None:
    recorded(tmp_path / "bag")
    options = ("--topics", "attitude_state", "--rate", "max", "--wait-for", "clock")
    player = Player(tmp_path / "bag", *options, "--patience", "0.2")
    out, err = player.end()
    assert f"played to its end, {2 * (STEPS + 1)} messages" in out
    assert err == "warning: nobody listens to /clock after 0.2 s\n"


def test_keys_control_it(tmp_path: Path) -> None:
    recorded(tmp_path / "bag")
    master, slave = pty.openpty()
    player = Player(tmp_path / "bag", "--paused", "--patience", "0", terminal=slave)
    os.close(slave)
    try:
        for keys, answer in (
            (b"", b"playing paused"),
            (b"\x1b[B\x1b[B ", b"playing at rate 0.25"),
            (b"\x1b[A ?x ", b"playing at rate 0.5"),
            (b"\x1b[C ", b"playing paused"),
        ):
            os.write(master, keys)
            read_until(master, answer)
        os.write(master, b"q")
        out, _ = player.end()
    finally:
        player.process.kill()
        os.close(master)
    assert "space pauses" in out
    assert "ended at" in out


def read_until(descriptor: int, words: bytes) -> None:
    """Read what is shown until ``words`` are."""
    shown = b""
    deadline = time.monotonic() + PATIENCE
    while words not in shown:
        assert time.monotonic() < deadline, f"{words!r} was never shown, but {shown[-200:]!r}"
        readable, _, _ = select.select([descriptor], [], [], 0.1)
        if readable:
            shown += os.read(descriptor, 4096)
