"""Messages that nest strings and messages: slow, for what is published seldom."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from typing import Any

import numpy as np

from spacecraft_gnc.signals.codec import LITTLE_ENDIAN, padded
from spacecraft_gnc.signals.structures import CODES, SEQUENCE, STRUCTURES, TEXT, parse_kind


def encode_nested(kinds: Mapping[str, str], values: Mapping[str, Any]) -> bytes:
    """Return the CDR bytes of a message.

    Parameters
    ----------
    kinds
        Type of each field.
    values
        By field; messages as mappings, or as their values in order. What is left out is zero or
        empty.
    """
    payload = bytearray()
    for name, kind in kinds.items():
        _write(payload, kind, values.get(name))
    return padded(LITTLE_ENDIAN + bytes(payload))


def _write(payload: bytearray, kind: str, value: Any) -> None:
    base, count = parse_kind(kind)
    if count is not None:
        items = value if value is not None else [None] * max(count, 0)
        if count == SEQUENCE:
            _put(payload, "I", len(items))
        for item in items:
            _write(payload, base, item)
    elif base == TEXT:
        text = (value or "").encode() + b"\0"
        _put(payload, "I", len(text))
        payload += text
    elif base in CODES:
        _put(payload, CODES[base], value or 0)
    else:
        members = STRUCTURES[base]
        if isinstance(value, tuple | list | np.ndarray):
            value = dict(zip(members, value, strict=True))
        for name, member in members.items():
            _write(payload, member, None if value is None else value.get(name))


def _put(payload: bytearray, code: str, value: Any) -> None:
    size = struct.calcsize(f"<{code}")
    payload += b"\0" * (-len(payload) % size) + struct.pack(f"<{code}", value)
