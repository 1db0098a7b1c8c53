"""Quality-of-service profiles as rosbag2 stores them, without rclpy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import yaml

from spacecraft_gnc.signals.qos import QosProfile

_NS_PER_S: Final = 1_000_000_000
_NUMBERED: Final = {
    "history": {1: "keep_last", 2: "keep_all"},
    "reliability": {1: "reliable", 2: "best_effort"},
    "durability": {1: "transient_local", 2: "volatile"},
    "liveliness": {1: "automatic", 3: "manual_by_topic"},
}
"""Policies as bags before version 9 number them; any other number means unknown."""
_DURATIONS: Final = {
    "deadline": "deadline_ns",
    "lifespan": "lifespan_ns",
    "liveliness_lease_duration": "liveliness_lease_ns",
}


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


def parse_qos(text: str) -> list[QosProfile]:
    """Return the profiles in a text of ``offered_qos_profiles``, of any bag version.

    What an entry does not tell is as in the default profile.

    Raises
    ------
    ValueError
        If it is no list of profiles.
    """
    entries = yaml.safe_load(text) if text else None
    if not isinstance(entries or [], list) or not all(isinstance(e, dict) for e in entries or []):
        raise ValueError(f"offered_qos_profiles: received {text[:40]!r}, no list of profiles")
    return [_profile(entry) for entry in entries or []]


def _profile(entry: Mapping[str, Any]) -> QosProfile:
    told: dict[str, Any] = {}
    for name, numbered in _NUMBERED.items():
        if name in entry:
            value = entry[name]
            told[name] = numbered.get(value, "unknown") if isinstance(value, int) else str(value)
    for name, field in _DURATIONS.items():
        if name in entry:
            time = entry[name]
            told[field] = int(time["sec"]) * _NS_PER_S + int(time["nsec"])
    if "depth" in entry:
        told["depth"] = int(entry["depth"])
    return QosProfile(**told)


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
