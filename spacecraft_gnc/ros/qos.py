"""Quality of service: from plain data to rclpy's profile and back."""

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

from spacecraft_gnc.signals.qos import INFINITE_NS, QosProfile

_MANUAL: Final = "manual_by_topic"
_NEVER: Final = 2**62  # [ns]


def ros_qos(qos: QosProfile) -> QoSProfile:
    """Return a profile as rclpy has it."""
    return QoSProfile(
        history=HistoryPolicy[qos.history.upper()],
        depth=qos.depth,
        reliability=ReliabilityPolicy[qos.reliability.upper()],
        durability=DurabilityPolicy[qos.durability.upper()],
        deadline=_duration(qos.deadline_ns),
        lifespan=_duration(qos.lifespan_ns),
        liveliness=(
            LivelinessPolicy.MANUAL_BY_TOPIC
            if qos.liveliness == _MANUAL
            else LivelinessPolicy.AUTOMATIC
        ),
        liveliness_lease_duration=_duration(qos.liveliness_lease_ns),
    )


def plain_qos(qos: QoSProfile) -> QosProfile:
    """Return a profile of rclpy as plain data."""
    is_manual = qos.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC
    return QosProfile(
        history=HistoryPolicy(qos.history).name.lower(),
        depth=qos.depth,
        reliability=ReliabilityPolicy(qos.reliability).name.lower(),
        durability=DurabilityPolicy(qos.durability).name.lower(),
        liveliness=_MANUAL if is_manual else "automatic",
        **_durations(qos),
    )


def _duration(nanoseconds: int) -> Duration:
    return Duration(nanoseconds=0 if nanoseconds >= INFINITE_NS else nanoseconds)


def _durations(qos: QoSProfile) -> dict[str, Any]:
    """Return the times [ns] that a profile sets; rclpy has 0 or a huge number for "infinite"."""
    times = {
        "deadline_ns": qos.deadline,
        "lifespan_ns": qos.lifespan,
        "liveliness_lease_ns": qos.liveliness_lease_duration,
    }
    return {name: t.nanoseconds for name, t in times.items() if 0 < t.nanoseconds < _NEVER}
