"""From what a bag tells of a topic to what rclpy publishes it with."""

from __future__ import annotations

from typing import Any, Final

from rclpy.duration import Duration
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)

from spacecraft_gnc.recording.playback import PlayedTopic
from spacecraft_gnc.recording.qos import INFINITE_NS, QosProfile
from spacecraft_gnc.recording.schema_text import InstalledInterfaces
from spacecraft_gnc.ros.bag_topics import prefixes
from spacecraft_gnc.ros.endpoints import message_type

_LIVELINESS: Final = {"manual_by_topic": LivelinessPolicy.MANUAL_BY_TOPIC}


class Unplayable(Exception):
    """A topic cannot be published here, and why."""


def played_type(topic: PlayedTopic) -> Any:
    """Return the installed class of a topic's messages.

    Raises
    ------
    Unplayable
        If it is not installed, or in another version than the recorded one.
    """
    try:
        found = message_type(topic.type_name)
    except ImportError:
        raise Unplayable(f"{topic.type_name} is not installed") from None
    installed = InstalledInterfaces(prefixes()).type_hash(topic.type_name)
    if installed and topic.type_hash and installed != topic.type_hash:
        raise Unplayable(f"{topic.type_name} is installed in another version than was recorded")
    return found


def ros_qos(qos: QosProfile) -> QoSProfile:
    """Return a recorded profile as rclpy has it."""
    return QoSProfile(
        history=HistoryPolicy[qos.history.upper()],
        depth=qos.depth,
        reliability=ReliabilityPolicy[qos.reliability.upper()],
        durability=DurabilityPolicy[qos.durability.upper()],
        deadline=_duration(qos.deadline_ns),
        lifespan=_duration(qos.lifespan_ns),
        liveliness=_LIVELINESS.get(qos.liveliness, LivelinessPolicy.AUTOMATIC),
        liveliness_lease_duration=_duration(qos.liveliness_lease_ns),
    )


def _duration(nanoseconds: int) -> Duration:
    return Duration(nanoseconds=0 if nanoseconds >= INFINITE_NS else nanoseconds)
