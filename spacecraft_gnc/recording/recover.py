"""Save what is whole of an MCAP file that was cut off: by a crash, a kill or a full disk."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from pathlib import Path
from struct import Struct
from typing import IO, Final

from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import CompressionType, Writer

MAGIC: Final = b"\x89MCAP0\r\n"
_RECORD_HEAD = Struct("<BQ")  # opcode, length of the content
_LAST_OPCODES = (Opcode.DATA_END, Opcode.FOOTER)


def rewrite(source: Path, target: Path) -> int:
    """Copy every whole message, attachment and metadata record of an MCAP file into a new one.

    Parameters
    ----------
    source
        Finished or cut off.
    target
        Indexed MCAP file, created or replaced.

    Returns
    -------
    int
        Messages saved.
    """
    with source.open("rb") as stream, target.open("wb") as output:
        writer = Writer(output, compression=CompressionType.ZSTD)
        writer.start(profile="ros2", library="spacecraft_gnc, recovered")
        copy = Copy(writer)
        for record in WholeRecords(stream):
            copy.add(record)
        writer.finish()  # type: ignore[no-untyped-call]
    return copy.messages


class WholeRecords:
    """The records of the data section up to the first that is cut off.

    Damaged chunks are left out, and messages of a topic that no record before them names.

    Iterate over it once; what is said of the damage holds afterwards.

    Parameters
    ----------
    stream
        An MCAP file, finished or cut off.
    """

    def __init__(self, stream: IO[bytes]) -> None:
        self._stream = stream
        self.size = stream.seek(0, 2)
        """Of the file [bytes]."""
        self._end, is_complete = _whole_length(stream, self.size)
        self.cut = 0 if is_complete else self.size - self._end
        """Bytes after the last whole record."""
        self.damaged_chunks = 0
        self.orphans = 0
        """Messages left out, for no record before them tells their topic."""

    def __iter__(self) -> Iterator[McapRecord]:
        """Yield the records; those of a chunk one by one."""
        channels: set[int] = set()
        for record in self._records():
            if isinstance(record, Channel):
                channels.add(record.id)
            if isinstance(record, Message) and record.channel_id not in channels:
                self.orphans += 1
            else:
                yield record

    def _records(self) -> Iterator[McapRecord]:
        stream = self._stream
        if stream.seek(len(MAGIC)) == self._end:
            return
        for record in StreamReader(stream, skip_magic=True, emit_chunks=True).records:
            if isinstance(record, Chunk):
                yield from self._of_chunk(record)
            else:
                yield record
            if stream.tell() >= self._end:
                return

    def _of_chunk(self, chunk: Chunk) -> list[McapRecord]:
        try:
            return breakup_chunk(chunk, validate_crc=True)
        except Exception:  # noqa: BLE001  # a torn chunk makes the decompressor raise its own errors
            self.damaged_chunks += 1
            return []


def _whole_length(stream: IO[bytes], size: int) -> tuple[int, bool]:
    """Return the offset where the last whole record of the data section ends, and if all are."""
    position = len(MAGIC)
    while position + _RECORD_HEAD.size <= size:
        stream.seek(position)
        opcode, length = _RECORD_HEAD.unpack(stream.read(_RECORD_HEAD.size))
        if opcode in _LAST_OPCODES:
            return position, True
        following = position + _RECORD_HEAD.size + length
        # Blocks that a power cut left unwritten read as zeros: no record has opcode 0.
        if opcode == 0 or following > size:
            break
        position = following
    return position, False


class Copy:
    """Feeds records into a writer, with the writer's own identifiers."""

    def __init__(self, writer: Writer) -> None:
        self._writer = writer
        self._known: dict[tuple[str, int], int] = {}
        self.messages = 0
        self.begin_file()

    def begin_file(self) -> None:
        """Forget the identifiers of the last file: they hold within one."""
        self._schema_ids: dict[int, int] = {0: 0}
        self._channel_ids: dict[int, int] = {}

    def add(self, record: McapRecord) -> None:
        """Copy one record; indexes are left to the writer."""
        match record:
            case Schema() if record.id not in self._schema_ids:
                self._schema_ids[record.id] = self._schema(record)
            case Channel() if record.id not in self._channel_ids:
                self._channel_ids[record.id] = self._channel(record)
            case Message():
                self._writer.add_message(
                    self._channel_ids[record.channel_id],
                    record.log_time,
                    record.data,
                    record.publish_time,
                    record.sequence,
                )
                self.messages += 1
            case Attachment():
                self._writer.add_attachment(
                    record.create_time, record.log_time, record.name, record.media_type, record.data
                )
            case Metadata():
                self._writer.add_metadata(record.name, record.metadata)

    def _schema(self, schema: Schema) -> int:
        key = schema.name, zlib.crc32(schema.data)
        if key not in self._known:
            self._known[key] = self._writer.register_schema(
                schema.name, schema.encoding, schema.data
            )
        return self._known[key]

    def _channel(self, channel: Channel) -> int:
        schema_id = self._schema_ids.get(channel.schema_id, 0)  # 0: without a definition
        key = channel.topic, schema_id
        if key not in self._known:
            self._known[key] = self._writer.register_channel(
                channel.topic, channel.message_encoding, schema_id, channel.metadata
            )
        return self._known[key]
