"""Messages of a fixed layout, straight from numbers to CDR bytes and back.

Converting a message object costs 40 to 80 us, more than one optimal control problem. A message
whose strings and sequences keep the lengths of a prototype is one C structure, which `struct`
packs in 2 us. The bytes equal those of `rclpy.serialization.serialize_message`, but for two things
that make them reproducible: padding is zero (there it is whatever the memory held), and the end is
padded to four bytes, as RTPS does between two processes but not within one.

Source: OMG DDS-RTPS 2.3, section 10 (CDR version 1, little-endian, four-byte encapsulation header).
"""

from __future__ import annotations

import struct
import sys
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from rclpy.serialization import deserialize_message

_ENCAPSULATION = b"\x00\x01\x00\x00"
_RTPS_ALIGNMENT = 4  # [bytes]
_CODES = {
    "boolean": "?",
    "octet": "B",
    "byte": "B",
    "char": "B",
    "int8": "b",
    "uint8": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
    "float": "f",
    "double": "d",
}


class _Leaf(NamedTuple):
    """One primitive of a flattened message."""

    path: str
    code: str
    """`struct` code, or ``"s"`` for bytes fixed by the prototype."""
    value: Any
    alignment: int

    @property
    def constant(self) -> bool:
        return self.code == "s"


class Layout:
    """The CDR layout of messages shaped like a prototype.

    Strings and the lengths of sequences are fixed by the prototype; numbers are free.

    Parameters
    ----------
    prototype
        A message object. Its numbers do not matter.
    """

    def __init__(self, prototype: Any) -> None:
        leaves = [_Leaf("", "s", _ENCAPSULATION, 1), *_flatten(prototype, "")]
        self.message_type = type(prototype)
        body = _format(leaves)
        self._padding = b"\0" * (-struct.calcsize(body) % _RTPS_ALIGNMENT)
        self._struct = struct.Struct(body + "x" * len(self._padding))
        self.size = self._struct.size
        """Bytes of a message."""
        self._template: list[Any] = [leaf.value for leaf in leaves]
        self._constants = [i for i, leaf in enumerate(leaves) if leaf.constant]
        self._runs = list(_runs(leaves))
        free = [leaf for leaf in leaves if not leaf.constant]
        self.n_values = len(free)
        self._fields: dict[str, slice] = {}
        for i, leaf in enumerate(free):
            for name in _prefixes(leaf.path):
                start = self._fields[name].start if name in self._fields else i
                self._fields[name] = slice(start, i + 1)

    def field(self, name: str) -> slice:
        """Where a field (nested fields dotted) lies among the values."""
        return self._fields[name]

    @property
    def values(self) -> list[Any]:
        """The prototype's own numbers (a copy)."""
        return [value for there, _ in self._runs for value in self._template[there]]

    def pack(self, values: Sequence[Any]) -> bytes:
        """CDR bytes of the message that holds ``values``: its numbers in order of declaration."""
        slots = self._template.copy()
        for there, here in self._runs:
            slots[there] = values[here]
        return self._struct.pack(*slots)

    def unpack(self, data: bytes) -> list[Any] | None:
        """Return the numbers of a message; None where it has not this layout."""
        if len(data) != self.size:
            data += self._padding
            if len(data) != self.size:
                return None
        slots = self._struct.unpack(data)
        if any(slots[i] != self._template[i] for i in self._constants):
            return None
        values: list[Any] = []
        for there, _ in self._runs:
            values += slots[there]
        return values

    def read(self, data: bytes) -> list[Any]:
        """Return the numbers of a message of this type with strings of any length.

        Raises
        ------
        ValueError
            The bytes are no message of this type, or one of its sequences has another length.
        """
        values = self.unpack(data)
        if values is not None:
            return values
        message = deserialize_message(data, self.message_type)
        values = [leaf.value for leaf in _flatten(message, "") if not leaf.constant]
        if len(values) != self.n_values:
            raise ValueError(f"{len(values)} numbers, expected {self.n_values}")
        return values


def encode(message: Any) -> bytes:
    """CDR bytes of any message: slow, but reproducible where `serialize_message` is not."""
    layout = Layout(message)
    return layout.pack(layout.values)


def _prefixes(path: str) -> Iterator[str]:
    parts = path.split(".")
    for i in range(len(parts)):
        yield ".".join(parts[: i + 1])


def _flatten(message: Any, prefix: str) -> Iterator[_Leaf]:
    """Primitives of a message in order of declaration; paths of array elements are the array's."""
    for name, kind in message.get_fields_and_field_types().items():
        yield from _flatten_value(getattr(message, name), kind, prefix + name)


def _flatten_value(value: Any, kind: str, path: str) -> Iterator[_Leaf]:
    if kind.startswith("sequence<"):
        yield _Leaf(path, "s", struct.pack("<I", len(value)), 4)
        element = kind[len("sequence<") : -1].partition(",")[0]
        for item in value:
            yield from _flatten_value(item, element, path)
    elif kind.endswith("]"):
        for item in value:
            yield from _flatten_value(item, kind[: kind.index("[")], path)
    elif kind == "string":
        text = value.encode() + b"\0"
        yield _Leaf(path, "s", struct.pack("<I", len(text)) + text, 4)
    elif kind in _CODES:
        code = _CODES[kind]
        number = value[0] if isinstance(value, bytes) else value
        yield _Leaf(path, code, number, struct.calcsize("<" + code))
    else:
        yield from _flatten(value, path + ".")


def _format(leaves: Sequence[_Leaf]) -> str:
    """`struct` format with the padding that CDR asks for (aligned to the byte after the header)."""
    parts = ["<"]
    offset = -len(_ENCAPSULATION)
    for leaf in leaves:
        padding = -offset % leaf.alignment
        size = len(leaf.value) if leaf.constant else struct.calcsize("<" + leaf.code)
        parts.append("x" * padding + (f"{size}s" if leaf.constant else leaf.code))
        offset += padding + size
    return "".join(parts)


def _runs(leaves: Sequence[_Leaf]) -> Iterator[tuple[slice, slice]]:
    """Maximal runs of numbers: their slots in the structure, and among the values."""
    done = 0
    start: int | None = None
    for i, leaf in enumerate([*leaves, _Leaf("", "s", b"", 1)]):
        if not leaf.constant:
            start = i if start is None else start
        elif start is not None:
            yield slice(start, i), slice(done, done + i - start)
            done += i - start
            start = None


if sys.byteorder != "little":  # pragma: no cover
    raise ImportError("spacecraft_gnc.nodes packs little-endian CDR; this machine is big-endian")
