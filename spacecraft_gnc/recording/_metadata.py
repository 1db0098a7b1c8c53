"""The ``metadata.yaml`` that makes a folder a finished rosbag2 bag.

Source: rosbag2 (Jazzy), ``rosbag2_storage/yaml.hpp``, bag version 9.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import yaml

METADATA_NAME = "metadata.yaml"
ROSBAG2_RECORD = "rosbag2"
"""MCAP metadata record that holds the same."""
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
        """Return the mapping under ``rosbag2_bagfile_information``."""
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
        lost = {f"messages_lost {topic.name}": topic.lost for topic in self.topics if topic.lost}
        return {key: str(n) for key, n in {"messages_lost": sum(lost.values()), **lost}.items()}


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


def write_metadata(folder: Path, summary: BagSummary) -> None:
    """Write ``folder``/metadata.yaml in one step: it is there complete or not at all."""
    temporary = folder / f".{METADATA_NAME}.tmp"
    try:
        with temporary.open("w", encoding="utf-8") as stream:
            stream.write(dump({"rosbag2_bagfile_information": summary.information()}))
            stream.flush()
            os.fsync(stream.fileno())
        temporary.replace(folder / METADATA_NAME)
    except OSError:
        temporary.unlink(missing_ok=True)
        raise
