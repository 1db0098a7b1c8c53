"""Checksums of an MCAP file: data section, chunks, attachments and summary.

Source: MCAP specification 1.0, records Data End, Chunk, Attachment and Footer.
"""

from __future__ import annotations

import zlib
from pathlib import Path
from struct import Struct
from typing import IO, Final

from mcap.opcode import Opcode

from spacecraft_gnc.recording._scan import Progress
from spacecraft_gnc.recording.recover import MAGIC

_HEAD: Final = Struct("<BQ")  # opcode, length of the content
_CRC: Final = Struct("<I")
_FOOTER: Final = Struct("<QQI")  # start of the summary, of its offsets, checksum
_FOOTER_SIZE: Final = _HEAD.size + _FOOTER.size + len(MAGIC)
_BLOCK: Final = 1 << 20  # [bytes]


def verify(path: Path, progress: Progress | None = None) -> None:
    """Compare the checksums of a finished MCAP file with what it holds.

    Those of the chunks are compared where their messages are read (`_scan`).

    Raises
    ------
    ValueError
        If one differs, or the file does not end where its records do.
    """
    with path.open("rb") as stream:
        end = stream.seek(0, 2) - _FOOTER_SIZE
        data_end, data_crc = _data_section(stream, end)
        if data_crc:
            _require("the data", _sum(stream, 0, data_end, progress), data_crc)
        _summary(stream, data_end, end)


def _data_section(stream: IO[bytes], end: int) -> tuple[int, int]:
    """Return where the record Data End stands and the checksum in it; check the attachments."""
    position = len(MAGIC)
    while position < end:
        stream.seek(position)
        opcode, length = _HEAD.unpack(stream.read(_HEAD.size))
        if opcode == Opcode.DATA_END:
            return position, _CRC.unpack(stream.read(_CRC.size))[0]
        if opcode == Opcode.ATTACHMENT:
            body = stream.read(length)
            crc = _CRC.unpack(body[-_CRC.size :])[0]
            if crc:
                _require("an attachment", zlib.crc32(body[: -_CRC.size]), crc)
        position += _HEAD.size + length
    raise ValueError("no end of the data section")


def _summary(stream: IO[bytes], data_end: int, end: int) -> None:
    """Check the summary: from its start to the checksum in the footer."""
    stream.seek(end)
    opcode, length = _HEAD.unpack(stream.read(_HEAD.size))
    start, _, crc = _FOOTER.unpack(stream.read(_FOOTER.size))
    after_data = data_end + _HEAD.size + _CRC.size
    if (opcode, length) != (Opcode.FOOTER, _FOOTER.size) or start not in (0, after_data):
        raise ValueError("the footer is not that of the file")
    if crc:
        covered = end + _HEAD.size + _FOOTER.size - _CRC.size
        _require("the summary", _sum(stream, after_data, covered), crc)


def _sum(stream: IO[bytes], start: int, end: int, progress: Progress | None = None) -> int:
    stream.seek(start)
    crc, position = 0, start
    while position < end:
        block = stream.read(min(_BLOCK, end - position))
        crc = zlib.crc32(block, crc)
        position += len(block)
        if progress is not None:
            progress(position, end)
    return crc


def _require(what: str, found: int, recorded: int) -> None:
    if found != recorded:
        raise ValueError(
            f"checksum of {what} is {found:08x}, recorded {recorded:08x}: a byte has changed"
        )
