"""What a node process leaves when its nodes have ended."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from spacecraft_gnc.launcher import domain
from spacecraft_gnc.launcher.environment import for_node

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
    assert (ended.returncode, ended.stderr) == (0, "")
