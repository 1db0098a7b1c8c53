"""Fly Gupta's Case I through the node graph, audit it, draw it, compare it with the paper's.

The steps of `make demo`; each can be done by hand with the commands printed. Case I is section IV-A
of R. Gupta et al., "Constrained spacecraft attitude control on SO(3) using fast nonlinear model
predictive control", American Control Conference 2015; its times are from Table I and the text.
"""

from __future__ import annotations

import dataclasses
import itertools
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.loop.trajectory import Trajectory
from spacecraft_gnc.recording.reader import load_run
from spacecraft_gnc.scenario import load

ROOT = Path(__file__).parents[1]
SCENARIO = Path("config/gupta2015_case1.yaml")
IPOPT = ROOT / "test" / "data" / "gupta2015_case1_ipopt.npz"
GNC = Path(".venv/bin/gnc")
ROW = "  {:<28} {:>14} {:>14} {:>14}"
PLOTTED = "plotted only"
TITLE = ["--title", "Gupta et al. (2015), Case I"]


def main() -> int:
    """Run the demonstration; return its exit code."""
    started = time.monotonic()
    folder = next(path for n in itertools.count(1) if not (path := Path(f"runs/demo-{n}")).exists())
    figures = folder / "figures"
    for command in (
        ["launch", str(SCENARIO), "--out", str(folder)],
        ["audit", str(folder)],
        ["report", str(folder), "--out", str(folder / "report.html"), *TITLE],
        ["plot", str(folder / "bag"), "--out", str(figures), "--format", "png", "--quiet", *TITLE],
    ):
        print(f"\n$ gnc {' '.join(command)}", flush=True)
        code = subprocess.run(
            [sys.executable, "-m", "spacecraft_gnc", *command], check=False
        ).returncode
        if code != 0:
            return code
    compare(load_run(folder / "bag").trajectory)
    print(
        f"""
The flight lies in {folder}/:
  report.html              everything about it, for a browser: attitude in 3-D, curves, audit
  figures/overview.png     the whole flight in one picture; others lie beside it
  bag/                     every message, for any reader of ROS 2 bags
  logs/                    what each node said
The demonstration took {time.monotonic() - started:.0f} s.

Try next:
  {GNC} launch {SCENARIO} --set nmpc_controller.max_torque=0.005
  {GNC} simulate {SCENARIO} --set "plant.initial_rotation_vector=[0.0, 0.0, 3.0]"
  {GNC} launch {SCENARIO} --mode free_run --rate 10
  {GNC} replay {folder} --method neighboring_extremal
  {GNC} view {folder}
and edit a copy of {SCENARIO}: `{GNC} check COPY.yaml` tells what it lacks."""
    )
    return 0


def compare(flight: Trajectory) -> None:
    """Print the flight beside the paper's and beside a solution by CasADi and IPOPT."""
    scenario = load(ROOT / SCENARIO)
    peer = with_states_of(IPOPT, flight)
    ours, ipopt = (summarize(trajectory, scenario) for trajectory in (flight, peer))
    settled = [(f"under {x} deg for good from", f"settle_time_{x}deg") for x in (5, 1)]
    rows = [
        ("", "this flight", "paper", "IPOPT"),
        ("control steps", ours["steps"], 375, ipopt["steps"]),
        ("largest torque", newton_metres(ours), "limit 0.01 N m", newton_metres(ipopt)),
        ("error at 150 s", degrees(ours), PLOTTED, degrees(ipopt)),
        *((name, f"{ours[key]:g} s", PLOTTED, f"{ipopt[key]:g} s") for name, key in settled),
        ("sum of stage costs", f"{ours['cost']:.9f}", "-", f"{ipopt['cost']:.9f}"),
        ("all solves together", f"{flight.solve_time.sum():.3f} s", "38.22 s", "-"),
        ("longest solve", f"{flight.solve_time.max():.4f} s", "0.44 s", "-"),
    ]
    print("\nCase I: this flight, the paper's (2015, MATLAB on 3.6 GHz) and CasADi with IPOPT")
    for row in rows:
        print(ROW.format(*row).rstrip())
    difference = np.abs(flight.torque - peer.torque).max()
    print(f"The torques differ from IPOPT's by at most {difference:.1e} N m.")


def with_states_of(path: Path, flight: Trajectory) -> Trajectory:
    """Return ``flight`` with the attitudes, momenta and torques stored in ``path``."""
    with np.load(path) as stored:
        return dataclasses.replace(
            flight,
            attitude=stored["attitude"][:-1],
            momentum=stored["momentum"][:-1],
            torque=stored["torque"],
            final_attitude=stored["attitude"][-1],
            final_momentum=stored["momentum"][-1],
        )


def newton_metres(metrics: dict[str, float]) -> str:
    """Return the largest torque as text."""
    return f"{metrics['max_torque']:.8f} N m"


def degrees(metrics: dict[str, float]) -> str:
    """Return the error at the end as text."""
    return f"{metrics['final_error_deg']:.5f} deg"


if __name__ == "__main__":
    sys.exit(main())
