"""Past of a node's core, where the launcher may have to restart the node."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

from spacecraft_gnc.launcher.environment import MEMORY
from spacecraft_gnc.loop.memory_file import Inputs, MemoryFile
from spacecraft_gnc.loop.past import Past
from spacecraft_gnc.nodes._node import GncNode


def past_of(
    node: GncNode, core: Any, again: Callable[[Inputs], object], before: Past | None
) -> Past | None:
    """Return the past of a node's core; None: nobody would restart the node.

    Parameters
    ----------
    node : GncNode
    core : Controller or Governor
    again : callable
        Answers a step anew, from its messages.
    before : Past, optional
        What this process had already: a node that is configured anew begins anew.
    """
    descriptor = os.environ.get(MEMORY)
    if descriptor is None:
        return None
    try:
        file = MemoryFile(int(descriptor))
    except (OSError, ValueError) as error:
        node.get_logger().warning(f"{MEMORY}={descriptor}: {error}; nothing outlives this process")
        return None

    def tell(text: str, is_warning: bool) -> None:
        logger = node.get_logger()
        (logger.warning if is_warning else logger.info)(text)

    past = Past(core, file, again, tell)
    if before is not None:
        past.begin()
    return past
