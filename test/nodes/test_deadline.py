"""A process whose end hangs where Python cannot help leaves all the same, with its exit code."""

from __future__ import annotations

import subprocess
import sys

import pytest

# PyDLL keeps the interpreter's lock: no Python thread and no signal handler can run meanwhile.
HANGS = """
import ctypes, sys
from spacecraft_gnc.nodes._deadline import end_within
end_within(0.1, int(sys.argv[1]))
ctypes.PyDLL(None).sleep(1000)
"""


@pytest.mark.parametrize("code", [0, 1, 2])
def test_who_hangs_with_the_interpreter_locked_ends_with_its_code(code: int) -> None:
    words = [sys.executable, "-c", HANGS, str(code)]
    assert subprocess.run(words, timeout=60.0, check=False).returncode == code


def test_who_ends_in_time_is_left_alone() -> None:
    words = [sys.executable, "-c", HANGS.replace("0.1", "500.5").replace("sleep(1000)", "abs(0)")]
    assert subprocess.run([*words, "7"], timeout=60.0, check=False).returncode == 0
