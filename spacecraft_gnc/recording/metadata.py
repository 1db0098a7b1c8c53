"""The ``metadata.yaml`` that makes a folder a finished rosbag2 bag.

Source: rosbag2 (Jazzy), ``rosbag2_storage/yaml.hpp``, bag version 9.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, NamedTuple

import yaml

METADATA_NAME: Final = "metadata.yaml"
INFORMATION: Final = "rosbag2_bagfile_information"
"""The one key in it."""
ROSBAG2_RECORD: Final = "rosbag2"
"""MCAP metadata record that holds the same."""
LOSSES_RECORD: Final = "losses"
"""MCAP metadata record: messages known to be lost, by topic."""
RECOVERED_RECORD: Final = "recovered"
"""MCAP metadata record of a bag that was rebuilt: from what, by what, and what it lacks."""
GAPLESS: Final = "gapless"
"""Key in the metadata of an MCAP channel: whether a control step without a message is a loss."""
DISTRO: Final = "jazzy"
_LOST: Final = "messages_lost"
_VERSION = 9
_MAX_STAMP = 2**63 - 1


class TopicSummary(NamedTuple):
    """What metadata.yaml says of one topic."""

    name: str
    type_name: str
    qos_yaml: str
    type_hash: str
    message_count: int
    lost: int = 0
    """Messages known to be lost."""


class BagSummary(NamedTuple):
    """What metadata.yaml says of one bag of one file."""

    file_name: str
    start_ns: int
    """Log time of the earliest message [ns]."""
    end_ns: int
    """Log time of the latest message [ns]."""
    topics: Sequence[TopicSummary]
    ros_distro: str
    marks: Mapping[str, str] = MappingProxyType({})
    """More that is to be known at a glance."""

    def information(self) -> dict[str, object]:
        """Return the mapping under `INFORMATION`."""
        count = sum(topic.message_count for topic in self.topics)
        # An empty bag starts at the largest stamp, as rosbag2 has it.
        start = {"nanoseconds_since_epoch": self.start_ns if count else _MAX_STAMP}
        duration = {"nanoseconds": self.end_ns - self.start_ns if count else 0}
        return {
            "version": _VERSION,
            "storage_identifier": "mcap",
            "duration": duration,
            "starting_time": start,
            "message_count": count,
            "topics_with_message_count": [_topic_entry(topic) for topic in self.topics],
            "compression_format": "",  # chunks are compressed inside MCAP, the bag's files are not
            "compression_mode": "",
            "relative_file_paths": [self.file_name],
            "files": [
                {
                    "path": self.file_name,
                    "starting_time": dict(start),
                    "duration": dict(duration),
                    "message_count": count,
                }
            ],
            "custom_data": self._losses() | dict(self.marks),
            "ros_distro": self.ros_distro,
        }

    def _losses(self) -> dict[str, str]:
        """Return what the bag lacks, as rosbag2 wants it: text by key."""
        lost = {f"{_LOST} {topic.name}": topic.lost for topic in self.topics if topic.lost}
        return {key: str(n) for key, n in {_LOST: sum(lost.values()), **lost}.items()}


def _topic_entry(topic: TopicSummary) -> dict[str, object]:
    return {
        "topic_metadata": {
            "name": topic.name,
            "type": topic.type_name,
            "serialization_format": "cdr",
            "offered_qos_profiles": yaml.safe_load(topic.qos_yaml) or [],
            "type_description_hash": topic.type_hash,
        },
        "message_count": topic.message_count,
    }


def dump(mapping: dict[str, object]) -> str:
    """Return YAML text in the order of ``mapping``."""
    return yaml.safe_dump(mapping, sort_keys=False)


def read_counts(folder: Path) -> dict[str, int] | None:
    """Return the number of messages by topic; None of a bag that is not closed."""
    about = _information(folder)
    if about is None:
        return None
    entries = about["topics_with_message_count"]
    return {entry["topic_metadata"]["name"]: entry["message_count"] for entry in entries}


def _information(folder: Path) -> dict[str, Any] | None:
    try:
        text = (folder / METADATA_NAME).read_text(encoding="utf-8")
    except OSError:
        return None
    return dict(yaml.safe_load(text)[INFORMATION])


def read_losses(folder: Path) -> dict[str, int]:
    """Return the messages known to be lost by topic; none of a bag that is not closed."""
    told = (_information(folder) or {}).get("custom_data") or {}
    words = ((key.split(" "), value) for key, value in told.items())
    return {key[1]: int(lost) for key, lost in words if key[0] == _LOST and len(key) == 2}


def write_metadata(folder: Path, summary: BagSummary) -> None:
    """Write ``folder``/metadata.yaml in one step: it is there complete or not at all."""
    temporary = folder / f".{METADATA_NAME}.tmp"
    try:
        with temporary.open("w", encoding="utf-8") as stream:
            stream.write(dump({INFORMATION: summary.information()}))
            stream.flush()
            os.fsync(stream.fileno())
        temporary.replace(folder / METADATA_NAME)
    except OSError:
        temporary.unlink(missing_ok=True)
        raise
