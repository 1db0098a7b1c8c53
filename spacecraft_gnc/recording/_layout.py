"""Vectorized decoding of serialized messages of one type to arrays.

Messages whose strings and sequences have the same lengths hold each field at the same place, so
that one strided view reads it from all of them. Of a topic that is nearly every message.

Source: OMG DDS-RTPS 2.3, section 10 (CDR version 1, four-byte encapsulation header).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from rosbags.interfaces import Nodetype

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording._exact import exact_rows

_ENCAPSULATION: Final = 4  # bytes before the payload; alignment counts from their end
_SLACK: Final = 7  # bytes of padding that a middleware may leave at the end
_LENGTH: Final = "u4"  # of a string or a sequence
_TEXT, _FLOAT = "string", "float64"
_CODES: Final = {
    "bool": "?",
    "byte": "u1",
    "octet": "u1",
    "char": "u1",
    "float32": "f4",
    "float64": "f8",
} | {
    f"{sign}int{bits}": f"{sign or 'i'}{bits // 8}"
    for sign in ("u", "")
    for bits in (8, 16, 32, 64)
}

Definitions = Mapping[str, Any]
"""Fields by type name, as rosbags keeps them."""


class Group(NamedTuple):
    """Messages of one layout."""

    rows: NDArray[np.int64]
    """Their places among the messages decoded together."""
    fields: dict[str, NDArray[Any]]
    """(m, ...) values by dotted name; numbers as recorded, strings as bytes."""
    exact: NDArray[np.bool_]
    """(m,) whether a message is just what its fields encode to, padding included."""


class _Place(NamedTuple):
    """Where a field lies in every message of a layout."""

    offset: int
    dtype: np.dtype[Any]
    shape: tuple[int, ...]


@dataclass(slots=True)
class _Layout:
    """Places of the fields, found on one message."""

    definitions: Definitions
    data: bytes
    order: str
    position: int = _ENCAPSULATION
    places: dict[str, _Place] = field(default_factory=dict)
    lengths: list[tuple[int, int]] = field(default_factory=list)
    """Offset and value of the lengths that this layout rests on."""

    def add_message(self, type_name: str, prefix: str) -> None:
        """Append the fields of a type."""
        _, members = self.definitions[type_name]
        if prefix and (count := self._floats(type_name)):
            self._add(prefix[:-1], "float64", (count,))  # a vector, a quaternion, a wrench
            return
        for name, (kind, payload) in members:
            self._add_member(prefix + name, kind, payload)

    def _add_member(self, name: str, kind: Nodetype, payload: Any) -> None:
        if kind == Nodetype.NAME:
            self.add_message(payload, f"{name}.")
        elif kind == Nodetype.BASE and payload[0] == _TEXT:
            self._add(name, "S", (), self._length())
        elif kind == Nodetype.BASE:
            self._add(name, payload[0], ())
        else:
            element = _base(payload[0])
            if element not in _CODES:
                raise RecordingError(
                    f"field {name}: received an array of {element}; required numbers"
                )
            self._add(name, element, (payload[1] if kind == Nodetype.ARRAY else self._length(),))

    def _floats(self, type_name: str) -> int:
        """Return how many numbers a type holds that has nothing but numbers; else 0."""
        counts = [
            self._floats(payload)
            if kind == Nodetype.NAME
            else int(_base((kind, payload)) == _FLOAT)
            for _, (kind, payload) in self.definitions[type_name][1]
        ]
        return sum(counts) if all(counts) else 0

    def _length(self) -> int:
        place = self._place(np.dtype(self.order + _LENGTH), ())
        value = int(np.frombuffer(self.data, place.dtype, 1, place.offset)[0])
        if value > len(self.data):  # before an array of that length is described
            raise RecordingError(
                f"received a string or sequence of {value} elements in a message of "
                f"{len(self.data)} bytes; required one that fits in"
            )
        self.lengths.append((place.offset, value))
        return value

    def _add(self, name: str, code: str, shape: tuple[int, ...], letters: int = 0) -> None:
        dtype = np.dtype(f"S{letters}" if code == "S" else self.order + _CODES[code])
        self.places[name] = self._place(dtype, shape)

    def _place(self, dtype: np.dtype[Any], shape: tuple[int, ...]) -> _Place:
        count = int(np.prod(shape))
        if dtype.kind != "S" and count:  # an empty sequence is not aligned
            self.position += -(self.position - _ENCAPSULATION) % dtype.itemsize
        place = _Place(self.position, dtype, shape)
        self.position += count * dtype.itemsize
        if self.position > len(self.data):
            raise RecordingError(
                f"received a message of {len(self.data)} bytes; required {self.position} at least"
            )
        return place


def _base(kind: tuple[Nodetype, Any]) -> str:
    """Return the name of a primitive type; of a message or a sequence, nothing like it."""
    return str(kind[1][0]) if kind[0] == Nodetype.BASE else ""


def decode(definitions: Definitions, type_name: str, messages: Sequence[bytes]) -> Iterator[Group]:
    """Yield the fields of serialized messages, those of one layout together.

    Parameters
    ----------
    definitions
        Fields of the type and of those that it nests.
    type_name
        ``pkg/msg/Type``.
    messages
        With their encapsulation headers.

    Raises
    ------
    RecordingError
        If a message does not follow the definition.
    """
    sizes: dict[tuple[int, bytes], list[int]] = {}
    for row, data in enumerate(messages):
        sizes.setdefault((len(data), data[:2]), []).append(row)
    for (size, representation), rows in sizes.items():
        joined = b"".join([messages[row] for row in rows])
        order = ">" if representation == b"\0\0" else "<"
        yield from _decode_equal(definitions, type_name, (joined, size, order), np.array(rows))


def _decode_equal(
    definitions: Definitions,
    type_name: str,
    block: tuple[bytes, int, str],
    rows: NDArray[np.int64],
) -> Iterator[Group]:
    """Decode messages of equal size: by layouts, until none is left."""
    joined, size, order = block
    left = np.arange(len(rows))
    while left.size:
        first = int(left[0])
        layout = _Layout(definitions, joined[first * size : (first + 1) * size], order)
        layout.add_message(type_name, "")
        if size - layout.position > _SLACK:
            raise RecordingError(
                f"received a message of {size} bytes; required {layout.position} at the most"
            )
        alike = np.ones(left.size, dtype=bool)
        for offset, value in layout.lengths:
            place = _Place(offset, np.dtype(order + _LENGTH), ())
            alike &= _view(joined, size, len(rows), place)[left] == value
        chosen, left = left[alike], left[~alike]
        fields = {
            name: _view(joined, size, len(rows), place)[chosen]
            for name, place in layout.places.items()
        }
        yield Group(rows[chosen], fields, _exact(layout, joined, size, chosen))


def _exact(
    layout: _Layout, joined: bytes, size: int, chosen: NDArray[np.int64]
) -> NDArray[np.bool_]:
    messages = np.frombuffer(joined, np.uint8).reshape(-1, size)[chosen]
    places = [
        (place.offset, place.dtype, int(np.prod(place.shape))) for place in layout.places.values()
    ]
    return exact_rows(messages, places, (at for at, _ in layout.lengths), layout.position)


def _view(joined: bytes, size: int, count: int, place: _Place) -> NDArray[Any]:
    """Return (count, *shape) values of one field, a view into the messages."""
    if place.dtype.itemsize == 0 or 0 in place.shape:
        return np.zeros((count, *place.shape), dtype=place.dtype)
    strides = (size, place.dtype.itemsize) if place.shape else (size,)
    return np.ndarray((count, *place.shape), place.dtype, joined, place.offset, strides)
