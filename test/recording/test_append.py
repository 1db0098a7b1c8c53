"""Messages appended in one piece make the file that the MCAP writer itself makes."""

from __future__ import annotations

import struct
from io import BytesIO

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.writer import CompressionType, Writer

from spacecraft_gnc.recording._append import appender

TIMES = st.integers(0, 2**63 - 1)
MESSAGES = st.tuples(st.integers(0, 1), TIMES, TIMES, st.binary(max_size=40))


def file_of(messages: list[tuple[int, int, int, bytes]], flush_at: int, *, ours: bool) -> bytes:
    stream = BytesIO()
    writer = Writer(
        stream,
        chunk_size=2**62,
        compression=CompressionType.NONE,
        enable_data_crcs=True,
    )
    append = appender(writer)
    writer.start(profile="ros2", library="test")
    schema = writer.register_schema("a/msg/B", "ros2msg", b"uint8 x\n")
    channels = [writer.register_channel(name, "cdr", schema) for name in ("/a", "/b")]
    for i, (channel, log, published, data) in enumerate(messages):
        if i == flush_at:
            writer.flush()
        if ours:
            append(channels[channel], i, log, published, data)
        else:
            writer.add_message(channels[channel], log, data, published, i)
    writer.finish()
    return stream.getvalue()


@given(messages=st.lists(MESSAGES, max_size=12), flush_at=st.integers(0, 12))
def test_the_bytes_are_those_of_the_writer(
    messages: list[tuple[int, int, int, bytes]], flush_at: int
) -> None:
    assert file_of(messages, flush_at, ours=True) == file_of(messages, flush_at, ours=False)


@pytest.mark.parametrize("number", [-1, 2**64])
def test_a_time_that_does_not_fit_leaves_the_chunk_as_it_was(number: int) -> None:
    stream = BytesIO()
    writer = Writer(stream, chunk_size=2**62, compression=CompressionType.NONE)
    append = appender(writer)
    writer.start()
    channel = writer.register_channel("/a", "cdr", writer.register_schema("a", "ros2msg", b""))
    with pytest.raises(struct.error):
        append(channel, 0, number, 0, b"")
    writer.finish()
    assert writer._Writer__statistics.message_count == 0  # type: ignore[attr-defined]
