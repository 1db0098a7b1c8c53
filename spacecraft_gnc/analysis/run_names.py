"""What a run is called: after the folder or file that holds it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Final

_BAG_FOLDER: Final = "bag"  # what `gnc launch` calls it: its parent is the name of the run


def run_name(path: Path) -> str:
    """Return a short name of the run in a bag or file."""
    resolved = path.resolve()
    if not resolved.is_dir():
        return resolved.stem
    if resolved.name == _BAG_FOLDER and resolved.parent.name:
        return resolved.parent.name
    return resolved.name


def run_names(paths: Iterable[Path]) -> list[str]:
    """Return a name for each run; where short ones would be the same, the paths as given."""
    paths = list(paths)
    short = [run_name(path) for path in paths]
    if len(set(short)) == len(short):
        return short
    full = [str(path) for path in paths]
    return [f"{path} ({i})" if full.count(path) > 1 else path for i, path in enumerate(full, 1)]
