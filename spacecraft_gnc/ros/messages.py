"""Messages as plain values, and access to a field by its path."""

from __future__ import annotations

import re
from typing import Any

from spacecraft_gnc.errors import GncError

_PATH = re.compile(r"[A-Za-z]\w*(?:\[\d+\])*(?:\.[A-Za-z]\w*(?:\[\d+\])*)*")
_STEP = re.compile(r"\[(\d+)\]|([A-Za-z]\w*)")


class FieldRefused(GncError):
    """A message has no such field."""


def plain(value: Any) -> Any:
    """Return a message as mappings, lists, numbers and strings."""
    if hasattr(value, "get_fields_and_field_types"):
        names = value.get_fields_and_field_types()
        return {name: plain(getattr(value, name)) for name in names}
    if isinstance(value, bytes):
        return list(value) if len(value) != 1 else value[0]
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return value


def field(values: Any, path: str) -> Any:
    """Return the field of plain values that a path such as ``a.b[2]`` leads to.

    Raises
    ------
    FieldRefused
        It leads nowhere.
    """
    if not _PATH.fullmatch(path):
        raise FieldRefused(
            f"--field: received {path!r}; required names and indices such as a.b[2]; correct it"
        )
    found, walked = values, ""
    for match in _STEP.finditer(path):
        index, name = match.groups()
        if name is not None:
            found = _member(found, name, path, walked)
            walked += f".{name}" if walked else name
        else:
            found = _element(found, int(index), path, walked)
            walked += f"[{index}]"
    return found


def _member(found: Any, name: str, path: str, walked: str) -> Any:
    if not isinstance(found, dict):
        raise FieldRefused(f"--field: received {path!r}, but {walked} has no fields; shorten it")
    if name not in found:
        where = walked or "the message"
        known = ", ".join(found)
        raise FieldRefused(f"--field: received {path!r}; required of {where} one of {known}")
    return found[name]


def _element(found: Any, index: int, path: str, walked: str) -> Any:
    if not isinstance(found, list):
        raise FieldRefused(f"--field: received {path!r}, but {walked} is no array; drop the index")
    if index >= len(found):
        raise FieldRefused(
            f"--field: received {path!r}; required an index below {len(found)}, the length of "
            f"{walked}"
        )
    return found[index]
