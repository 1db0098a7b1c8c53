"""Units and descriptions of message fields, from the comments of the definition in the bag."""

from __future__ import annotations

import re
from typing import Final, NamedTuple

_FIELD: Final = re.compile(
    r"^(?P<type>[A-Za-z][\w/]*(?:<=\d+)?(?:\[[^\]]*\])?)\s+(?P<name>[a-z]\w*)\s*(?:#\s*(?P<text>.*))?$"
)
_UNIT: Final = re.compile(r"\[([^\]]*)\]")
_COMPONENTS: Final = {"Vector3": "xyz", "Point": "xyz", "Quaternion": "xyzw"}


class FieldText(NamedTuple):
    """What a definition says of a field."""

    unit: str
    """``-`` where it has none; empty where the definition does not say."""
    description: str
    components: str
    """Letters of a vector or a quaternion; empty for anything else."""


def field_texts(definition: str) -> dict[str, FieldText]:
    """Return what a .msg text says of each field of its first type, by name.

    Constants and the header are left out. The unit is what stands in the first square brackets of
    a field's comment.
    """
    own = definition.split("=" * 80, 1)[0]
    found = (_FIELD.match(line.strip()) for line in own.splitlines())
    return {match["name"]: _text(match["type"], match["text"] or "") for match in found if match}


def _text(type_name: str, comment: str) -> FieldText:
    unit = _UNIT.search(comment)
    leaf = type_name.rpartition("/")[2]
    return FieldText(unit[1] if unit else "", comment.strip(), _COMPONENTS.get(leaf, ""))
