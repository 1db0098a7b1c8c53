"""Quality of service of a topic as plain data."""

from __future__ import annotations

from typing import Final, NamedTuple

_NS_PER_S = 1_000_000_000
INFINITE_NS: Final = 9_223_372_036 * _NS_PER_S + 854_775_807
"""Duration that rmw calls infinite [ns]: deadline, lifespan and lease of a profile without one."""
TRANSIENT_LOCAL: Final = "transient_local"


class QosProfile(NamedTuple):
    """One publisher's offered profile; the policy names are those of the rmw layer."""

    history: str = "keep_last"
    """keep_last | keep_all | unknown"""
    depth: int = 10
    reliability: str = "reliable"
    """reliable | best_effort | unknown"""
    durability: str = "volatile"
    """volatile | transient_local | unknown"""
    deadline_ns: int = INFINITE_NS
    lifespan_ns: int = INFINITE_NS
    liveliness: str = "automatic"
    """automatic | manual_by_topic | unknown"""
    liveliness_lease_ns: int = INFINITE_NS
    avoid_ros_namespace_conventions: bool = False


def latched(depth: int) -> QosProfile:
    """Return a profile that also delivers the last messages to whoever joins later."""
    return QosProfile(depth=depth, durability=TRANSIENT_LOCAL)


STREAM: Final = QosProfile(depth=1000)
"""Offered for what is published every step. A reader that stalls for less than a thousand steps
loses nothing; the plant waits for the recorder long before that (`graph.RECORDER_WINDOW`)."""
RECORD: Final = QosProfile(depth=5000)
"""Asked for by the recorder."""
COMMAND: Final = QosProfile(depth=10)
EVENTS: Final = QosProfile(depth=100)
