"""What every peer shares: the problem it reads, the clock it is timed by, the result it writes.

A peer is a script ``PEER.py PROBLEM RESULT [VARIANT]``, run in a process of its own by `run.py`. It
needs nothing from the package (but `ours.py`), so that it runs in any virtual environment.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from time import perf_counter, process_time
from typing import Any, Protocol

import numpy as np

Vector = np.ndarray


@dataclass
class Problem:
    """Case I of Gupta et al. 2015, numbers as in config/gupta2015_case1.yaml, and states to solve.

    Weights are scalars s for s I. ``torque`` holds the reference first torques, NaN if unknown.
    A peer is timed over the states again and again until ``seconds`` have passed.
    """

    attitude: Vector
    momentum: Vector
    torque: Vector
    inertia: list[list[float]] = field(
        default_factory=lambda: [[1.0, 0.0, 0.0], [0.0, 0.8, 0.0], [0.0, 0.0, 0.8]]
    )
    time_step: float = 0.4
    horizon: int = 5
    stage_attitude: float = 0.01
    stage_momentum: float = 0.01
    stage_torque: float = 1.0
    terminal_attitude: float = 0.01
    terminal_momentum: float = 0.01
    max_torque: float = 0.01
    torque_penalty: float = 1e10
    tolerance: float = 1e-12  # of solvers of the first-order conditions
    seconds: float = 2.0

    def write(self, path: Path) -> None:
        """Write states and settings as JSON."""
        numbers = asdict(self)
        for name in ("attitude", "momentum", "torque"):
            numbers[name] = np.asarray(numbers[name]).tolist()
        path.write_text(json.dumps(numbers), encoding="utf-8")

    @classmethod
    def read(cls, path: Path) -> Problem:
        """Read what `write` wrote."""
        numbers = json.loads(path.read_text(encoding="utf-8"))
        for name in ("attitude", "momentum", "torque"):
            numbers[name] = np.array(numbers[name])
        return cls(**numbers)


class Peer(Protocol):
    """One solver; it keeps its own warm start from one solve to the next."""

    formulation: str
    tolerance: str

    def reset(self) -> None:
        """Forget the warm start."""

    def solve(self, attitude: Vector, momentum: Vector) -> Vector:
        """Return the first torque [N m]; this is what is timed."""

    def outcome(self) -> tuple[int, bool]:
        """Return the iterations of the last solve, and whether the solver calls it solved."""


def quaternion(attitude: Vector) -> list[float]:
    """Vector part of the unit quaternion with positive scalar part (turns below half a turn)."""
    ((a, b, c), (d, e, f), (g, h, i)) = attitude.tolist()
    s = 0.5 / math.sqrt(1.0 + a + e + i)
    return [s * (h - f), s * (c - g), s * (d - b)]


def main(make: Callable[..., Peer]) -> None:
    """Time the peer that ``make(problem, *variant)`` builds, as the command line says."""
    problem = Problem.read(Path(sys.argv[1]))
    peer = make(problem, *sys.argv[3:])
    Path(sys.argv[2]).write_text(json.dumps(time_peer(peer, problem)), encoding="utf-8")


def time_peer(peer: Peer, problem: Problem) -> dict[str, Any]:
    """Visit the states in order, each pass from a cold start; times in seconds.

    The first pass is a warm-up unless it is the only one.
    """
    wall, cpu, torques, iterations, solved = [], [], [], [], []
    begun = perf_counter()
    while not wall or perf_counter() - begun < problem.seconds:
        peer.reset()
        for attitude, momentum in zip(problem.attitude, problem.momentum, strict=True):
            cpu_start, start = process_time(), perf_counter()
            u = peer.solve(attitude, momentum)
            wall.append(perf_counter() - start)
            cpu.append(process_time() - cpu_start)
            steps, ok = peer.outcome()
            torques.append([float(x) for x in u])
            iterations.append(int(steps))
            solved.append(bool(ok))
    first = len(problem.attitude) if len(wall) > len(problem.attitude) else 0
    lists = (numbers[first:] for numbers in (wall, cpu, torques, iterations, solved))
    return result(peer.formulation, peer.tolerance, *lists, problem=problem)


def result(
    formulation: str,
    tolerance: str,
    wall: list[float],
    cpu: list[float],
    torques: list[list[float]],
    iterations: list[int],
    solved: list[bool],
    problem: Problem,
) -> dict[str, Any]:
    """Return the account of a peer; lists run over the passes and, within one, the states."""
    count = len(problem.attitude)
    difference = np.array(torques).reshape(-1, count, 3) - problem.torque
    good = np.array(solved).reshape(-1, count)
    errors = np.abs(difference).max(axis=2)
    largest = errors[good].max() if good.any() else math.nan
    return {
        "formulation": formulation,
        "tolerance": tolerance,
        "states": count,
        "passes": len(wall) // count,
        "wall": wall,
        "cpu": cpu,
        "iterations": iterations,
        "solved": int(good[0].sum()),
        "error": _number(largest),
        "error_unsolved": _number(errors[~good].max() if not good.all() else 0.0),
        "torques": torques[:count],
    }


def _number(x: float) -> float | None:
    """``x``, or None where it is not a number: JSON has no NaN."""
    return float(x) if math.isfinite(x) else None


def warm(account: dict[str, Any], what: str) -> Vector:
    """Return ``account[what]`` of all solves but the cold one at the start of each pass."""
    return np.array(account[what]).reshape(-1, account["states"])[:, 1:].ravel()


def cold(account: dict[str, Any], what: str) -> Vector:
    """Return ``account[what]`` of the cold solve at the start of each pass."""
    return np.array(account[what]).reshape(-1, account["states"])[:, 0]
