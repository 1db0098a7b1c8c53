"""What a bag has to know about the topics of the graph."""

from __future__ import annotations

import os
import struct
import sys
from collections.abc import Callable
from pathlib import Path

from rclpy.qos import DurabilityPolicy, HistoryPolicy, LivelinessPolicy, ReliabilityPolicy

from spacecraft_gnc.nodes._params import parameter_files
from spacecraft_gnc.nodes._topics import Topic
from spacecraft_gnc.recording.qos import QosProfile, qos_yaml
from spacecraft_gnc.recording.schema_text import InstalledInterfaces, schema_text
from spacecraft_gnc.recording.writer import BagWriter
from spacecraft_gnc.scenario import Scenario

_STAMP = struct.Struct("<iI")
_STAMP_AT = 4  # after the encapsulation header
_STAMPED_FIRST = ("std_msgs/Header", "builtin_interfaces/Time")
_NS_PER_S = 1_000_000_000


def announce(bag: BagWriter, name: str, topic: Topic) -> None:
    """Add a topic of the graph to a bag, with its definition as installed on this machine.

    Raises
    ------
    RecordingError
        If the definition is not installed.
    """
    type_name = f"{topic.type.__module__.split('.')[0]}/msg/{topic.type.__name__}"
    interfaces = InstalledInterfaces(prefixes())
    bag.add_topic(
        name,
        type_name,
        schema_text(type_name, interfaces.definition),
        qos_yaml=qos_yaml(_offered(topic)),
        type_hash=interfaces.type_hash(type_name),
    )


def message_time(topic: Topic) -> Callable[[bytes], int] | None:
    """Return a function that reads the stamp [ns] of a serialized message; None: it has none."""
    first = next(iter(topic.type.get_fields_and_field_types().values()))
    return _read_stamp if first in _STAMPED_FIRST else None


def scenario_text(scenario: Scenario) -> bytes:
    """Return the parameter file that flies, comments and all; without one, its contents."""
    files = list(parameter_files(sys.argv))
    return files[0].read_bytes() if len(files) == 1 else scenario.to_yaml().encode()


def _read_stamp(data: bytes) -> int:
    seconds, nanoseconds = _STAMP.unpack_from(data, _STAMP_AT)
    return int(seconds * _NS_PER_S + nanoseconds)


def prefixes() -> list[Path]:
    """Install prefixes: sourced workspaces, then the environment of this interpreter."""
    listed = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    return [Path(entry) for entry in (*listed, sys.prefix) if entry]


def _offered(topic: Topic) -> QosProfile:
    qos = topic.qos
    return QosProfile(
        history=HistoryPolicy(qos.history).name.lower(),
        depth=qos.depth,
        reliability=ReliabilityPolicy(qos.reliability).name.lower(),
        durability=DurabilityPolicy(qos.durability).name.lower(),
        liveliness=_LIVELINESS[qos.liveliness],
    )


_LIVELINESS = {
    LivelinessPolicy.SYSTEM_DEFAULT: "automatic",
    LivelinessPolicy.AUTOMATIC: "automatic",
    LivelinessPolicy.MANUAL_BY_TOPIC: "manual_by_topic",
}
