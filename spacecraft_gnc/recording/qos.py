"""Quality-of-service profiles as rosbag2 stores them, without rclpy."""

from __future__ import annotations

from typing import NamedTuple

import yaml

_NS_PER_S = 1_000_000_000
INFINITE_NS = 9_223_372_036 * _NS_PER_S + 854_775_807
"""Duration that rmw calls infinite [ns]: deadline, lifespan and lease of a profile without one."""


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


def qos_yaml(*profiles: QosProfile) -> str:
    """Return the text of ``offered_qos_profiles`` (bag version 9) for the publishers of a topic.

    Returns
    -------
    str
        A YAML list; empty text without a profile, which players take as the default profile.
    """
    if not profiles:
        return ""
    return yaml.safe_dump([_as_mapping(profile) for profile in profiles], sort_keys=False).strip()


def _as_mapping(profile: QosProfile) -> dict[str, object]:
    return {
        "history": profile.history,
        "depth": profile.depth,
        "reliability": profile.reliability,
        "durability": profile.durability,
        "deadline": _as_time(profile.deadline_ns),
        "lifespan": _as_time(profile.lifespan_ns),
        "liveliness": profile.liveliness,
        "liveliness_lease_duration": _as_time(profile.liveliness_lease_ns),
        "avoid_ros_namespace_conventions": profile.avoid_ros_namespace_conventions,
    }


def _as_time(nanoseconds: int) -> dict[str, int]:
    seconds, rest = divmod(nanoseconds, _NS_PER_S)
    return {"sec": seconds, "nsec": rest}
