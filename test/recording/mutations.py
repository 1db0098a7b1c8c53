"""Seeded damage to a bag: to bytes, and to records, which are dropped, swapped or rewritten.

Half of the damage is done to a copy without chunks and checksums, where it reaches the parsers
behind them.
"""

from __future__ import annotations

import random
import shutil
import struct
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from recording.foreign_bags import Contents, write

_HEAD = struct.Struct("<BQ")
_MAGIC = 8  # bytes at either end of a file
_SCHEMA, _CHANNEL, _MESSAGE, _DATA_END = 3, 4, 5, 15
_NUMBERS = (0, 1, 255, 2**15, 2**31 - 1, 2**31, 2**32 - 1)
_FLOATS = (float("nan"), float("inf"), 1e308, -1e308, 5e-324, 0.0)


class Bases(NamedTuple):
    """What is damaged."""

    bag: Path
    """A closed bag of ours."""
    plain: bytes
    """Its file without chunks, checksums and summary."""

    @classmethod
    def of(cls, bag: Path, folder: Path) -> Bases:
        """Prepare the copies of a bag in a folder."""
        plain = write(
            folder / "plain.mcap", Contents.of(bag), use_chunking=False, enable_crcs=False
        )
        return cls(bag, plain.read_bytes())


def mutate(bases: Bases, seed: int, folder: Path) -> tuple[str, Path]:
    """Write a damaged bag into a new folder; return what was done to it, and its path."""
    rng = random.Random(seed)
    name = rng.choice([*_OF_FILES, *_OF_RECORDS, "metadata.yaml"])
    folder.mkdir()
    if name in _OF_RECORDS:
        records = _split(bases.plain)
        for _ in range(rng.choice((1, 1, 3))):
            _OF_RECORDS[name](rng, records)
        return name, _single(folder, _joined(records))
    (file,) = bases.bag.glob("*.mcap")
    if name == "metadata.yaml":
        shutil.copytree(bases.bag, folder / "bag")
        about = folder / "bag" / "metadata.yaml"
        about.write_bytes(_bytes(rng, about.read_bytes()))
        return name, folder / "bag"
    data = rng.choice((bases.plain, file.read_bytes()))
    return name, _single(folder, _OF_FILES[name](rng, data))


def _single(folder: Path, data: bytes) -> Path:
    path = folder / "bag.mcap"
    path.write_bytes(data)
    return path


def _split(data: bytes) -> list[tuple[int, bytes]]:
    """Return (opcode, content) of the records of a file without chunks, up to its data's end."""
    position, found = _MAGIC, []
    while True:
        opcode, size = _HEAD.unpack_from(data, position)
        content = data[position + _HEAD.size : position + _HEAD.size + size]
        if opcode == _DATA_END:
            return found
        found.append((opcode, content))
        position += _HEAD.size + size


def _joined(records: list[tuple[int, bytes]]) -> bytes:
    """Return a file of records, closed as it should be, without a summary."""
    end = [(_DATA_END, bytes(4)), (2, bytes(20))]
    body = b"".join(_HEAD.pack(op, len(data)) + data for op, data in [*records, *end])
    magic = b"\x89MCAP0\r\n"
    return magic + body + magic


# Damage to bytes.


def _bytes(rng: random.Random, data: bytes) -> bytes:
    changed = bytearray(data)
    for _ in range(rng.choice((1, 2, 8, 64))):
        changed[rng.randrange(len(changed))] = rng.randrange(256)
    return bytes(changed)


def _number(rng: random.Random, data: bytes) -> bytes:
    """Write a number of four bytes, or a float, anywhere."""
    raw = (
        struct.pack("<I", rng.choice(_NUMBERS))
        if rng.random() < 0.5
        else struct.pack("<d", rng.choice(_FLOATS))
    )
    at = rng.randrange(max(1, len(data) - len(raw)))
    return data[:at] + raw + data[at + len(raw) :]


def _cut(rng: random.Random, data: bytes) -> bytes:
    return data[: rng.randrange(1, len(data))]


def _hole(rng: random.Random, data: bytes) -> bytes:
    start = rng.randrange(len(data))
    return data[:start] + data[start + rng.randrange(1, 4000) :]


# Damage to records.

_Records = list[tuple[int, bytes]]


def _swapped(rng: random.Random, records: _Records) -> None:
    a, b = rng.randrange(len(records)), rng.randrange(len(records))
    records[a], records[b] = records[b], records[a]


def _dropped(rng: random.Random, records: _Records) -> None:
    del records[rng.randrange(len(records))]


def _repeated(rng: random.Random, records: _Records) -> None:
    records.insert(rng.randrange(len(records)), rng.choice(records))


def _changed(
    change: Callable[[random.Random, bytes], bytes], *opcodes: int
) -> Callable[[random.Random, _Records], None]:
    """Return what changes the content of one record of some kinds."""

    def damage(rng: random.Random, records: _Records) -> None:
        at = rng.choice([i for i, (opcode, _) in enumerate(records) if opcode in opcodes])
        opcode, data = records[at]
        records[at] = (opcode, change(rng, data))

    return damage


def _channel_less(rng: random.Random, records: _Records) -> None:
    """Drop a whole topic: its messages and, perhaps, its channel."""
    number = rng.choice([data[:2] for opcode, data in records if opcode == _CHANNEL])
    kinds = (_MESSAGE,) if rng.random() < 0.5 else (_MESSAGE, _CHANNEL)
    records[:] = [r for r in records if not (r[0] in kinds and r[1][:2] == number)]


def _renumbered(rng: random.Random, records: _Records) -> None:
    """Give the messages of one channel to another."""
    numbers = [data[:2] for opcode, data in records if opcode == _CHANNEL]
    old, new = rng.choice(numbers), rng.choice(numbers)
    for i, (opcode, data) in enumerate(records):
        if opcode == _MESSAGE and data[:2] == old:
            records[i] = (opcode, new + data[2:])


_OF_FILES: dict[str, Callable[[random.Random, bytes], bytes]] = {
    "bytes": _bytes,
    "a number": _number,
    "a cut": _cut,
    "a hole": _hole,
}
_OF_RECORDS: dict[str, Callable[[random.Random, _Records], None]] = {
    "records swapped": _swapped,
    "a record dropped": _dropped,
    "a record repeated": _repeated,
    "a topic dropped": _channel_less,
    "a topic of another": _renumbered,
    "bytes of a channel": _changed(_bytes, _CHANNEL),
    "bytes of a definition": _changed(_bytes, _SCHEMA),
    "bytes of a message": _changed(_bytes, _MESSAGE),
    "a number in a message": _changed(_number, _MESSAGE),
    "a message cut": _changed(_cut, _MESSAGE),
}
