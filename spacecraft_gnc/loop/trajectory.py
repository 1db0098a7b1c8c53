"""The record of one closed-loop flight."""

from __future__ import annotations

import math
import zipfile
import zlib
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.arguments import require_path
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.types import Array

_SCENARIO: Final = "scenario"
_DEFAULTS: Final = "scenario_defaults"


@dataclass(frozen=True, slots=True)
class Trajectory:
    """Arrays of a flight: row k belongs to control step k, ``final_*`` to the end of the last step.

    Attributes
    ----------
    period : float
        Control period [s].
    time : (n,) array
        Start of each step [s].
    attitude : (n, 3, 3) array
        Rotation, body to inertial.
    momentum : (n, 3) array
        Angular momentum, body frame [N m s].
    torque : (n, 3) array
        Body torque held over the step [N m].
    reference : (n, 3, 3) array
        Attitude tracked, body to inertial.
    target : (n, 3, 3) array
        Attitude that the governor is asked for, body to inertial; NaN where it is not known.
    iterations, status, source : (n,) arrays of int
        Of the solve behind the torque: iterations, 0 without a solve; `Command.status` as a number
        of `ocp.Status`, -1 without a solve; `loop.Source`.
    residual, cost, solve_time : (n,) arrays
        Residual of the optimality conditions, optimal cost of the horizon, wall time [s]; NaN
        without a solve.
    alpha, governor_margin : (n,) arrays
        Of the governor's decision: share of the way to the target, smallest margin of its
        prediction (infinite where nothing is predicted); NaN where it was not recorded.
    final_attitude, final_momentum, final_reference : (3, 3), (3,), (3, 3) arrays
        State at the end of the flight, and the last reference.
    """

    period: float
    time: Array
    attitude: Array
    momentum: Array
    torque: Array
    reference: Array
    target: Array
    iterations: NDArray[np.int64]
    residual: Array
    cost: Array
    solve_time: Array
    status: NDArray[np.int64]
    source: NDArray[np.int64]
    alpha: Array
    governor_margin: Array
    final_attitude: Array
    final_momentum: Array
    final_reference: Array

    def __repr__(self) -> str:
        """Return the flight in one line."""
        if not self.n_steps:
            return "Trajectory(0 steps)"
        first = math.degrees(lie.angle_between(self.reference[0], self.attitude[0]))
        last = math.degrees(lie.angle_between(self.final_reference, self.final_attitude))
        largest = float(np.linalg.norm(self.torque, axis=1).max())
        solves, solved = np.count_nonzero(self.status >= 0), np.count_nonzero(self.status == 0)
        return (
            f"Trajectory({self.n_steps} steps of {self.period:g} s, {self.n_steps * self.period:g} "
            f"s in all, {first:.4g} to {last:.4g} deg from the reference, largest torque "
            f"{largest:.4g} N m, {solved} of {solves} solves converged)"
        )

    @property
    def n_steps(self) -> int:
        """Number of control steps."""
        return len(self.time)

    def save(self, path: str | Path, scenario: str = "", defaults: str = "") -> Path:
        """Write all arrays to a ``.npz`` file, whole or not at all.

        Parameters
        ----------
        path
            File to write.
        scenario
            Text of what flew, kept beside the arrays as ``scenario``; empty: not known.
        defaults
            Text of the defaults that it took (`Scenario.stated_defaults`), likewise.

        Raises
        ------
        RecordingError
            If the file cannot be written.
        """
        target = Path(require_path("path", path))
        arrays = {item.name: getattr(self, item.name) for item in fields(self)}
        for name, text in ((_SCENARIO, scenario), (_DEFAULTS, defaults)):
            if text:
                arrays[name] = np.array(text)
        temporary = target.with_name(f".{target.name}.part")
        try:
            with temporary.open("wb") as stream:
                np.savez_compressed(stream, **arrays)
            temporary.replace(target)
        except OSError as err:
            if temporary.is_file():
                temporary.unlink()
            raise RecordingError(
                f"{target}: cannot be written ({err.strerror or err}); required a writable folder "
                "with room for the file; choose another --out"
            ) from err
        return target

    @classmethod
    def load(cls, path: str | Path) -> Trajectory:
        """Read a file written by `save`.

        Raises
        ------
        RecordingError
            If it is missing, damaged or not such a file.
        """
        values = _read(require_path("path", path), *(item.name for item in fields(cls)))
        values["period"] = float(values["period"])
        return cls(**values)

    @staticmethod
    def load_scenario(path: str | Path) -> str:
        """Read the scenario in a file written by `save`; empty where it holds none."""
        return str(_read(path, _SCENARIO).get(_SCENARIO, ""))

    @staticmethod
    def load_defaults(path: str | Path) -> str:
        """Read the defaults in a file written by `save`; empty where it holds none."""
        return str(_read(path, _DEFAULTS).get(_DEFAULTS, ""))


def _read(path: str | Path, *names: str) -> dict[str, Any]:
    """Return members of a file by name; of a file of before it held texts, none of them."""
    try:
        with Path(path).open("rb") as stream, zipfile.ZipFile(stream) as members:
            known = set(members.namelist())
            texts = (_SCENARIO, _DEFAULTS)
            wanted = [n for n in names if n not in texts or f"{n}.npy" in known]
            return {name: _member(members, name) for name in wanted}
    except (OSError, KeyError, ValueError, zipfile.BadZipFile, zlib.error, EOFError) as err:
        raise RecordingError(
            f"{path}: cannot be read as a flight ({err}); required a .npz file written by "
            "`gnc simulate --out`; fly again"
        ) from err


def _member(members: zipfile.ZipFile, name: str) -> Any:
    # One array at a time: np.load leaves the file open where the archive is torn.
    with members.open(f"{name}.npy") as stream:
        return np.lib.format.read_array(stream, allow_pickle=False)
