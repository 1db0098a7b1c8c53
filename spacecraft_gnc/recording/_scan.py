"""Block-wise reading of the data section of an MCAP file.

Source: MCAP specification 1.0, records Chunk, Schema, Channel and Message.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from io import BytesIO
from struct import Struct
from typing import IO, Final, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Chunk
from mcap.stream_reader import get_chunk_data_stream

from spacecraft_gnc.recording.recover import MAGIC

RECORD_HEAD: Final = Struct("<BQ")  # opcode, length of the content
MESSAGE_HEAD: Final = Struct("<HIQQ")  # channel id, sequence number, log time, publish time
_CHUNK_SPAN: Final = Struct("<QQ")  # log times of the first and of the last message
_LAST: Final = (Opcode.DATA_END, Opcode.FOOTER)
_LOOSE: Final = (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE)
_LOOSE_BLOCK: Final = 1 << 20  # records without a chunk are read together up to this size [bytes]

Progress = Callable[[int, int], None]
"""Called with the work done and the work in all, in bytes."""


class Block(NamedTuple):
    """Records that are read together: a chunk, or a run of records outside one."""

    opcode: int
    """Of the chunk; 0: records without one."""
    offset: int
    size: int
    start_ns: int
    """Log time of the earliest message [ns]."""
    end_ns: int
    """Log time of the latest message [ns]."""


class Record(NamedTuple):
    """Place of a record that is neither message nor chunk: an attachment, say."""

    opcode: int
    offset: int
    """Of its content."""
    size: int


def walk(stream: IO[bytes]) -> Iterator[Block | Record]:
    """Yield what the data section consists of, without reading the messages.

    Raises
    ------
    ValueError
        If a record runs beyond the end of the file.
    """
    position, end = len(MAGIC), stream.seek(0, 2)
    loose: list[int] = []  # offset, size, earliest and latest log time
    while position + RECORD_HEAD.size <= end:
        stream.seek(position)
        opcode, length = RECORD_HEAD.unpack(stream.read(RECORD_HEAD.size))
        size = RECORD_HEAD.size + length
        if position + size > end:
            raise ValueError(f"the record at byte {position} runs beyond the end of the file")
        if loose and (opcode not in _LOOSE or loose[1] + size > _LOOSE_BLOCK):
            yield Block(0, *loose)
            loose = []
        if opcode in _LAST:
            return
        if opcode in _LOOSE:
            loose = _joined(loose or [position, 0, 2**64, 0], stream, opcode, size)
        elif opcode == Opcode.CHUNK:
            yield Block(opcode, position, size, *_CHUNK_SPAN.unpack(stream.read(_CHUNK_SPAN.size)))
        else:
            yield Record(opcode, position + RECORD_HEAD.size, length)
        position += size
    raise ValueError("no end of the data section")


def _joined(loose: list[int], stream: IO[bytes], opcode: int, size: int) -> list[int]:
    """Return a run of records with one more."""
    offset, before, start, end = loose
    if opcode == Opcode.MESSAGE:
        _, _, log_time, _ = MESSAGE_HEAD.unpack(stream.read(MESSAGE_HEAD.size))
        start, end = min(start, log_time), max(end, log_time)
    return [offset, before + size, start, end]


def read_block(stream: IO[bytes], block: Block) -> bytes:
    """Return the records of a block, decompressed; the checksum of a chunk is compared.

    Raises
    ------
    Exception
        Whatever the damaged bytes make the parser raise.
    """
    stream.seek(block.offset)
    data = stream.read(block.size)
    if block.opcode != Opcode.CHUNK:
        return data
    chunk = Chunk.read(ReadDataStream(BytesIO(data[RECORD_HEAD.size :])))
    records, size = get_chunk_data_stream(chunk, validate_crc=True)
    return records.read(size)


def records(data: bytes) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, start and end of the content of each record of a block."""
    position, size, head = 0, len(data), RECORD_HEAD.unpack_from
    while position < size:
        opcode, length = head(data, position)
        start = position + RECORD_HEAD.size
        position = start + length
        if position > size:
            raise ValueError("a record runs beyond the end of its chunk")
        yield opcode, start, position


def messages(data: bytes, topics: Mapping[int, str | None]) -> Iterator[tuple[int, str, bytes]]:
    """Yield (log time [ns], topic, serialized message) of some channels of a block.

    Parameters
    ----------
    data
        What `read_block` returned.
    topics
        Topic by channel id; None: not wanted.

    Raises
    ------
    ValueError
        If a message is of none of these channels, or a record is cut short.
    """
    head, head_size, message = MESSAGE_HEAD.unpack_from, MESSAGE_HEAD.size, Opcode.MESSAGE
    for opcode, start, end in records(data):
        if opcode == message:
            number, _, log_time, _ = head(data, start)
            if number not in topics:
                raise ValueError(f"a message of channel {number}, of which nothing is told")
            topic = topics[number]
            if topic is not None:
                yield log_time, topic, data[start + head_size : end]
