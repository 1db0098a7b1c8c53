"""Random problems at every scale, judged by an independent model and compared with IPOPT.

    python benchmarks/random_problems/run.py [--count 5000] [--first 0] [--jobs 2] [--json FILE]
    python benchmarks/random_problems/run.py --only SEED

Problem SEED is drawn without units (N 1 to 60, spheres, rods and plates, 0 to 4 zones, weights over
decades, soft to hard penalties, any attitude, 2 to 4 actuators) and solved in units that make its
inertia 1e-6 to 1e8 kg m^2 and its limit 1e-6 to 1e3 N m; every odd one once more in other units.
A model in CasADi (`model.py`, in the environment of the peers: `make bench` makes it) takes one
Newton step from what we return: a CONVERGED solve is false where the step is more than 1e-8 of the
largest control, or the second derivative not positive. IPOPT solves the same problem from the free
motion. Its results are kept in `--keep` and not made again. Exit code 1 where there is a fault.
"""

from __future__ import annotations

import argparse
import gzip
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PYTHON = ROOT / ".venv-peers" / "bin" / "python"
THREADS = ("OMP", "OPENBLAS", "MKL", "BLIS", "NUMEXPR", "NUMBA")

from draw import VERSION, draw  # noqa: E402
from judge import Verdict, judge, lines, report  # noqa: E402
from ours import solved, within_reach  # noqa: E402

from spacecraft_gnc.ocp import ShootingOptions  # noqa: E402


def solve_all(seeds: list[int], options: ShootingOptions, given: Path) -> dict[int, Any]:
    """Solve the problems, write them with our controls for the model; return our accounts."""
    accounts = {}
    with given.open("w", encoding="utf-8") as file:
        for seed in seeds:
            problem = draw(seed)
            account = accounts[seed] = solved(problem, options) | {"horizon": problem.horizon}
            ours = account.get("controls") if account.get("status") == "CONVERGED" else None
            print(json.dumps({"drawn": problem.plain(), "controls": ours}), file=file)
    return accounts


def judge_all(given: Path, ipopt: Path, folder: Path, jobs: int, count: int, limit: float) -> bool:
    """Have the model judge the problems in ``jobs`` processes; return whether all were reached."""
    environment = os.environ | {f"{name}_NUM_THREADS": "1" for name in THREADS}
    for name in ("PYTHONPATH", "LD_LIBRARY_PATH"):  # ROS puts its libraries there
        environment.pop(name, None)
    parts = []
    for part in range(jobs):
        command = [str(PYTHON), str(HERE / "model.py"), str(given), str(ipopt)]
        command += [str(folder / f"checks{part}.jsonl"), str(part), str(jobs)]
        log = (folder / f"log{part}").open("w", encoding="utf-8")
        parts.append(subprocess.Popen(command, env=environment, stdout=log, stderr=log))
    begun = time.monotonic()
    while any(part.poll() is None for part in parts):
        time.sleep(0.2)
        if sys.stderr.isatty():
            done = sum(_count(folder / f"log{part}") for part in range(jobs))
            print(f"\r{done} of {count} judged", end="", file=sys.stderr)
        if time.monotonic() - begun > limit:
            for part in parts:
                part.terminate()
    for number, part in enumerate(parts):
        if part.returncode > 0:
            sys.exit((folder / f"log{number}").read_text(encoding="utf-8"))
    return all(part.returncode == 0 for part in parts)


def _count(log: Path) -> int:
    return len(log.read_text(encoding="utf-8").splitlines())


def main() -> int:
    """Solve, judge, print what came of it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, default=5000)
    parser.add_argument("--first", type=int, default=0, metavar="SEED")
    parser.add_argument("--only", type=int, metavar="SEED", help="this problem, in full")
    parser.add_argument("--jobs", type=int, default=2, help="processes of the model")
    parser.add_argument("--limit", type=float, default=7200.0, metavar="S", help="for the model")
    parser.add_argument("--max-iterations", type=int, default=ShootingOptions().max_iterations)
    parser.add_argument("--keep", type=Path, default=ROOT / ".random_problems", metavar="FOLDER")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write figures and faults here")
    parser.add_argument("--write", type=Path, metavar="FILE", help="write IPOPT's optima here")
    wanted = parser.parse_args()
    if not PYTHON.exists():
        sys.exit(".venv-peers is absent: make bench installs it")
    one = wanted.only is not None
    seeds = [wanted.only] if one else list(range(wanted.first, wanted.first + wanted.count))
    folder: Path = wanted.keep
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("checks*.jsonl"):
        old.unlink()
    begun = time.monotonic()
    options = ShootingOptions(max_iterations=wanted.max_iterations)
    accounts = solve_all(seeds, options, folder / "problems.jsonl")
    spent = time.monotonic() - begun
    ipopt = folder / f"ipopt{VERSION}.jsonl"
    jobs = 1 if one else wanted.jobs
    whole = judge_all(folder / "problems.jsonl", ipopt, folder, jobs, len(seeds), wanted.limit)
    checks = [row for path in folder.glob("checks*.jsonl") for row in lines(path)]
    rows = [within_reach(row) for row in lines(ipopt) if row["seed"] in accounts]
    verdict = judge(accounts, checks, rows)
    print(report(verdict, spent))
    if not whole:
        print(f"the model was stopped after {wanted.limit:g} s: the rest was not judged")
    if one:
        _tell(wanted.only, verdict)
    if wanted.write:
        write(wanted.write, verdict)
    if wanted.json:
        wanted.json.write_text(json.dumps(verdict.plain(), indent=1) + "\n", encoding="utf-8")
    return 1 if verdict.faults or not whole else 0


def write(path: Path, verdict: Verdict) -> None:
    """Write the problems that IPOPT solves, with its optima, for the tests."""
    rows = [
        {"drawn": draw(seed).plain()} | {key: found[key] for key in ("controls", "cost", "moved")}
        for seed, account in verdict.accounts.items()
        if (found := account["ipopt"])["solved"]
    ]
    with path.open("wb") as raw, gzip.GzipFile("", "wb", fileobj=raw, mtime=0) as file:
        file.write(json.dumps(rows).encode())


def _tell(seed: int, verdict: Verdict) -> None:
    """Print one problem and what was made of it."""
    for name, value in draw(seed).plain().items():
        print(f"{name} = {value}")
    for name, account in verdict.accounts[seed].items():
        print(f"{name}: {account}")


if __name__ == "__main__":
    sys.exit(main())
