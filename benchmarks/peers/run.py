"""Time this project's solver beside others on the same problem, one process after another.

``python benchmarks/peers/run.py [--json FILE] [--only NAME ...] [--no-sweep]``; ``gnc bench`` runs
it too. ``make bench`` installs the others beside ``.venv``; one that is absent is skipped with a
line. Every process has one thread, and visits the same states in order, each solver warm-started
from its own last solution. Errors are those of the first torque against the reference optimum
(test/data/README.md). Machines are shared and noisy: quote medians.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from common import Problem, cold, warm

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
REFERENCE = ROOT / "test" / "data" / "gupta2015_case1_ipopt.npz"
HORIZONS = (5, 10, 20, 40, 60, 80, 100)
TIME_LIMIT = 900  # [s] for one process; SLSQP needs a few minutes
THREADS = ("OMP", "OPENBLAS", "MKL", "BLIS", "NUMEXPR", "NUMBA")


@dataclass(frozen=True)
class Entry:
    """Name of a peer, script and variant, and the environment it lives in ("": this one)."""

    name: str
    script: str
    home: str = ""
    variant: str = ""
    sweep: bool = False

    @property
    def python(self) -> Path:
        """Interpreter of its environment."""
        return ROOT / self.home / "bin" / "python" if self.home else Path(sys.executable)


PEERS = (
    Entry("ours", "ours.py", sweep=True),
    Entry("ours in C++ (floor)", "ours_cpp.py", sweep=True),
    Entry("acados SQP, exact Hessian", "acados_sqp.py", ".venv-acados", "exact", sweep=True),
    Entry("acados SQP, Gauss-Newton", "acados_sqp.py", ".venv-acados", "gauss_newton"),
    Entry("acados RTI", "acados_sqp.py", ".venv-acados", "rti"),
    Entry("CasADi + IPOPT", "ipopt.py", ".venv-peers", sweep=True),
    Entry("CasADi sqpmethod", "sqpmethod.py", ".venv-peers"),
    Entry("crocoddyl FDDP", "crocoddyl_fddp.py", ".venv-peers"),
    Entry("scipy fsolve", "fsolve.py"),
    Entry("scipy SLSQP", "slsqp.py"),
)


def problem_set(seconds: float, horizon: int = 5, states: int | None = None) -> Problem:
    """Return Case I with states of its reference closed loop; the reference holds for N = 5."""
    with np.load(REFERENCE) as reference:
        attitude, momentum = reference["attitude"][:-1], reference["momentum"][:-1]
        torque = reference["torque"] if horizon == 5 else np.full(momentum.shape, np.nan)
        keep = slice(states)
        numbers = (x[keep] for x in (attitude, momentum, torque))
        return Problem(*numbers, horizon=horizon, seconds=seconds)


def run_peer(entry: Entry, problem: Problem) -> dict[str, Any] | str:
    """Return the account of one peer, or why there is none."""
    if not entry.python.exists():
        return f"{entry.home} is absent (make bench installs it)"
    environment = os.environ | {f"{name}_NUM_THREADS": "1" for name in THREADS}
    environment["PYTHONPATH"] = str(ROOT)
    if entry.home:  # ROS puts its libraries there
        del environment["PYTHONPATH"]
        environment.pop("LD_LIBRARY_PATH", None)
    with tempfile.TemporaryDirectory() as folder:  # acados and g++ write where they are started
        given, made = Path(folder) / "problem.json", Path(folder) / "result.json"
        problem.write(given)
        command = [str(entry.python), str(HERE / entry.script), str(given), str(made)]
        command += [entry.variant] if entry.variant else []
        try:
            done = subprocess.run(
                command,
                cwd=folder,
                env=environment,
                capture_output=True,
                text=True,
                errors="replace",
                timeout=TIME_LIMIT,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return f"not finished after {TIME_LIMIT} s"
        if done.returncode != 0 or not made.is_file():
            said = [line for line in done.stderr.splitlines() if line.strip()]
            return said[-1].strip() if said else f"exit code {done.returncode}"
        account: dict[str, Any] = json.loads(made.read_text(encoding="utf-8"))
        return account


def summary(account: dict[str, Any]) -> dict[str, Any]:
    """Return the figures of a peer without the single times."""
    wall, steps = warm(account, "wall"), warm(account, "iterations")
    kept = ("formulation", "tolerance", "states", "passes", "solved", "error", "error_unsolved")
    return {key: account[key] for key in kept} | {
        "median": float(np.median(wall)),
        "p99": float(np.quantile(wall, 0.99)),
        "max": float(wall.max()),
        "cold": float(np.median(cold(account, "wall"))),
        "cpu_median": float(np.median(warm(account, "cpu"))),
        "iterations_median": float(np.median(steps)),
        "iterations_max": int(steps.max()),
        "iterations_cold": int(cold(account, "iterations")[0]),
    }


def compare(entries: list[Entry], seconds: float) -> dict[str, Any]:
    """Run the peers along the closed loop and print a row for each as it comes in."""
    figures: dict[str, Any] = {}
    print("| solver | median us | 99 % | longest | to ours | iterations | solved | error N m |")
    print("|---|---|---|---|---|---|---|---|")
    for entry in entries:
        account = run_peer(entry, problem_set(seconds))
        if isinstance(account, str):
            print(f"{entry.name}: skipped, {account}", flush=True)
            continue
        row = figures[entry.name] = summary(account)
        if "ours" in figures:
            row["ratio"] = row["median"] / figures["ours"]["median"]
        print(_row(entry.name, row), flush=True)
    return figures


def sweep(entries: list[Entry], seconds: float) -> dict[str, Any]:
    """Return the cost against the horizon: a cold solve, and a warm one a step later."""
    figures: dict[str, Any] = {}
    print("\n| solver | N | cold us (iterations) | warm us (iterations) | difference N m |")
    print("|---|---|---|---|---|")
    found: dict[int, Any] = {}  # of the first solver that solved both states
    for entry in (entry for entry in entries if entry.sweep):
        for horizon in HORIZONS:
            account = run_peer(entry, problem_set(seconds, horizon, states=2))
            if isinstance(account, str):
                print(f"{entry.name}, N = {horizon}: skipped, {account}", flush=True)
                continue
            row = summary(account)
            torques = np.array(account["torques"])
            if row["solved"] == row["states"]:
                found.setdefault(horizon, torques)
            row["difference"] = _difference(torques, found.get(horizon))
            figures.setdefault(entry.name, {})[str(horizon)] = row
            print(_sweep_row(entry.name, horizon, row), flush=True)
    return figures


def _sweep_row(name: str, horizon: int, row: dict[str, Any]) -> str:
    cold_solve = f"{1e6 * row['cold']:.4g} ({row['iterations_cold']})"
    warm_solve = f"{1e6 * row['median']:.4g} ({row['iterations_median']:.0f})"
    known = "" if row["difference"] is None else f"{row['difference']:.0e}"
    known = known if row["solved"] == row["states"] else "not solved"
    return f"| {name} | {horizon} | {cold_solve} | {warm_solve} | {known} |"


def _difference(torques: Any, others: Any) -> float | None:
    return None if others is None else float(np.abs(torques - others).max())


def _row(name: str, row: dict[str, Any]) -> str:
    median, p99, longest = (f"{1e6 * row[key]:.4g}" for key in ("median", "p99", "max"))
    ratio = f"{row['ratio']:.3g}" if "ratio" in row else ""
    steps = f"{row['iterations_median']:.0f}, at most {row['iterations_max']}"
    error = "none" if row["error"] is None else f"{row['error']:.0e}"
    solved = f"{row['solved']} of {row['states']}"
    return f"| {name} | {median} | {p99} | {longest} | {ratio} | {steps} | {solved} | {error} |"


def main() -> None:
    """Do what the command line says."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures here")
    parser.add_argument(
        "--only", nargs="+", metavar="NAME", help="solvers whose name has this in it"
    )
    parser.add_argument("--no-sweep", action="store_true", help="leave the horizons 5..100 out")
    parser.add_argument("--seconds", type=float, default=2.0, help="spent on each, at least")
    options = parser.parse_args()
    chosen = [
        entry
        for entry in PEERS
        if not options.only or any(word in entry.name for word in options.only)
    ]
    figures = {"case1": compare(chosen, options.seconds)}
    if not options.no_sweep:
        figures["horizons"] = sweep(chosen, options.seconds)
    if options.json:
        options.json.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
