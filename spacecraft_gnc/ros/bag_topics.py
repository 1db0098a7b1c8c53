"""What a bag has to know about the topics of the graph."""

from __future__ import annotations

import os
import struct
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)
from rclpy.utilities import get_rmw_implementation_identifier

from spacecraft_gnc.recording.qos import QosProfile, qos_yaml
from spacecraft_gnc.recording.schema_text import InstalledInterfaces, schema_text
from spacecraft_gnc.recording.writer import BagWriter
from spacecraft_gnc.ros.parameters import parameter_files
from spacecraft_gnc.scenario import Scenario
from spacecraft_gnc.scenario.provenance import version_of

if TYPE_CHECKING:  # it imports every message of the graph; `gnc inspect` must not need them
    from spacecraft_gnc.ros.topics import Topic

_STAMP = struct.Struct("<iI")
_STAMP_AT = 4  # after the encapsulation header
_STAMPED_FIRST = ("std_msgs/Header", "builtin_interfaces/Time")
_NS_PER_S = 1_000_000_000
_WHEEL = "ros-jazzy-rclpy"  # as PyPI has it; ROS 2 itself calls it rclpy


def announce(
    bag: BagWriter, name: str, message_type: Any, offered: Iterable[QoSProfile], *, gapless: bool
) -> None:
    """Add a topic to a bag, with its definition as installed on this machine.

    Parameters
    ----------
    bag
        Where to.
    name
        Full name.
    message_type
        Python class of its messages.
    offered
        Profiles of its publishers.
    gapless
        Whether a control step without a message is a loss.

    Raises
    ------
    RecordingError
        If the definition is not installed.
    """
    type_name = f"{message_type.__module__.split('.')[0]}/msg/{message_type.__name__}"
    interfaces = InstalledInterfaces(prefixes())
    bag.add_topic(
        name,
        type_name,
        schema_text(type_name, interfaces.definition),
        qos_yaml=qos_yaml(*(_profile(qos) for qos in offered)),
        type_hash=interfaces.type_hash(type_name),
        gapless=gapless,
    )


def message_time(topic: Topic) -> Callable[[bytes], int] | None:
    """Return a function that reads the stamp [ns] of a serialized message; None: it has none."""
    return _read_stamp if is_stamped(topic.type) else None


def is_stamped(message_type: Any) -> bool:
    """Tell whether serialized messages of a class begin with a time stamp."""
    return next(iter(message_type.get_fields_and_field_types().values()), "") in _STAMPED_FIRST


def scenario_text(scenario: Scenario) -> bytes:
    """Return the parameter file that flies, comments and all; without one, its contents."""
    files = list(parameter_files(sys.argv))
    return files[0].read_bytes() if len(files) == 1 else scenario.to_yaml().encode()


def middleware() -> dict[str, str]:
    """Return versions that only a node knows."""
    return {
        "rclpy": version_of(_WHEEL) or version_of("rclpy"),
        "rmw": get_rmw_implementation_identifier(),
    }


def _read_stamp(data: bytes) -> int:
    seconds, nanoseconds = _STAMP.unpack_from(data, _STAMP_AT)
    return int(seconds * _NS_PER_S + nanoseconds)


def prefixes() -> list[Path]:
    """Install prefixes: sourced workspaces, then the environment of this interpreter."""
    listed = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    return [Path(entry) for entry in (*listed, sys.prefix) if entry]


def _profile(qos: QoSProfile) -> QosProfile:
    return QosProfile(
        history=HistoryPolicy(qos.history).name.lower(),
        depth=qos.depth,
        reliability=ReliabilityPolicy(qos.reliability).name.lower(),
        durability=DurabilityPolicy(qos.durability).name.lower(),
        liveliness=_LIVELINESS.get(qos.liveliness, "automatic"),
        **_durations(qos),
    )


def _durations(qos: QoSProfile) -> dict[str, Any]:
    """Return the times [ns] that a profile sets; rclpy has 0 or a huge number for "infinite"."""
    times = {
        "deadline_ns": qos.deadline,
        "lifespan_ns": qos.lifespan,
        "liveliness_lease_ns": qos.liveliness_lease_duration,
    }
    return {name: t.nanoseconds for name, t in times.items() if 0 < t.nanoseconds < _NEVER}


_NEVER = 2**62  # [ns]
_LIVELINESS = {LivelinessPolicy.MANUAL_BY_TOPIC: "manual_by_topic"}
