"""The files of stored records, ``test/data/pinned/SCENARIO.json``: one record a line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

STORE = Path(__file__).resolve().parents[1] / "data" / "pinned"
_LEAVES = frozenset({"digest", "python"})  # an object that has one of them is written on one line


def load(name: str) -> dict[str, Any]:
    """Return what is stored of a scenario: ``simulated`` and ``recorded``."""
    found: dict[str, Any] = json.loads(_path(name).read_text(encoding="utf-8"))
    return found


def names() -> list[str]:
    """Return the scenarios that are pinned."""
    return sorted(path.stem for path in STORE.glob("*.json"))


def save(name: str, pinned: dict[str, Any]) -> None:
    """Write what is stored of a scenario."""
    STORE.mkdir(exist_ok=True)
    _path(name).write_text("".join(_lines(pinned, 0)) + "\n", encoding="utf-8")


def _path(name: str) -> Path:
    return STORE / f"{name}.json"


def _lines(value: Any, depth: int) -> list[str]:
    if not isinstance(value, dict) or not value or _LEAVES & value.keys():
        return [json.dumps(value)]
    inner = "\n" + " " * (depth + 1)
    items = [f"{json.dumps(key)}: {''.join(_lines(value[key], depth + 1))}" for key in value]
    return ["{", inner, f",{inner}".join(items), "\n", " " * depth, "}"]
