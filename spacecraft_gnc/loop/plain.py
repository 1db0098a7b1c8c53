"""Plain values as bytes: what a core remembers, without any code in it.

Plain are None, truth values, whole numbers of 64 bits, floating-point numbers, texts, bytes, arrays
of numbers, and tuples of plain values. Arrays keep shape, type and whether they are read-only.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any, Final

import numpy as np

_LENGTH: Final = struct.Struct("<I")
_INTEGER: Final = struct.Struct("<q")
_NUMBER: Final = struct.Struct("<d")
_ARRAY: Final = struct.Struct("<cBB")  # kind of its numbers, whether it is read-only, dimensions
_NONE, _TRUE, _FALSE = b"n", b"t", b"f"
_INT, _FLOAT, _TEXT, _BYTES, _TUPLE, _NUMBERS = b"i", b"d", b"s", b"b", b"(", b"a"
_WORDS: Final = {_NONE: None, _TRUE: True, _FALSE: False}
_SCALARS: Final = {_INT: _INTEGER, _FLOAT: _NUMBER}
_KINDS: Final = {b"d": np.dtype("<f8"), b"q": np.dtype("<i8"), b"?": np.dtype("?")}
_READ: Final[dict[bytes, Callable[[bytes], Any]]] = {_TEXT: bytes.decode, _BYTES: bytes}
_KIND_OF: Final = {kind: letter for letter, kind in _KINDS.items()}


def pack(value: Any) -> bytes:
    """Return the bytes of a plain value.

    Raises
    ------
    TypeError
        If it is none.
    """
    parts: list[bytes] = []
    _add(parts, value)
    return b"".join(parts)


def unpack(data: bytes) -> Any:
    """Return the plain value of bytes; sequences come back as tuples.

    Raises
    ------
    ValueError
        If they are not those of one plain value.
    """
    try:
        value, end = _read(data, 0)
    except (struct.error, IndexError, KeyError) as error:
        raise ValueError(f"bytes: received {len(data)} that are cut off or damaged") from error
    if end != len(data):
        raise ValueError(f"bytes: received {len(data)}; required the {end} of the value in them")
    return value


def _add(parts: list[bytes], value: Any) -> None:
    if value is None:
        parts.append(_NONE)
    elif isinstance(value, bool | np.bool_):
        parts.append(_TRUE if value else _FALSE)
    elif isinstance(value, int | np.integer):
        parts.append(_INT + _INTEGER.pack(int(value)))
    elif isinstance(value, float):
        parts.append(_FLOAT + _NUMBER.pack(value))
    elif isinstance(value, str):
        _add_sized(parts, _TEXT, value.encode())
    elif isinstance(value, bytes):
        _add_sized(parts, _BYTES, value)
    elif isinstance(value, tuple | list):
        parts.append(_TUPLE + _LENGTH.pack(len(value)))
        for item in value:
            _add(parts, item)
    elif isinstance(value, np.ndarray) and value.dtype in _KIND_OF:
        parts.append(_NUMBERS)
        parts.append(_ARRAY.pack(_KIND_OF[value.dtype], not value.flags.writeable, value.ndim))
        parts.extend(map(_LENGTH.pack, value.shape))
        parts.append(value.tobytes())
    else:
        raise TypeError(f"memory: received a {type(value).__name__}; required plain values")


def _add_sized(parts: list[bytes], tag: bytes, data: bytes) -> None:
    parts.append(tag + _LENGTH.pack(len(data)))
    parts.append(data)


def _read(data: bytes, at: int) -> tuple[Any, int]:
    tag, at = data[at : at + 1], at + 1
    if tag in _WORDS:
        return _WORDS[tag], at
    if tag in _SCALARS:
        scalar = _SCALARS[tag]
        return scalar.unpack_from(data, at)[0], at + scalar.size
    if tag == _NUMBERS:
        return _read_array(data, at)
    (length,) = _LENGTH.unpack_from(data, at)
    at += _LENGTH.size
    if tag == _TUPLE:
        items = []
        for _ in range(length):
            item, at = _read(data, at)
            items.append(item)
        return tuple(items), at
    found = data[at : at + length]
    if len(found) < length:
        raise IndexError
    return _READ[tag](found), at + length


def _read_array(data: bytes, at: int) -> tuple[Any, int]:
    letter, is_read_only, dimensions = _ARRAY.unpack_from(data, at)
    at += _ARRAY.size
    kind, shape = _KINDS[letter], []
    for _ in range(dimensions):
        shape.append(_LENGTH.unpack_from(data, at)[0])
        at += _LENGTH.size
    count = int(np.prod(shape, dtype=np.int64))
    array = np.frombuffer(data, kind, count, at).reshape(shape).copy()
    array.setflags(write=not is_read_only)
    return array, at + count * kind.itemsize
