"""REP-2011 hashes of message types (RIHS01), computed from their structure.

Source: REP-2011, "Type version hash"; type_description_interfaces/msg/FieldType for the numbers.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any, Final

from spacecraft_gnc.signals.structures import SEQUENCE, STRUCTURES, parse_kind

_NESTED: Final = 1
_IDS: Final = {
    "int8": 2,
    "uint8": 3,
    "int16": 4,
    "uint16": 5,
    "int32": 6,
    "uint32": 7,
    "int64": 8,
    "uint64": 9,
    "float32": 10,
    "float64": 11,
    "char": 13,
    "bool": 15,
    "byte": 16,
    "string": 17,
}
_ARRAY, _UNBOUNDED = 48, 144  # added to the number of the element


def type_hash(type_name: str, kinds: Mapping[str, str]) -> str:
    """Return the hash ``RIHS01_...`` of a message type ``pkg/msg/Type`` with these fields."""
    nested: dict[str, Any] = {}
    _collect(kinds, nested)
    described = {
        "type_description": _describe(type_name, kinds),
        "referenced_type_descriptions": [nested[name] for name in sorted(nested)],
    }
    return f"RIHS01_{hashlib.sha256(json.dumps(described).encode()).hexdigest()}"


def _collect(kinds: Mapping[str, str], nested: dict[str, Any]) -> None:
    for kind in kinds.values():
        base = parse_kind(kind).base
        name = _full_name(base)
        if base in STRUCTURES and name not in nested:
            nested[name] = _describe(name, STRUCTURES[base])
            _collect(STRUCTURES[base], nested)


def _describe(type_name: str, kinds: Mapping[str, str]) -> dict[str, Any]:
    fields = [{"name": name, "type": _field(kind)} for name, kind in kinds.items()]
    return {"type_name": type_name, "fields": fields}


def _field(kind: str) -> dict[str, Any]:
    base, count = parse_kind(kind)
    offset = 0 if count is None else _UNBOUNDED if count == SEQUENCE else _ARRAY
    return {
        "type_id": _IDS.get(base, _NESTED) + offset,
        "capacity": max(count or 0, 0),
        "string_capacity": 0,
        "nested_type_name": _full_name(base) if base in STRUCTURES else "",
    }


def _full_name(base: str) -> str:
    return base.replace("/", "/msg/")
