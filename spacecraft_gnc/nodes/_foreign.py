"""Foreign topics: found on the live graph, of any type."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, Final

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.nodes._node import GncNode
from spacecraft_gnc.ros.endpoints import (
    TopicNameRefused,
    full_topic_name,
    matching,
    message_type,
)
from spacecraft_gnc.signals.qos import RECORD

_LOOK: Final = 0.1  # [s] wall between two looks at the graph while a topic has no publisher


class ForeignTopics:
    """Waits for the publishers of topics, and tells what they publish.

    Parameters
    ----------
    node
        Who looks.
    names
        Relative or absolute.
    on_found
        Called once for each topic, with its name, message class, profile to ask for and
        publishers; may raise RecordingError.

    Raises
    ------
    RecordingError
        If a name cannot be one of a topic.
    """

    def __init__(
        self,
        node: GncNode,
        names: Iterable[str],
        on_found: Callable[[str, Any, Any, list[Any]], None],
    ) -> None:
        self._node = node
        self._on_found = on_found
        self.waiting = [_full_name(node, name) for name in names]
        self._timer = node.every(_LOOK, self.look) if self.waiting else None

    def look(self) -> None:
        """Look for those that were not found yet."""
        if not self._node.active:
            return
        try:
            self.waiting = [name for name in self.waiting if not self._find(name)]
        except RecordingError as error:
            self._node.fail(error)
            self.waiting = []
        if not self.waiting and self._timer is not None:
            self._timer.cancel()

    def _find(self, name: str) -> bool:
        publishers = self._node.get_publishers_info_by_topic(name)
        types = sorted({info.topic_type for info in publishers})
        if not types:
            return False
        if len(types) > 1:
            raise RecordingError(
                f"{name}: received messages of several types ({', '.join(types)}); required one; "
                "end a publisher, or remove the topic from recorder.topics"
            )
        installed = _installed(name, types[0])
        qos = matching([info.qos_profile for info in publishers])
        qos.depth = RECORD.depth
        self._on_found(name, installed, qos, publishers)
        return True


def _full_name(node: GncNode, name: str) -> str:
    try:
        return full_topic_name(node, name)
    except TopicNameRefused as error:
        raise RecordingError(f"recorder.topics: received {error}") from error


def _installed(name: str, type_name: str) -> Any:
    """Return the Python class of a message type."""
    try:
        return message_type(type_name)
    except ImportError as error:
        package = type_name.partition("/")[0]
        raise RecordingError(
            f"{name}: received messages of type {type_name}; required a type that is installed; "
            f"install the package {package}, or remove the topic from recorder.topics"
        ) from error
