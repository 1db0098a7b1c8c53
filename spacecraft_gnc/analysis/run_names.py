"""Names of runs, after the folder or file that holds them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from spacecraft_gnc.recording import BAG_FOLDER, RUN_SCENARIO


def run_name(path: Path) -> str:
    """Return the name of a file or folder; of a bag in the folder of a run, that of the run."""
    if path.is_file():
        return path.stem
    folder = path.resolve()
    is_run = folder.name == BAG_FOLDER and (folder.parent / RUN_SCENARIO).is_file()
    return folder.parent.name if is_run else folder.name


def run_names(paths: Iterable[Path]) -> list[str]:
    """Return a name for each run; where short ones would be the same, the paths as given."""
    paths = list(paths)
    short = [run_name(path) for path in paths]
    if len(set(short)) == len(short):
        return short
    full = [str(path) for path in paths]
    return [f"{path} ({i})" if full.count(path) > 1 else path for i, path in enumerate(full, 1)]
