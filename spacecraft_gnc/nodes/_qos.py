"""Quality of service that fits publishers found on the graph."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy


def matching(publishers: Iterable[Any], depth: int) -> QoSProfile:
    """Return the most demanding profile that every publisher can serve.

    Parameters
    ----------
    publishers
        Endpoints, as ``Node.get_publishers_info_by_topic`` returns them.
    depth
        Messages that a reader keeps until they are taken.
    """
    qos = QoSProfile(depth=depth)
    profiles = [info.qos_profile for info in publishers]
    if any(p.reliability != ReliabilityPolicy.RELIABLE for p in profiles):
        qos.reliability = ReliabilityPolicy.BEST_EFFORT
    if all(p.durability == DurabilityPolicy.TRANSIENT_LOCAL for p in profiles):
        qos.durability = DurabilityPolicy.TRANSIENT_LOCAL
    return qos
