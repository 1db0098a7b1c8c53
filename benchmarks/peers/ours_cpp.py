"""Time the method in plain C++ (benchmarks/floor): the floor under the compiled kernels."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
from common import Problem, Vector, result

SOURCES = Path(__file__).resolve().parents[1] / "floor"


def build(source: str, target: str, *options: str) -> Path:
    """Compile one of the sources into the working directory."""
    compiler = shutil.which("g++")
    if compiler is None:
        sys.exit("g++ is absent")
    flags = ["-std=c++17", "-O3", "-march=native", *options]
    path = Path.cwd() / target
    subprocess.run([compiler, *flags, str(SOURCES / source), "-o", str(path)], check=True)
    return path


def settings(problem: Problem) -> Vector:
    """Return inertia, h, weights, limit, penalty, horizon, tolerance, seconds, as it reads them."""
    p = problem
    weights = (p.stage_attitude, p.stage_momentum, p.stage_torque)
    weights += (p.terminal_attitude, p.terminal_momentum)
    limits = (p.max_torque, p.torque_penalty, p.horizon, p.tolerance, p.seconds)
    return np.array([*np.ravel(p.inertia), p.time_step, *weights, *limits])


def run(problem: Problem) -> list[list[float]]:
    """Return a row of seconds, u_0, iterations, solved for each solve."""
    numbers = [f"{x!r}" for x in settings(problem).tolist()]
    numbers[17] = str(problem.horizon)
    states = np.hstack([problem.attitude.reshape(-1, 9), problem.momentum])
    lines = [" ".join(numbers), *(" ".join(repr(x) for x in row) for row in states.tolist())]
    Path("states.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    command = [str(build("floor.cpp", "floor")), "states.txt"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return [[float(x) for x in line.split()] for line in done.stdout.splitlines()]


def main() -> None:
    """Read the problem, run the program, write the result."""
    problem = Problem.read(Path(sys.argv[1]))
    rows, count = run(problem), len(problem.attitude)
    rows = rows[count:] or rows  # the first pass is a warm-up
    wall = [row[0] for row in rows]
    account = result(
        "first-order conditions of the penalized problem by the backward sweep, timed inside C++",
        f"residual {problem.tolerance:g}",
        wall,
        wall,
        [row[1:4] for row in rows],
        [int(row[4]) for row in rows],
        [row[5] == 1.0 for row in rows],
        problem,
    )
    Path(sys.argv[2]).write_text(json.dumps(account), encoding="utf-8")


if __name__ == "__main__":
    main()
