"""Nodes and commands as a user starts them, without the launcher."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from spacecraft_gnc.analysis.reader import read_flight
from spacecraft_gnc.launcher import domain, environment

pytestmark = pytest.mark.graph

CASE1 = Path(__file__).resolve().parents[2] / "config" / "gupta2015_case1.yaml"
PATIENCE = 60.0
ROS_ARGUMENTS = ["--ros-args", "--params-file", str(CASE1)]


def new_environment() -> Iterator[dict[str, str]]:
    """Yield variables of a process on a domain of its own."""
    lock = domain.claim_free({"test": "standalone"})
    made = environment.for_node(os.environ, lock.domain_id)
    del made[environment.SUPERVISED]
    made["PYTHONPATH"] = str(Path(__file__).resolve().parents[2])
    yield made
    lock.release()


env = pytest.fixture(new_environment, name="env")
other_env = pytest.fixture(new_environment, name="other_env")


def start(env: dict[str, str], module: str, *arguments: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", f"spacecraft_gnc.{module}", *arguments],
        env=env,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def finish(process: subprocess.Popen[str]) -> tuple[int, str, str]:
    try:
        out, err = process.communicate(timeout=PATIENCE)
    finally:
        process.kill()
    return process.returncode, out, err


def test_four_nodes_by_hand(env: dict[str, str], tmp_path: Path) -> None:
    folder = ["-p", f"storage_folder:={tmp_path / 'bag'}"]
    listeners = [
        start(env, "nodes.recorder", *ROS_ARGUMENTS, *folder),
        start(env, "nodes.reference_governor", *ROS_ARGUMENTS),
        start(env, "nodes.nmpc_controller", *ROS_ARGUMENTS),
    ]
    code, _, err = finish(start(env, "nodes.plant", *ROS_ARGUMENTS, "-p", "duration:=4.0"))
    assert code == 0, err
    for process in reversed(listeners):
        process.send_signal(signal.SIGINT)
        code, _, err = finish(process)
        assert code == 0, err
    assert len(read_flight(tmp_path / "bag").trajectory.time) == 10


def test_all_in_one_process_by_hand(env: dict[str, str], tmp_path: Path) -> None:
    arguments = ["-p", f"recorder:storage_folder:={tmp_path / 'bag'}", "-p", "plant:duration:=4.0"]
    code, _, err = finish(start(env, "nodes.composed", *ROS_ARGUMENTS, *arguments))
    assert code == 0, err
    assert len(read_flight(tmp_path / "bag").trajectory.time) == 10


@pytest.mark.parametrize(
    ("module", "arguments", "words"),
    [
        ("plant", ["-p", "duration:=-1.0"], "plant.duration: received -1"),
        ("plant", ["-p", "durations:=1.0"], "did you mean 'duration'"),
        ("nmpc_controller", ["-p", "horizon:=0"], "nmpc_controller.horizon: received 0"),
        ("recorder", ["-p", "storage_folder:=/dev/null/bag"], "/dev/null/bag"),
        ("plant", ["--ros-args", "--params-file", "missing.yaml"], "missing.yaml"),
        ("plant", ["surplus"], "surplus"),
    ],
)
def test_bad_parameters_are_one_line(
    env: dict[str, str], module: str, arguments: list[str], words: str
) -> None:
    code, _, err = finish(start(env, f"nodes.{module}", *ROS_ARGUMENTS, *arguments, "--"))
    assert code == 2, err
    errors = [line for line in err.splitlines() if line.startswith("error: ")]
    assert len(errors) == 1, err
    assert words in errors[0]
    assert "Traceback" not in err


def test_a_node_ends_with_its_launcher(env: dict[str, str]) -> None:
    env[environment.SUPERVISED] = "1"
    process = subprocess.Popen(
        [sys.executable, "-m", "spacecraft_gnc.nodes.reference_governor", *ROS_ARGUMENTS],
        env=env,
        stdin=subprocess.PIPE,
    )
    assert process.stdin is not None
    process.stdin.close()
    assert process.wait(PATIENCE) == 0


def test_inspect_says_what_is_missing(env: dict[str, str], other_env: dict[str, str]) -> None:
    echo = start(env, "cli.main", "inspect", "echo", "nothing")
    nodes = start(other_env, "cli.main", "inspect", "nodes")  # both wait for what may still appear
    code, out, err = finish(echo)
    assert (code, out) == (1, "")
    assert err.startswith("error: /nothing: no such topic on ROS_DOMAIN_ID=")
    code, _, err = finish(nodes)
    assert code == 1
    assert "gnc launch" in err


def test_slew_wants_one_target(env: dict[str, str]) -> None:
    for arguments in ([], ["--axis", "0", "0", "1"], ["--axis", "0", "0", "0", "--angle-deg", "1"]):
        code, _, err = finish(start(env, "cli.main", "slew", *arguments))
        assert code == 2
        assert err.startswith("error: ")
        assert err.count("\n") == 1
