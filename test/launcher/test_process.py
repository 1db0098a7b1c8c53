"""Child processes, their environment, and what a killed one leaves behind."""

from __future__ import annotations

import os
import re
import signal
import time
from pathlib import Path

import pytest

from spacecraft_gnc.errors import LaunchError
from spacecraft_gnc.launcher import environment
from spacecraft_gnc.launcher.process import NodeProcess, end_all

WAIT = "import sys; print('up', flush=True); sys.stdin.read(); print('bye')"
STUBBORN = (
    "import signal, sys; signal.signal(signal.SIGTERM, signal.SIG_IGN); "
    "print('up', flush=True); sys.stdin.read()"
)

HANGING = """
import faulthandler, signal, sys
from spacecraft_gnc.launcher.environment import TELL_WHERE
signal.signal(signal.SIGTERM, signal.SIG_IGN)
faulthandler.register(TELL_WHERE)
def stuck_here():
    print('up', flush=True)
    sys.stdin.read()
stuck_here()
"""


def start(code: str, log: Path) -> NodeProcess:
    process = NodeProcess("plant", ["-c", code], os.environ, log)
    while process.last_output() != ["up"]:
        assert process.exit_code is None
    return process


def test_ends_when_asked(tmp_path: Path) -> None:
    process = start(WAIT, tmp_path / "log")
    end_all([process], 10.0)
    assert process.describe_end() == f"plant (pid {process.pid}) was killed by SIGTERM"


def test_is_killed_when_stubborn(tmp_path: Path) -> None:
    process = start(STUBBORN, tmp_path / "log")
    end_all([process], 0.1)
    assert not process.log_trouble
    assert process.exit_code in (-signal.SIGKILL, -environment.TELL_WHERE)
    assert process.describe_end().endswith("did not end within 0 s and was killed")


def test_one_that_hangs_tells_where(tmp_path: Path) -> None:
    process = start(HANGING, tmp_path / "log")
    end_all([process], 0.1)
    assert process.exit_code == -signal.SIGKILL
    words = process.last_output()
    assert re.fullmatch(r"plant: did not end within \d\.\d s; its threads:", words[1])
    assert any("in stuck_here" in line for line in words[2:])


def test_one_that_cannot_tell_where_it_hangs_is_told_of(tmp_path: Path) -> None:
    process = start(STUBBORN, tmp_path / "log")
    end_all([process], 0.1)
    assert process.exit_code == -environment.TELL_WHERE
    assert process.log.read_text().endswith(
        "its threads:\nnone of Python: it has not become a node yet, or is one no more\n"
    )


LINGERING = """
import ctypes, platform, sys, threading
threading.Thread(target=lambda: print('up', flush=True) or threading.Event().wait()).start()
sys.stdin.read()
end_of_thread = {'x86_64': 60, 'aarch64': 93}[platform.machine()]
ctypes.CDLL(None).syscall(end_of_thread, 7)
"""


def test_a_process_has_ended_although_its_last_threads_have_not(tmp_path: Path) -> None:
    process = start(LINGERING, tmp_path / "log")
    process._popen.stdin.close()
    while process.exit_code is None:
        pass
    assert process._popen.poll() is None
    assert process.join(0.0) == 7
    assert process.describe_end() == f"plant (pid {process.pid}) ended with exit code 7"
    assert process._popen.stdin.closed
    os.kill(process.pid, signal.SIGKILL)
    patience = time.monotonic() + 60.0
    while process._popen.returncode is None:  # nobody else waits for it
        assert time.monotonic() < patience, "it was never reaped"


def test_sees_the_launcher_go(tmp_path: Path) -> None:
    process = start(WAIT, tmp_path / "log")
    process._popen.stdin.close()  # what the end of the launcher does
    assert process.join(10.0) == 0
    assert process.last_output() == ["up", "bye"]
    assert process.describe_end().endswith("ended with exit code 0")


def test_errors_are_found_among_the_last_output(tmp_path: Path) -> None:
    code = "import sys; print('x'); sys.exit('error: a: received b')"
    process = NodeProcess("plant", ["-c", code], os.environ, tmp_path / "log")
    assert process.join(10.0) == 1
    assert process.errors() == ["a: received b"]


@pytest.mark.parametrize(
    ("said", "reason"),
    [
        ("x\nerror: bag: received b\nbye", "bag: received b"),
        ("[INFO] [1] [plant]: x\n[ERROR] [2] [plant]: y\nz", "[ERROR] [2] [plant]: y"),
        ("Traceback\n  File x\nrclpy._rclpy.RMWError: bad\n", "rclpy._rclpy.RMWError: bad"),
        (
            "Fatal Python error: Segmentation fault\n\nThread",
            "Fatal Python error: Segmentation fault",
        ),
        ("no Error here\n", ""),
        ("", ""),
    ],
)
def test_the_last_error_is_found(tmp_path: Path, said: str, reason: str) -> None:
    process = NodeProcess("plant", ["-c", f"print({said!r}, end='')"], os.environ, tmp_path / "log")
    process.join(10.0)
    assert process.last_error() == reason
    assert process.log.read_text() == said


@pytest.mark.parametrize("log", ["/dev/full", "/nonexistent/log"])
def test_output_is_kept_where_the_log_cannot_be_written(log: str) -> None:
    many = "for i in range(100_000): print(i)\nprint('error: no space')"
    process = NodeProcess("plant", ["-c", many], os.environ, Path(log))
    assert process.join(30.0) == 0  # nobody waits for a pipe that is full
    assert process.errors() == ["no space"]
    assert process.last_output()[-2] == "99999"
    assert process.log_trouble in {"No space left on device", "No such file or directory"}


def test_environment_of_a_node() -> None:
    made = environment.for_node({"_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1", "A": "b"}, 5)
    assert made["ROS_DOMAIN_ID"] == "5"
    assert made["A"] == "b"
    assert "_ROS_WHEELS_BOOTSTRAP_COMPLETE" not in made  # useless without LD_LIBRARY_PATH


def test_a_graph_stays_on_this_machine_unless_told_otherwise() -> None:
    made = environment.for_node({}, 5)
    profile = Path(made["FASTRTPS_DEFAULT_PROFILES_FILE"]).read_text()
    assert "<interfaceWhiteList><address>127.0.0.1</address>" in profile
    assert made["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "SYSTEM_DEFAULT"  # the profile decides
    assert environment.for_node(made, 5) == made
    assert environment.for_node({"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}, 5) == made
    farther = environment.for_node({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}, 5)
    assert farther["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "SUBNET"
    assert "127.0.0.1" not in Path(farther["FASTRTPS_DEFAULT_PROFILES_FILE"]).read_text()
    own = environment.for_node({"FASTDDS_DEFAULT_PROFILES_FILE": "mine.xml"}, 5)
    assert own["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"
    assert "FASTRTPS_DEFAULT_PROFILES_FILE" not in own


def test_domain_of_an_environment() -> None:
    assert environment.domain_id({}) == 0
    assert environment.domain_id({"ROS_DOMAIN_ID": "17"}) == 17
    for bad in ("x", "-1", "233"):
        with pytest.raises(LaunchError, match=r"required 0 to 232"):
            environment.domain_id({"ROS_DOMAIN_ID": bad})
