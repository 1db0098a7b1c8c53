"""File of a plan: a transfer, its optimal solution, and the scenario that it was planned for."""

from __future__ import annotations

import json
import math
import zipfile
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.drawing.whole_file import whole_file
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.errors import GncError, RecordingError
from spacecraft_gnc.loop.flight import UNREADABLE
from spacecraft_gnc.ocp.transfer import AttitudeTransfer, TransferSolution
from spacecraft_gnc.ocp.transfer.conditions import evaluate
from spacecraft_gnc.ocp.transfer.solution import Tried
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array, read_only

_KIND: Final = "plan_of"  # the array that no flight has
_VEHICLE: Final = "rigid_body"
_TOLERANCE: Final = 1e-8  # of the conditions, as of `TransferSolver`
_SAME: Final = 1e-9  # relative difference of numbers, and angle between attitudes, that is none


class StoredPlan(NamedTuple):
    """What a file holds."""

    solution: TransferSolution
    """Without a wall time, so that a plan is the same file however long it took."""
    scenario: str
    """Text of what was planned, and of the defaults that it took; empty: not told."""
    defaults: str


def save_plan(
    path: str | Path, solution: TransferSolution, scenario: str = "", defaults: str = ""
) -> Path:
    """Write a plan to a ``.npz`` file, whole or not at all; `StoredPlan` says what it holds.

    ``multipliers`` (N+1, 6) and ``active`` (N+1, 6) hold those of the torque, whose last row is
    zero, beside those of the momentum.

    Raises
    ------
    RecordingError
        If the file cannot be written.
    """
    problem, target = solution.problem, Path(path)
    arrays: dict[str, Any] = {
        _KIND: np.array(_VEHICLE),
        "torque": solution.torque,
        "momentum": solution.momentum,
        "attitude": solution.attitude,
        "co_momentum": solution.co_momentum,
        "zeta": solution.zeta,
        "multipliers": _beside(solution.torque_multipliers, solution.momentum_multipliers),
        "active": _beside(solution.active_torque, solution.active_momentum),
        "inertia": problem.body.inertia,
        "time_step": np.array(problem.body.time_step),
        "limits": problem.limits,
        "start": problem.start,
        "goal": problem.goal,
        "start_momentum": problem.start_momentum,
        "goal_momentum": problem.goal_momentum,
        "status": np.array(int(solution.status)),
        "min_curvature": np.array(solution.min_curvature),
        "iterations": np.array(solution.iterations),
        "tried": np.array(json.dumps(solution.tried)),
        "reason": np.array(solution.reason),
        "scenario": np.array(scenario),
        "scenario_defaults": np.array(defaults),
    }
    with whole_file(target) as file, file.open("wb") as stream:
        np.savez_compressed(stream, **arrays)
    return target


def load_plan(path: str | Path) -> StoredPlan:
    """Read a file of `save_plan`, and evaluate the conditions of the plan once more.

    Raises
    ------
    RecordingError
        If it is missing, damaged, no such file, or its numbers are no optimal plan.
    """
    need = "a .npz file written by `gnc plan --out`"
    try:
        found = _members(Path(path))
        solution = _solution(found)
    except UNREADABLE as error:
        raise RecordingError(
            f"{path}: received {_unreadable(error)}; required {need}; plan again"
        ) from error
    if not solution.residuals.largest <= _TOLERANCE:
        off = f"{solution.residuals.largest:.3g} instead of {_TOLERANCE:g} at most"
        raise RecordingError(
            f"{path}: received a plan that violates its conditions by {off}; required {need}; "
            "plan again"
        )
    return StoredPlan(solution, str(found["scenario"]), str(found["scenario_defaults"]))


def _unreadable(error: Exception) -> str:
    """Return in words what is read in place of a plan."""
    if isinstance(error, KeyError):
        (name,) = error.args
        return "a file that is no plan of gnc plan" if name == _KIND else f"a plan without {name}"
    reason = getattr(error, "strerror", None) or " ".join(str(error).split())
    return f"a file that cannot be read as a plan ({reason})"


def difference(stored: AttitudeTransfer, wanted: AttitudeTransfer) -> str:
    """Return what of a stored transfer differs from the one that is wanted, in words.

    Empty where nothing does: the stored plan is one of the transfer wanted.
    """
    h, own = stored.body.time_step, stored.limits
    for what, ours, theirs, unit in (
        ("inertia", stored.body.inertia, wanted.body.inertia, "kg m^2"),
        ("control period", h, wanted.body.time_step, "s"),
        ("duration", stored.duration, wanted.duration, "s"),
        ("torque bounds", own[:2], wanted.limits[:2], "N m"),
        ("momentum bounds", own[2:], wanted.limits[2:], "N m s"),
        ("initial momentum", stored.start_momentum, wanted.start_momentum, "N m s"),
    ):
        if not np.allclose(ours, theirs, rtol=_SAME, atol=_SAME * _size(theirs)):
            return f"{what} {_shown(ours)} {unit}, not {_shown(theirs)}"
    for what, first, second in (
        ("initial attitude", stored.start, wanted.start),
        ("target", stored.goal, wanted.goal),
    ):
        angle = lie.angle_between(first, second)
        if angle > _SAME:
            return f"another {what}, {math.degrees(angle):.6g} deg off"
    return ""


def _size(values: Any) -> float:
    finite = np.abs(np.asarray(values, dtype=np.float64))
    return float(finite[np.isfinite(finite)].max(initial=0.0))


def _shown(values: Any) -> str:
    numbers = np.asarray(values, dtype=np.float64)
    if numbers.shape == (3, 3) and np.array_equal(numbers, np.diag(np.diag(numbers))):
        return f"diag({', '.join(f'{number:.12g}' for number in np.diag(numbers))})"
    text = np.array2string(numbers, separator=", ", formatter={"float_kind": lambda x: f"{x:.12g}"})
    return " ".join(text.split())


def _beside(torque: NDArray[Any], momentum: NDArray[Any]) -> NDArray[Any]:
    """Return (N, 3) and (N+1, 3) numbers as one array (N+1, 6)."""
    return np.hstack([np.vstack([torque, np.zeros((1, 3), dtype=torque.dtype)]), momentum])


def _members(path: Path) -> dict[str, Any]:
    # One array at a time: np.load leaves the file open where the archive is torn.
    with path.open("rb") as stream, zipfile.ZipFile(stream) as members:
        found = {}
        for name in members.namelist():
            with members.open(name) as member:
                key = name.removesuffix(".npy")
                found[key] = np.lib.format.read_array(member, allow_pickle=False)
    if str(found[_KIND]) != _VEHICLE:
        raise ValueError(f"of vehicle {found[_KIND]}, not {_VEHICLE}")
    return found


def _solution(found: dict[str, Any]) -> TransferSolution:
    """Return the solution in a file; what its arrays do not fit to is refused."""
    torque = _of_shape(found, "torque", (-1, 3))
    n = len(torque)
    limits = _of_shape(found, "limits", (4, 3))
    momentum = _of_shape(found, "momentum", (n + 1, 3))
    multipliers = _of_shape(found, "multipliers", (n + 1, 6))
    active = _of_shape(found, "active", (n + 1, 6)).astype(np.int64)
    co_momentum, zeta = _of_shape(found, "co_momentum", (n, 3)), _of_shape(found, "zeta", (3,))
    try:
        problem = AttitudeTransfer(
            body=RigidBody(found["inertia"], float(found["time_step"])),
            n_steps=n,
            start=found["start"],
            goal=found["goal"],
            start_momentum=found["start_momentum"],
            goal_momentum=found["goal_momentum"],
            torque=(limits[0], limits[1]),
            momentum=(limits[2], limits[3]),
        )
        duals = multipliers[:-1, :3], multipliers[:, 3:]
        residuals, attitude = evaluate(problem, torque, momentum, co_momentum, zeta, *duals)
    except GncError as error:
        raise ValueError(str(error)) from error
    return TransferSolution(
        problem=problem,
        status=Status(int(found["status"])),
        torque=torque,
        momentum=momentum,
        attitude=attitude,
        co_momentum=co_momentum,
        zeta=zeta,
        torque_multipliers=duals[0],
        momentum_multipliers=duals[1],
        active_torque=active[:-1, :3],
        active_momentum=active[:, 3:],
        cost=0.5 * float(np.sum(torque**2)),
        residuals=residuals,
        min_curvature=float(found["min_curvature"]),
        iterations=int(found["iterations"]),
        tried=tuple(
            Tried(name, Status(status), cost, iterations)
            for name, status, cost, iterations in json.loads(str(found["tried"]))
        ),
        reason=str(found["reason"]),
        solve_time=math.nan,
    )


def _of_shape(found: dict[str, Any], name: str, shape: tuple[int, ...]) -> Array:
    """Return an array of finite numbers; bounds may be infinite."""
    array = np.asarray(found[name], dtype=np.float64)
    fits = len(array.shape) == len(shape) and all(
        want in (-1, size) for want, size in zip(shape, array.shape, strict=True)
    )
    known = ~np.isnan(array) if name == "limits" else np.isfinite(array)
    if not (fits and known.all()):
        raise ValueError(f"{name} of shape {array.shape}, or not finite")
    return read_only(array)
