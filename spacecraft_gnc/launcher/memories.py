"""Memory of the nodes that may be restarted: of this launch alone, and without a name anywhere."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Final

from spacecraft_gnc.launcher.environment import MEMORY
from spacecraft_gnc.signals.graph import CONTROLLER, GOVERNOR
from spacecraft_gnc.signals.members import role_of

_ROLES: Final = (CONTROLLER, GOVERNOR)


class Memories:
    """Anonymous files, one for each controller and governor; they end with their last holder.

    Parameters
    ----------
    restart : bool
        Whether dead nodes are restarted; else nobody needs a memory.
    """

    def __init__(self, restart: bool) -> None:
        self._restart = restart and hasattr(os, "memfd_create")
        self._files: dict[str, int] = {}

    def of(self, name: str, environment: Mapping[str, str]) -> tuple[dict[str, str], list[int]]:
        """Return the environment of a node's process, and the descriptors that it inherits."""
        if not self._restart or role_of(name) not in _ROLES:
            return dict(environment), []
        if name not in self._files:
            self._files[name] = os.memfd_create(name.replace("/", "."))
        descriptor = self._files[name]
        return {**environment, MEMORY: str(descriptor)}, [descriptor]

    def close(self) -> None:
        """Give the files back."""
        while self._files:
            os.close(self._files.popitem()[1])
