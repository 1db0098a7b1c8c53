"""What a node process leaves when its nodes have ended."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from spacecraft_gnc.launcher import domain
from spacecraft_gnc.launcher.environment import LOG, for_node
from spacecraft_gnc.launcher.process import NodeProcess

CASE1 = Path(__file__).resolve().parents[2] / "config" / "gupta2015_case1.yaml"
RUN_AND_LOOK = """
import os, signal, sys
from pathlib import Path
from spacecraft_gnc.nodes._runner import run
from spacecraft_gnc.nodes.recorder import RecorderNode

def threads():
    names = (task / "comm" for task in Path("/proc/self/task").iterdir())
    return [name.read_text().strip() for name in names]

class Node(RecorderNode):
    def start(self):
        super().start()
        print("flying:", sum(name.startswith("dds") for name in threads()))
        os.kill(os.getpid(), signal.SIGTERM)

code = run(Node, arguments=sys.argv)
print("ended:", sum(name.startswith("dds") for name in threads()))
sys.exit(code)
"""


def test_no_thread_of_dds_is_left_to_the_end_of_python(tmp_path: Path) -> None:
    lock = domain.claim_free({"test": "runner"})
    arguments = ["recorder", "--ros-args", "--params-file", str(CASE1)]
    arguments += ["-p", f"storage_folder:={tmp_path / 'bag'}"]
    ended = subprocess.run(
        [sys.executable, "-c", RUN_AND_LOOK, *arguments[1:]],
        env=for_node(os.environ, lock.domain_id),
        stdin=subprocess.PIPE,
        capture_output=True,
        text=True,
        timeout=60.0,
        check=False,
    )
    lock.release()
    flying, after = (line.split(": ")[1] for line in ended.stdout.splitlines())
    assert int(flying) > 0
    assert after == "0"
    assert ended.returncode == 0, ended.stderr


def test_a_node_that_was_never_configured_ends_well(tmp_path: Path) -> None:
    """As the governor does when another node was refused."""
    lock = domain.claim_free({"test": "runner"})
    command = [sys.executable, "-m", "spacecraft_gnc.nodes.reference_governor", "--ros-args"]
    command += ["--params-file", str(CASE1), "-p", "autostart:=false"]
    ended = subprocess.run(  # the end of its standard input ends it
        command,
        env=for_node(os.environ, lock.domain_id),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=60.0,
        check=False,
    )
    lock.release()
    assert ended.returncode == 0
    assert "error" not in ended.stderr.lower()


HANGING = """
import ctypes, sys, threading
from spacecraft_gnc.nodes._runner import run
from spacecraft_gnc.nodes.recorder import RecorderNode

place = sys.argv.pop(1)
endless = threading.Event()

def stuck_here(*_):
    print("stuck", flush=True)
    endless.wait()

class Node(RecorderNode):
    destroy_node = stuck_here if place == "destruction" else RecorderNode.destroy_node
    on_shutdown = stuck_here if place == "shutdown" else RecorderNode.on_shutdown

    def start(self):
        super().start()
        print("up", flush=True)

if place == "thread":
    threading.Thread(target=stuck_here).start()
if place == "library":
    libc = ctypes.CDLL(None)
    libc.__cxa_atexit(libc.pause, None, None)
sys.exit(run(Node))
"""


def reached(node: NodeProcess, word: str) -> None:
    while word not in node.last_output():
        assert node.exit_code is None, node.last_output()


def ended_by_its_launcher(place: str, folder: Path) -> NodeProcess:
    """Return a node that was told to end while its function ``stuck_here`` waits somewhere."""
    lock = domain.claim_free({"test": "runner"})
    arguments = ["-c", HANGING, place, "--ros-args", "--params-file", str(CASE1)]
    arguments += ["-p", f"storage_folder:={folder / 'bag'}"]
    environment = for_node(os.environ, lock.domain_id)
    node = NodeProcess("recorder", arguments, environment, folder / "log")
    reached(node, "up")
    node.end()
    if place != "library":
        reached(node, "stuck")
    node.join(0.1 if place in ("shutdown", "thread") else 30.0)
    lock.release()
    return node


@pytest.mark.parametrize("place", ["shutdown", "thread"])
def test_a_node_that_hangs_leaves_its_stacks(tmp_path: Path, place: str) -> None:
    node = ended_by_its_launcher(place, tmp_path)
    assert node.exit_code == -signal.SIGKILL
    words = node.last_output()
    title = next(i for i, line in enumerate(words) if line.endswith("its threads:"))
    assert any("in stuck_here" in line for line in words[title:])


def test_a_node_that_hangs_where_it_gives_up_dds_leaves_its_stacks_and_ends(
    tmp_path: Path,
) -> None:
    node = ended_by_its_launcher("destruction", tmp_path)
    assert node.exit_code == 0
    assert any("in stuck_here" in line for line in node.last_output())


def test_what_would_hang_after_python_has_ended_is_not_waited_for(tmp_path: Path) -> None:
    """There no stack can be told any more: the signal that asks for it ends the process."""
    node = ended_by_its_launcher("library", tmp_path)
    assert node.exit_code == 0
    assert node.last_output()[0] == "up"


ORDERLY = """
import sys
from spacecraft_gnc.nodes._runner import run
from spacecraft_gnc.nodes.recorder import RecorderNode

class Node(RecorderNode):
    def start(self):
        super().start()
        print("up", flush=True)

    def on_shutdown(self, state):
        print("ends", flush=True)
        return super().on_shutdown(state)

sys.exit(run(Node))
"""


def test_a_node_whose_launcher_was_killed_ends_in_order_and_says_so(tmp_path: Path) -> None:
    lock = domain.claim_free({"test": "runner"})
    log = tmp_path / "log"
    arguments = ["--ros-args", "--params-file", str(CASE1)]
    arguments += ["-p", f"storage_folder:={tmp_path / 'bag'}"]
    node = subprocess.Popen(
        [sys.executable, "-c", ORDERLY, *arguments],
        env=for_node(os.environ, lock.domain_id) | {LOG: str(log)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )
    assert node.stdin is not None
    assert node.stdout is not None
    assert node.stdout.readline() == b"up\n"
    node.stdout.close()  # what a launcher that is killed leaves behind
    node.stdin.close()
    assert node.wait(30.0) == 0
    lock.release()
    assert log.read_text().startswith("ends\n")  # a busy machine may add where it was slow
