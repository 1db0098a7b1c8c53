"""Types and profiles for publishing a bag's topics with rclpy."""

from __future__ import annotations

from typing import Any

from spacecraft_gnc.recording.playback import PlayedTopic
from spacecraft_gnc.recording.schema_text import InstalledInterfaces
from spacecraft_gnc.ros.bag_topics import prefixes
from spacecraft_gnc.ros.endpoints import message_type


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
