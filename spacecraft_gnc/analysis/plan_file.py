"""Files of ``gnc plan``, told from those of flights by a member that no flight has."""

from __future__ import annotations

import zipfile
from collections.abc import Iterable
from pathlib import Path
from typing import Final

import numpy as np

from spacecraft_gnc.errors import ParameterError, RecordingError
from spacecraft_gnc.loop.flight import UNREADABLE

_VEHICLE: Final = "plan_of.npy"


def is_plan(path: Path) -> bool:
    """Tell whether a file is one of ``gnc plan``."""
    return bool(vehicle_in(path))


def refuse_plan(path: Path) -> None:
    """Refuse a plan where a flight is to be read.

    Raises
    ------
    RecordingError
        If the file holds a plan.
    """
    if is_plan(path):
        raise RecordingError(
            f"{path}: received a plan of gnc plan; required a flight, which has commands and "
            "states; gnc report shows the plan and checks its conditions, gnc plot draws it, "
            f"gnc simulate SCENARIO.yaml --set nmpc_controller.plan.file={path} flies it"
        )


def require_one_kind(paths: Iterable[Path]) -> None:
    """Refuse plans beside flights, before any is read.

    Raises
    ------
    ParameterError
        If there are both.
    """
    paths = list(paths)
    plans = [str(path) for path in paths if is_plan(path)]
    if 0 < len(plans) < len(paths):
        flights = ", ".join(str(path) for path in paths if str(path) not in plans)
        raise ParameterError(
            f"{', '.join(plans)}: received a plan of gnc plan beside flights ({flights}); required "
            "plans alone or flights alone; call twice: a flight is shown beside the plan it flew"
        )


def vehicle_in(path: Path) -> str:
    """Return the vehicle that a file is a plan of; empty where it is none."""
    try:
        with path.open("rb") as stream, zipfile.ZipFile(stream) as members:
            if _VEHICLE not in members.namelist():
                return ""
            with members.open(_VEHICLE) as member:
                return str(np.lib.format.read_array(member, allow_pickle=False))
    except UNREADABLE:
        return ""  # whoever reads it says what is wrong
