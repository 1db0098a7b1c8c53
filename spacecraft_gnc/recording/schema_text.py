"""Message definitions as MCAP wants them: the ``ros2msg`` text of a type with all it nests.

Source: MCAP format registry, ``ros2msg``: the .msg text, then each nested type after a line of 80
``=`` and a line ``MSG: pkg/Type``.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TypeAlias

from spacecraft_gnc.errors import RecordingError

Lookup: TypeAlias = Callable[[str], str]
"""Maps a type name ``pkg/msg/Type`` to the text of its .msg file; raises RecordingError."""

_SEPARATOR = "=" * 80
_PRIMITIVES = frozenset(
    {"bool", "byte", "char", "float32", "float64", "string", "wstring"}
    | {f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)}
)
# A field line starts with a type; "[3]", "[]", "[<=3]" and the "<=10" of bounded strings follow it.
_FIELD = re.compile(r"^\s*([A-Za-z][A-Za-z0-9_/]*)(?:<=\d+)?(?:\[[^\]]*\])?\s+([A-Za-z]\w*)\s*(=?)")


def schema_text(type_name: str, lookup: Lookup) -> str:
    """Return the complete ``ros2msg`` definition of a type.

    Parameters
    ----------
    type_name
        ``pkg/msg/Type`` (``pkg/Type`` is understood too).
    lookup
        Where the .msg texts come from, for instance `InstalledInterfaces.definition`.

    Raises
    ------
    RecordingError
        If ``lookup`` does not know the type or one that it nests.
    """
    root = canonical_name(type_name)
    definitions = {root: lookup(root)}
    _collect_nested(root, lookup, definitions)
    parts = [definitions.pop(root).rstrip()]
    for name, text in definitions.items():
        package, _, leaf = name.split("/")
        parts.append(f"{_SEPARATOR}\nMSG: {package}/{leaf}\n{text.rstrip()}")
    return "\n".join(parts) + "\n"


def _collect_nested(name: str, lookup: Lookup, definitions: dict[str, str]) -> None:
    for nested in nested_types(name, definitions[name]):
        if nested not in definitions:
            definitions[nested] = lookup(nested)
            _collect_nested(nested, lookup, definitions)


def canonical_name(type_name: str) -> str:
    """Return ``pkg/msg/Type`` for ``pkg/msg/Type`` or ``pkg/Type``.

    Raises
    ------
    RecordingError
        If the name has another form.
    """
    match type_name.split("/"):
        case [package, interface, leaf] if package and interface and leaf:
            return f"{package}/{interface}/{leaf}"
        case [package, leaf] if package and leaf:
            return f"{package}/msg/{leaf}"
    raise RecordingError(
        f"message type: received {type_name!r}; required pkg/msg/Type; correct the name"
    )


def nested_types(type_name: str, text: str) -> Iterator[str]:
    """Yield the message types among the fields of one .msg text, as ``pkg/msg/Type``."""
    package = type_name.partition("/")[0]
    for field_type, _ in fields(text):
        if field_type not in _PRIMITIVES:
            # A name without a package means a message of the same package.
            yield canonical_name(field_type if "/" in field_type else f"{package}/{field_type}")


def fields(text: str) -> Iterator[tuple[str, str]]:
    """Yield (type, name) of the fields of one .msg text; constants are left out."""
    for line in text.splitlines():
        if line.startswith(_SEPARATOR):
            return
        match = _FIELD.match(line)
        if match and not match[3]:
            yield match[1], match[2]


class InstalledInterfaces:
    """Message definitions of the ROS packages installed on this machine, read from ``share/``.

    Parameters
    ----------
    prefixes
        Install prefixes, searched in order; by default those of ``AMENT_PREFIX_PATH``.
    """

    def __init__(self, prefixes: Iterable[Path] | None = None) -> None:
        if prefixes is None:
            listed = os.environ.get("AMENT_PREFIX_PATH", "")
            prefixes = [Path(entry) for entry in listed.split(os.pathsep) if entry]
        self._prefixes = tuple(prefixes)

    def definition(self, type_name: str) -> str:
        """Return the .msg text of ``pkg/msg/Type``.

        Raises
        ------
        RecordingError
            If no prefix has it.
        """
        return self._read(type_name, ".msg")

    def type_hash(self, type_name: str) -> str:
        """Return the REP-2011 hash ``RIHS01_...`` of a type; empty where it is not installed."""
        name = canonical_name(type_name)
        try:
            described = json.loads(self._read(name, ".json"))
        except RecordingError:
            return ""
        hashes = {entry["type_name"]: entry["hash_string"] for entry in described["type_hashes"]}
        return str(hashes.get(name, ""))

    def _read(self, type_name: str, suffix: str) -> str:
        package, interface, leaf = canonical_name(type_name).split("/")
        tail = Path("share", package, interface, leaf + suffix)
        for prefix in self._prefixes:
            try:
                return (prefix / tail).read_text(encoding="utf-8")
            except FileNotFoundError:
                continue
        searched = ", ".join(str(prefix) for prefix in self._prefixes) or "nowhere"
        raise RecordingError(
            f"message type {type_name}: {tail} not found; searched {searched}; source the "
            "workspace that holds it, so that AMENT_PREFIX_PATH names its prefix"
        )
