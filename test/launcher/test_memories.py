"""Memory of nodes that may be restarted: one anonymous file each, as long as the launch lives."""

from __future__ import annotations

import os
import stat

import pytest

from spacecraft_gnc.launcher.environment import MEMORY, for_node
from spacecraft_gnc.launcher.memories import Memories


def test_controllers_and_governors_have_one_each_and_keep_it() -> None:
    memories = Memories(restart=True)
    environment, inherited = memories.of("sc2/nmpc_controller", {"HOME": "/"})
    assert environment == {"HOME": "/", MEMORY: str(inherited[0])}
    about = os.fstat(inherited[0])
    assert stat.S_ISREG(about.st_mode)
    assert about.st_nlink == 0  # no name, in no folder
    assert memories.of("sc2/nmpc_controller", {})[1] == inherited
    assert memories.of("reference_governor", {})[1] != inherited
    for name in ("plant", "recorder"):
        assert memories.of(name, {"HOME": "/"}) == ({"HOME": "/"}, [])
    memories.close()
    with pytest.raises(OSError, match="Bad file descriptor"):
        os.fstat(inherited[0])


def test_without_restarts_nobody_has_a_memory() -> None:
    assert Memories(restart=False).of("nmpc_controller", {}) == ({}, [])


def test_a_memory_in_the_users_environment_is_nobodys() -> None:
    assert MEMORY not in for_node({MEMORY: "3"}, 1)
