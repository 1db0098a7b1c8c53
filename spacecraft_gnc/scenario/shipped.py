"""Where the scenarios, and other files, that come with the package lie."""

from __future__ import annotations

import os
import sysconfig
from collections.abc import Iterator
from pathlib import Path

from spacecraft_gnc.errors import ScenarioError

_FOLDER = Path("share", "spacecraft_gnc", "config")


def shipped(name: str) -> Path:
    """Return the file of a scenario that comes with the package, such as ``gupta2015_case1``.

    Raises
    ------
    ScenarioError
        If there is none of that name.
    """
    known: set[str] = set()
    for folder in _folders():
        path = folder / f"{name}.yaml"
        if path.is_file():
            return path
        known.update(file.stem for file in folder.glob("*.yaml"))
    listed = ", ".join(sorted(known)) or "none is installed"
    raise ScenarioError(
        f"scenario: received {name!r}; required one that comes with the package ({listed}); "
        "reinstall the package with its data files"
    )


def shipped_file(name: str) -> Path | None:
    """Return another file that comes with the package, or None where it was not installed."""
    return next((path for folder in _folders() if (path := folder / name).is_file()), None)


def _folders() -> Iterator[Path]:
    yield Path(__file__).parents[2] / "config"  # a checkout, or an editable installation of one
    yield Path(sysconfig.get_path("data")) / _FOLDER  # pip
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):  # colcon
        yield Path(prefix) / _FOLDER
