"""Values laid over those of a scenario file: ``--set`` on a command line, a mapping in Python."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

from spacecraft_gnc.arguments import as_tuple, require_kind
from spacecraft_gnc.parameters.declare import flatten
from spacecraft_gnc.parameters.problems import Problem, shown, suggestion
from spacecraft_gnc.parameters.values import plain
from spacecraft_gnc.parameters.yaml_file import Entry, Given, parse_value
from spacecraft_gnc.parameters.yaml_scalar import Scalar
from spacecraft_gnc.scenario.schema import ROLES

_DURATION: Final = re.compile(r"\s*plant\b.*\bduration\b")
Overrides = Mapping[str, Any] | Sequence[str]
"""``{"plant.duration": 10.0}``, nested or dotted, or ``["plant.duration=10"]`` as for ``--set``."""


def replaces_duration(texts: Iterable[str]) -> bool:
    """Tell whether values of ``--set`` lay another ``plant.duration`` over that of a file."""
    return any(_DURATION.match(text) for text in texts)


def apply(overrides: Overrides, given: Given, problems: list[Problem]) -> None:
    """Lay overrides over what the file gives."""
    written: dict[str, str] = {}
    if isinstance(overrides, Mapping):
        values = flatten(overrides)
    else:
        values = {}
        for i, text in enumerate(as_tuple("overrides", overrides, "NODE.PARAMETER=VALUE")):
            require_kind(f"overrides[{i}]", text, str)
            values |= _parse_override(text, problems)
            key, _, value_text = text.partition("=")
            written[key.strip()] = value_text.strip()
    for key, value in values.items():
        if value is None:  # as in `from_sections`: not given
            continue
        section, _, name = key.partition(".")
        if section not in ROLES or not name:
            need = f"NODE.PARAMETER with a node out of {', '.join(ROLES)}"
            remedy = suggestion(section, ROLES)
            problems.append(Problem("--set", None, key, shown(plain(value)), need, remedy))
            continue
        as_written = written.get(key) if isinstance(value, Scalar) else None
        entry = Entry(plain(value), "--set", coerce=True, written=as_written)
        given.setdefault(section, {})[name] = entry


def _parse_override(text: str, problems: list[Problem]) -> dict[str, Any]:
    key, equals, value = text.partition("=")
    key = key.strip()
    if not equals or not key:
        remedy = "write for example --set plant.duration=10.0"
        problems.append(Problem("--set", None, "", shown(text), "NODE.PARAMETER=VALUE", remedy))
        return {}
    try:
        parsed = parse_value(value)
    except ValueError as error:
        requirement, _, remedy = str(error).partition("; ")
        problems.append(Problem("--set", None, key, shown(value), requirement, remedy))
        return {}
    if isinstance(parsed, dict):
        return {f"{key}.{name}": item for name, item in parsed.items()}
    return {key: parsed}
