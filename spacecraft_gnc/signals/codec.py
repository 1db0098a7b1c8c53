"""Messages of one type, straight from numbers to CDR bytes and back.

Converting a message object costs 40 to 80 us, more than one optimal control problem. Messages whose
strings and sequences have the same lengths share one C structure, which `struct` packs in 2 us;
there is one such layout for each set of lengths. The bytes equal those of rclpy, but for two things
that make them reproducible: padding is zero (there it is whatever the memory held), and the end is
padded to four bytes, as RTPS does between two processes but not within one.

Source: OMG DDS-RTPS 2.3, section 10 (CDR version 1, four-byte encapsulation header).
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc.errors import ShapeError
from spacecraft_gnc.signals.message import Message, Refused, Stamp
from spacecraft_gnc.signals.structures import (
    SEQUENCE,
    TEXT,
    numbers_in,
    parse_kind,
)

LITTLE_ENDIAN: Final = b"\x00\x01\x00\x00"
_ORDERS: Final = {LITTLE_ENDIAN: "<", b"\x00\x00\x00\x00": ">"}
_ENCAPSULATION: Final = 4  # bytes before the payload; alignment counts from their end
_RTPS_ALIGNMENT: Final = 4  # [bytes]
_LENGTH: Final = 4  # bytes of the length of a string or a sequence
_SURPLUS: Final = 7  # bytes that rosidl may leave at the end, for elements of empty sequences
_MOST_LAYOUTS: Final = 64  # kept of one signal: words from outside have any length
_NUMBERS, _TEXT = -1, -2  # instead of the width of an element
_STAMP: Final = "stamp"
_FRAME: Final = "frame_id"


class _Part(NamedTuple):
    """A field, or a part of the header: numbers, or of variable length."""

    name: str
    codes: str
    """Of its numbers; of one element, where it is a sequence; ``s``: a string."""
    variable: bool


class _Layout(NamedTuple):
    """Messages whose strings and sequences have certain lengths."""

    struct: struct.Struct
    places: Mapping[str, int | slice]
    padding: int
    """Bytes at the end that a middleware may leave out."""

    def unpack(self, data: bytes) -> tuple[Any, ...]:
        size = self.struct.size
        if size - self.padding <= len(data) <= size + _SURPLUS:
            data = data.ljust(size, b"\0")[:size]
        return self.struct.unpack(data)


class Codec:
    """Encodes and decodes the messages of one type.

    Parameters
    ----------
    name
        Of the message type, for errors.
    kinds
        Type of each field, in order of declaration. A field ``header`` is filled with a stamp and
        the frame.
    frame
        Frame of the header.
    """

    def __init__(self, name: str, kinds: Mapping[str, str], frame: str) -> None:
        self._name = name
        self._parts = list(_parts(kinds))
        self._has_header = "header" in kinds
        self._has_step = "step" in kinds
        text = frame.encode() + b"\0"
        self._frame = (len(text), text)
        self._layouts: dict[tuple[str, tuple[int, ...]], _Layout] = {}
        first = 2 * self._has_header + self._has_step  # parts that no caller gives
        self._given = self._parts[first:]
        self._lengths: tuple[int, ...] = (len(text),) if self._has_header else ()
        self._runs = list(_runs(self._given))
        fixed = not any(part.variable for part in self._given)
        self._fixed = self._layout("<", self._lengths) if fixed else None
        self._frame_at = 4 if self._has_header else None  # slot of the frame's text

    def encode(self, stamp: Stamp, step: int, values: Sequence[Any]) -> bytes:
        """Return the CDR bytes of a message; ``values``: of the fields after header and step.

        Raises
        ------
        ShapeError
            If the values are not those of the message.
        """
        slots: list[Any] = [LITTLE_ENDIAN]
        if self._has_header:
            slots += stamp
            slots += self._frame
        if self._has_step:
            slots.append(step)
        try:
            if self._fixed is None:
                return self._encode_variable(slots, values)
            for width, here in self._runs:
                if width == _NUMBERS:
                    slots += values[here]
                else:
                    value = values[here.start]
                    slots += value.ravel().tolist() if isinstance(value, np.ndarray) else value
            return self._fixed.struct.pack(*slots)
        except (struct.error, TypeError, ValueError, IndexError) as error:
            told = ", ".join(part.name for part in self._given)
            raise ShapeError(
                f"{self._name}: received values that do not fit ({error}); required {told}; give "
                "each field as its message defines it"
            ) from error

    def _encode_variable(self, slots: list[Any], values: Sequence[Any]) -> bytes:
        lengths = self._lengths
        for width, here in self._runs:
            if width == _NUMBERS:
                slots += values[here]
                continue
            value = values[here.start]
            if width == _TEXT:
                text = value.encode() + b"\0"
                slots += (len(text), text)
                lengths += (len(text),)
                continue
            numbers = value.ravel().tolist() if isinstance(value, np.ndarray) else value
            if width:
                count = len(numbers) // width
                slots.append(count)
                lengths += (count,)
            slots += numbers
        layout = self._layouts.get(("<", lengths)) or self._layout("<", lengths)
        return layout.struct.pack(*slots)

    def decode(self, data: bytes) -> Message:
        """Return a message, unchecked but for its layout.

        Raises
        ------
        Refused
            If the bytes are none of this type.
        """
        fixed = self._fixed
        if fixed is not None and len(data) == fixed.struct.size:
            slots = fixed.struct.unpack(data)
            at = self._frame_at
            if slots[0] == LITTLE_ENDIAN and (at is None or slots[at] == self._frame[1]):
                return Message(slots, fixed.places)
        try:
            order = _ORDERS[data[:_ENCAPSULATION]]
            layout = self._layout(order, tuple(self._read_lengths(data, order)))
            return Message(layout.unpack(data), layout.places)
        except KeyError:
            reason = "they do not begin as CDR"
        except (struct.error, ValueError, OverflowError, MemoryError) as error:
            reason = str(error)
        raise Refused(f"{len(data)} bytes that are no {self._name} ({reason})", "layout")

    def _read_lengths(self, data: bytes, order: str) -> Iterator[int]:
        """Yield the lengths that a message states for its strings and sequences."""
        offset = 0
        for part in self._parts:
            if not part.variable:
                for code in part.codes:
                    size = struct.calcsize(f"<{code}")
                    offset += -offset % size + size
                continue
            offset += -offset % _LENGTH
            count = struct.unpack_from(f"{order}I", data, _ENCAPSULATION + offset)[0]
            offset += _LENGTH
            if count:
                size = 1 if part.codes == "s" else struct.calcsize(f"<{part.codes[0]}")
                offset += -offset % size + size * len(part.codes) * count
            if offset > len(data):
                raise ValueError(f"{part.name} would end behind them")
            yield count

    def _layout(self, order: str, lengths: tuple[int, ...]) -> _Layout:
        layout = self._layouts.get((order, lengths))
        if layout is None:
            if len(self._layouts) >= _MOST_LAYOUTS:
                self._layouts.clear()
            layout = self._layouts[order, lengths] = _make_layout(self._parts, order, lengths)
        return layout


def _parts(kinds: Mapping[str, str]) -> Iterator[_Part]:
    for name, kind in kinds.items():
        if name == "header":
            yield _Part(_STAMP, "iI", variable=False)
            yield _Part(_FRAME, "s", variable=True)
            continue
        base, count = parse_kind(kind)
        if base == TEXT and count is None:
            yield _Part(name, "s", variable=True)
            continue
        codes = numbers_in(base if count == SEQUENCE else kind)
        if codes is None or (count == SEQUENCE and len(set(codes)) > 1):
            raise ValueError(f"{name}: received {kind!r}; required numbers or one string")
        yield _Part(name, codes, variable=count == SEQUENCE)


def is_flat(kinds: Mapping[str, str]) -> bool:
    """Tell whether a type nests no strings, so that `Codec` takes it."""
    try:
        return bool(list(_parts(kinds)))
    except ValueError:
        return False


def _make_layout(parts: Sequence[_Part], order: str, lengths: tuple[int, ...]) -> _Layout:
    """Return the `struct` format with the padding that CDR asks for, and where the fields lie."""
    words, offset, slot = [order, f"{_ENCAPSULATION}s"], 0, 1
    places: dict[str, int | slice] = {}
    left = iter(lengths)

    def add(code: str, size: int, count: int = 1) -> None:
        nonlocal offset
        padding = -offset % size
        words.append("x" * padding + (f"{count}{code}" if count > 1 else code))
        offset += padding + size * count

    for part in parts:
        if part.variable:
            add("I", _LENGTH)
            slot += 1
        count = next(left) if part.variable else 1
        if part.codes == "s":
            add(f"{count}s", 1)
            offset += count - 1
            places[part.name] = slot
            slot += 1
            continue
        codes = part.codes * count
        if codes and len(set(codes)) == 1:
            add(codes[0], struct.calcsize(f"<{codes[0]}"), len(codes))
        else:
            for code in codes:
                add(code, struct.calcsize(f"<{code}"))
        single = not part.variable and len(codes) == 1
        places[part.name] = slot if single else slice(slot, slot + len(codes))
        slot += len(codes)
    padding = -offset % _RTPS_ALIGNMENT
    words.append("x" * padding)
    return _Layout(struct.Struct("".join(words)), places, padding)


def _runs(parts: Sequence[_Part]) -> Iterator[tuple[int, slice]]:
    """Yield each field with the width of its element (0: an array), single numbers together."""
    start = 0
    for i, part in enumerate(parts):
        if not part.variable and len(part.codes) == 1:
            continue
        if start < i:
            yield _NUMBERS, slice(start, i)
        width = len(part.codes) if part.variable else 0
        yield _TEXT if part.codes == "s" else width, slice(i, i + 1)
        start = i + 1
    if start < len(parts):
        yield _NUMBERS, slice(start, len(parts))


def padded(data: bytes) -> bytes:
    """Return a message that ends as RTPS carries it."""
    return data + b"\0" * (-len(data) % _RTPS_ALIGNMENT)
