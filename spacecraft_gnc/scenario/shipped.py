"""Location of the scenarios and other files that come with the package."""

from __future__ import annotations

import os
import sysconfig
from collections.abc import Iterator
from difflib import get_close_matches
from pathlib import Path
from typing import Final

from spacecraft_gnc.parameters.problems import InvalidScenario, Problem

_FOLDER: Final = Path("share", "spacecraft_gnc", "config")
_SUFFIX: Final = ".yaml"
_NEAREST: Final = 3  # names


def find(scenario: str | Path) -> Path:
    """Return the file that is meant by a path, or by the name of a shipped scenario.

    A file of that name in the working directory goes first, with or without ``.yaml``. What is
    wrong with a path, whoever reads it tells.

    Raises
    ------
    InvalidScenario
        If there is no such file, and it is a name or ends in one of a shipped scenario.
    """
    path = Path(scenario)
    try:
        if path.is_file():
            return path
        is_name = len(path.parts) == 1 and not path.suffix
        beside = path.with_suffix(_SUFFIX) if is_name else path
        if beside.is_file():
            return beside
        is_known = path.stem in _scenarios()
        if path.exists() and not (is_name and is_known):
            return path
    except (OSError, ValueError):  # no name of a file at all
        return path
    return shipped(path.name) if is_name or is_known else path


def shipped(name: str) -> Path:
    """Return the file of a scenario that comes with the package, such as ``gupta2015_case1``.

    Raises
    ------
    InvalidScenario
        If there is none of that name.
    """
    known = _scenarios()
    if name in known:
        return known[name]
    near = sorted(get_close_matches(name.removesuffix(_SUFFIX), known, n=_NEAREST) or known)
    listed = " or ".join(near) if len(near) <= _NEAREST else f"one of {', '.join(near)}"
    remedy = f"use {listed}" if near else "reinstall the package with its data files"
    need = "a file, or the name of a scenario that comes with the package"
    raise InvalidScenario([Problem(name, None, "", "no such file", need, remedy)])


def shipped_file(name: str) -> Path | None:
    """Return another file that comes with the package, or None where it was not installed."""
    return next((path for folder in _folders() if (path := folder / name).is_file()), None)


def _scenarios() -> dict[str, Path]:
    """Return the shipped scenarios by name."""
    files = (file for folder in _folders() for file in sorted(folder.glob(f"*{_SUFFIX}")))
    known: dict[str, Path] = {}
    for file in files:
        known.setdefault(file.stem, file)
    return known


def _folders() -> Iterator[Path]:
    """Yield where ``config/`` may be, the surest place first."""
    root = Path(__file__).parents[2]
    if (root / "package.xml").is_file():  # a checkout, or an editable installation of one
        yield root / "config"
    # pip puts data files beside lib/, with --target beside the package: walk up to either
    yield from (parent / _FOLDER for parent in Path(__file__).parents[2:])
    yield Path(sysconfig.get_path("data")) / _FOLDER
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):  # colcon
        yield Path(prefix) / _FOLDER
