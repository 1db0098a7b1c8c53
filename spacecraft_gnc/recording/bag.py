"""Read access to a bag: rosbag2 folder, single .mcap file, or a truncated one.

What a bag holds comes from its files: topics, types, offered profiles, counts and times. Of
``metadata.yaml`` only the list of the files is used (`_files`).
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from operator import itemgetter
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final, TypeAlias

import zstandard
from mcap.opcode import Opcode
from mcap.records import Attachment, Metadata

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording import _types
from spacecraft_gnc.recording._files import BagFiles, bag_files, bag_in, damage, whole_copies
from spacecraft_gnc.recording._index import ChannelInfo, Index, read_index
from spacecraft_gnc.recording._layout import Definitions
from spacecraft_gnc.recording._scan import Block, Progress, messages, read_block
from spacecraft_gnc.recording._verify import verify
from spacecraft_gnc.recording.metadata import GAPLESS, METADATA_NAME
from spacecraft_gnc.recording.qos import parse_qos
from spacecraft_gnc.recording.schema_text import fields
from spacecraft_gnc.recording.stamps import STEPPED_START
from spacecraft_gnc.signals.qos import QosProfile

_NO_SPAN: Final = (0, -1)
_Placed: TypeAlias = tuple[int, int, int, int, str, bytes]
"""Log time, file, block, place in it, topic, message."""
_LOG_TIME: Final = itemgetter(0)
_TIMED: Final = itemgetter(0, 4, 5)


class Bag:
    """An open bag; obtain it from `open_bag`.

    Attributes
    ----------
    path
        As the user named it.
    topics
        Type of each topic of ROS 2 messages, ``pkg/msg/Type`` by full topic name.
    counts
        Messages of each recorded topic, of ROS 2 or not.
    left_out
        Why recorded messages are not read, by the full name of their topic.
    unfinished
        Whether the bag was cut off.
    span_ns
        Log times of the first and the last message [ns]; the last before the first: none.
    """

    def __init__(self, path: Path, indexes: list[Index], found: BagFiles) -> None:
        self.path = path
        self.unfinished = found.unfinished
        self.topics: dict[str, str] = {}
        self.counts: Counter[str] = Counter()
        self.left_out: dict[str, str] = {}
        self._strays = found.strays
        self._packed: bool | None = None  # whether each message is compressed; not known yet
        self._indexes = indexes
        self._channels: dict[str, list[ChannelInfo]] = {}
        for index in indexes:
            for number, channel in index.channels.items():
                self._add(channel, index.counts.get(number, 0))
        spans = [index.span_ns for index in indexes if index.span_ns is not None]
        starts, ends = [start for start, _ in spans], [end for _, end in spans]
        self.span_ns = (min(starts), max(ends)) if spans else _NO_SPAN

    def _add(self, channel: ChannelInfo, count: int) -> None:
        self.counts[channel.topic] += count
        reason = _types.foreign(channel)
        if reason:
            if count:
                self.left_out[channel.topic] = reason
            return
        self.topics.setdefault(channel.topic, channel.type_name)
        known = self._channels.setdefault(channel.topic, [])
        if channel not in known:
            known.append(channel)

    def remarks(self, left_out: Mapping[str, str] | None = None) -> list[str]:
        """Return what a reader should be told of what is not read, one line each.

        Parameters
        ----------
        left_out
            What a reader leaves out of its own, and why; None: `left_out`.
        """
        topics = self.left_out if left_out is None else left_out
        lines = [f"{self.path}: {name} is left out: {why}" for name, why in topics.items()]
        lines += [
            f"{self.path}: {name} is left out: {METADATA_NAME} does not name it"
            for name in self._strays
        ]
        return lines

    def messages(self, topics: Collection[str]) -> Iterator[tuple[str, bytes]]:
        """Yield (topic, serialized message) in the order of the log times.

        Raises
        ------
        RecordingError
            If the file is damaged.
        """
        for _, topic, data in self.timed(topics):
            yield topic, data

    def recorded(
        self, topics: Collection[str], progress: Progress | None = None
    ) -> Iterator[tuple[str, bytes]]:
        """Yield (topic, serialized message) in the order of recording, each chunk checked.

        Raises
        ------
        RecordingError
            If the file is damaged.
        """
        for index in self._indexes:
            wanted = _wanted(index, topics)
            with damage(self.path), index.path.open("rb") as stream:
                for block in index.blocks:
                    for _, topic, data in messages(read_block(stream, block), wanted):
                        yield topic, self._unpacked(data)
                    if progress is not None:
                        progress(block.offset + block.size, index.size)

    def timed(self, topics: Collection[str], from_ns: int = 0) -> Iterator[tuple[int, str, bytes]]:
        """Yield (log time [ns], topic, serialized message) in their order, from a log time on.

        Messages of one log time come in the order of recording.

        Raises
        ------
        RecordingError
            If the file is damaged.
        """
        waiting = sorted(
            (block.start_ns, place, block)
            for place, index in enumerate(self._indexes)
            for block in index.blocks
            if block.end_ns >= from_ns
        )
        pending: list[_Placed] = []
        for start_ns, place, block in waiting:
            # What comes before a block is due before the block is read.
            due = bisect_left(pending, start_ns, key=_LOG_TIME)
            yield from map(_TIMED, pending[:due])
            found = self._placed(place, block, topics)
            pending = sorted([*pending[due:], *(item for item in found if item[0] >= from_ns)])
        yield from map(_TIMED, pending)

    def _placed(self, place: int, block: Block, topics: Collection[str]) -> list[_Placed]:
        """Return the messages of a block, each with what puts it in its order."""
        index = self._indexes[place]
        with damage(self.path), index.path.open("rb") as stream:
            found = messages(read_block(stream, block), _wanted(index, topics))
            return [
                (time, place, block.offset, i, topic, self._unpacked(data))
                for i, (time, topic, data) in enumerate(found)
            ]

    def _unpacked(self, data: bytes) -> bytes:
        if self._packed is None:  # of a bag all messages are, or none
            self._packed = data.startswith(zstandard.FRAME_HEADER)
        return zstandard.decompress(data) if self._packed else data

    def verify(self, progress: Progress | None = None) -> None:
        """Compare every checksum in the files with what they hold.

        Raises
        ------
        RecordingError
            If a byte has changed since the bag was recorded.
        """
        for index in self._indexes:
            with damage(self.path):
                verify(index.path, progress)

    def channel(self, topic: str) -> ChannelInfo:
        """Return how a topic was recorded: type, definition with nested types behind it, encoding.

        Raises
        ------
        RecordingError
            If its messages have several types, or several versions of one.
        """
        first, *others = self._channels[topic]
        for other in others:
            if other.type_name != first.type_name:
                raise RecordingError(
                    f"{self.path}: {topic} holds messages of {first.type_name} and of "
                    f"{other.type_name}; required one type; record each into a bag of its own"
                )
            with damage(self.path):
                same = other.definition == first.definition or (
                    _types.type_hash(other) == _types.type_hash(first)
                )
            if not same:
                raise RecordingError(
                    f"{self.path}: {topic} holds messages of two versions of {first.type_name}; "
                    "required one; record each into a bag of its own"
                )
        return first

    def is_stepped(self, topic: str) -> bool:
        """Tell whether the messages of a topic carry their control step."""
        return [*fields(self._channels[topic][0].definition)][:2] == STEPPED_START

    def is_gapless(self, topic: str) -> bool:
        """Tell whether a topic has a message of each step, as far as its recorder tells."""
        return self._channels[topic][0].metadata.get(GAPLESS, "true") == "true"

    def definitions(self, topic: str) -> Definitions:
        """Return the fields of a topic's type and of those that it nests."""
        channel = self.channel(topic)
        with damage(self.path):
            return _types.typestore(channel).fielddefs

    def type_hash(self, topic: str) -> str:
        """Return the REP-2011 hash of a topic's type, computed from the definition in the bag."""
        channel = self.channel(topic)
        with damage(self.path):
            return _types.type_hash(channel)

    def decode(self, topic: str, data: bytes) -> Any:
        """Return the message object; its type comes from the definitions in the bag.

        Raises
        ------
        RecordingError
            If the message does not follow its definition.
        """
        channel = self.channel(topic)
        with damage(self.path):
            return _types.typestore(channel).deserialize_cdr(data, channel.type_name)

    def offered_qos(self, topic: str) -> list[QosProfile]:
        """Return the recorded profiles of a topic's publishers."""
        texts = [each.metadata.get("offered_qos_profiles", "") for each in self._channels[topic]]
        with damage(self.path):
            return [profile for text in texts for profile in parse_qos(text)]

    def attachments(self) -> dict[str, bytes]:
        """Return the attached files by name."""
        found = self._others(Opcode.ATTACHMENT)
        return {item.name: item.data for item in found if isinstance(item, Attachment)}

    def metadata(self) -> dict[str, dict[str, str]]:
        """Return the metadata records by name; a later record replaces an earlier one."""
        found = self._others(Opcode.METADATA)
        return {item.name: item.metadata for item in found if isinstance(item, Metadata)}

    def _others(self, opcode: int) -> list[Any]:
        with damage(self.path):
            return [item for index in self._indexes for item in index.read(opcode)]


def _wanted(index: Index, topics: Collection[str]) -> Mapping[int, str | None]:
    """Return the wanted topic of each channel of a file; None: not wanted."""
    return {
        number: channel.topic if channel.topic in topics and not _types.foreign(channel) else None
        for number, channel in index.channels.items()
    }


@contextmanager
def open_bag(path: Path | str, *, allow_unfinished: bool = False) -> Iterator[Bag]:
    """Open a bag for reading.

    Parameters
    ----------
    path
        Bag folder or .mcap file, or the folder of a run of ``gnc launch`` with a bag in it.
    allow_unfinished
        Read what is whole of a bag that was cut off, instead of refusing it.

    Raises
    ------
    RecordingError
        If there is no bag, or it is empty, cut off or damaged.
    """
    path = bag_in(Path(path))
    with ExitStack() as stack:
        found = stack.enter_context(bag_files(path))
        files = found.files
        if found.unfinished:
            if not allow_unfinished:
                raise RecordingError(
                    f"{path}: received an unfinished bag (the recorder was killed, or the file is "
                    f"cut off); required a closed one; save what is whole: gnc recover {path}"
                )
            folder = Path(stack.enter_context(TemporaryDirectory(prefix="gnc_bag_")))
            files = whole_copies(path, files, folder)
        with damage(path):
            indexes = [read_index(file) for file in files]
        yield Bag(path, indexes, found)
