"""Index of one MCAP file: channels, message counts, time range, positions.

A file whose summary lists its channels and counts its messages is believed; of any other, the
records themselves are read.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import IO, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Attachment, Channel, Metadata, Schema
from mcap.records import Statistics as Summary

from spacecraft_gnc.recording._scan import (
    MESSAGE_HEAD,
    Block,
    Record,
    read_block,
    records,
    walk,
)


class ChannelInfo(NamedTuple):
    """One channel of a file."""

    topic: str
    type_name: str
    """Empty where it has no schema."""
    encoding: str
    """Of its messages: ``cdr``, ``json`` ..."""
    schema_encoding: str
    """Of its definition: ``ros2msg``, ``ros2idl``, ``jsonschema`` ...; empty: it has none."""
    definition: str
    metadata: Mapping[str, str]


class Index(NamedTuple):
    """Contents of a file."""

    path: Path
    size: int
    """Of the file [bytes]."""
    channels: Mapping[int, ChannelInfo]
    """By their ids in this file."""
    counts: Mapping[int, int]
    """Messages by channel id."""
    span_ns: tuple[int, int] | None
    """Log times of the earliest and the latest message [ns]; None without a message."""
    blocks: tuple[Block, ...]
    others: tuple[Record, ...]

    def read(self, opcode: int) -> list[Attachment | Metadata]:
        """Return the attachments or the metadata records, in the order of recording."""
        with self.path.open("rb") as stream:
            return [_read(stream, record) for record in self.others if record.opcode == opcode]


def read_index(path: Path) -> Index:
    """Look through a finished MCAP file.

    Raises
    ------
    Exception
        Whatever damaged bytes make the parser raise.
    """
    with path.open("rb") as stream:
        parts = list(walk(stream))
        blocks = tuple(part for part in parts if isinstance(part, Block))
        others = tuple(part for part in parts if isinstance(part, Record))
        told = _summary(stream)
        schemas, channels, counts, span = told if told is not None else _contents(stream, blocks)
    infos = {number: _info(channel, schemas) for number, channel in channels.items()}
    return Index(path, path.stat().st_size, infos, counts, span, blocks, others)


_Contents = tuple[
    Mapping[int, Schema], Mapping[int, Channel], Mapping[int, int], "tuple[int, int] | None"
]


def _summary(stream: IO[bytes]) -> _Contents | None:
    """Return what the summary tells; None where it does not tell all."""
    stream.seek(0)
    summary = make_reader(stream).get_summary()
    statistics: Summary | None = None if summary is None else summary.statistics
    if summary is None or statistics is None:
        return None
    counts = {k: count for k, count in statistics.channel_message_counts.items() if count}
    whole = (
        len(summary.channels) == statistics.channel_count
        and sum(counts.values()) == statistics.message_count
        and counts.keys() <= summary.channels.keys()
        and {c.schema_id for c in summary.channels.values()} <= {0, *summary.schemas}
    )
    if not whole:
        return None
    span = (statistics.message_start_time, statistics.message_end_time) if counts else None
    return summary.schemas, summary.channels, counts, span


def _contents(stream: IO[bytes], blocks: tuple[Block, ...]) -> _Contents:
    """Read every record of the data section."""
    schemas: dict[int, Schema] = {}
    channels: dict[int, Channel] = {}
    counts: Counter[int] = Counter()
    first, last = 2**64, -1
    for block in blocks:
        data = read_block(stream, block)
        for opcode, start, end in records(data):
            if opcode == Opcode.MESSAGE:
                number, _, log_time, _ = MESSAGE_HEAD.unpack_from(data, start)
                counts[number] += 1
                first, last = min(first, log_time), max(last, log_time)
            elif opcode == Opcode.SCHEMA:
                schema = Schema.read(ReadDataStream(BytesIO(data[start:end])))
                schemas[schema.id] = schema
            elif opcode == Opcode.CHANNEL:
                channel = Channel.read(ReadDataStream(BytesIO(data[start:end])))
                channels[channel.id] = channel
    return schemas, channels, counts, (first, last) if counts else None


def _info(channel: Channel, schemas: Mapping[int, Schema]) -> ChannelInfo:
    schema = schemas[channel.schema_id] if channel.schema_id else None
    return ChannelInfo(
        channel.topic,
        "" if schema is None else schema.name,
        channel.message_encoding,
        "" if schema is None else schema.encoding,
        "" if schema is None else schema.data.decode(errors="replace"),
        dict(channel.metadata),
    )


def _read(stream: IO[bytes], record: Record) -> Attachment | Metadata:
    stream.seek(record.offset)
    content = ReadDataStream(BytesIO(stream.read(record.size)))
    kind: type[Attachment | Metadata] = (
        Attachment if record.opcode == Opcode.ATTACHMENT else Metadata
    )
    found: Attachment | Metadata = kind.read(content)
    return found
