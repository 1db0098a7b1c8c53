"""Demonstration: a published case and a slew past two zones, flown through the node graph.

The steps of `make demo`; the printed commands repeat them by hand. Case I is section IV-A
of R. Gupta et al., "Constrained spacecraft attitude control on SO(3) using fast nonlinear model
predictive control", American Control Conference 2015; its times are from Table I and the text.
"""

from __future__ import annotations

import dataclasses
import itertools
import shlex
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.analysis.reader import load_run
from spacecraft_gnc.loop.flight import Flight
from spacecraft_gnc.scenario import load

ROOT = Path(__file__).parents[1]
CASE1 = Path("config/gupta2015_case1.yaml")
SUN_MOON = Path("config/sun_moon.yaml")
PD = Path("config/sun_moon_pd.yaml")
IPOPT = ROOT / "test" / "data" / "gupta2015_case1_ipopt.npz"
GNC = Path(".venv/bin/gnc")
ROW = "  {:<28} {:>14} {:>14} {:>14}"
PLOTTED = "plotted only"
TITLE = "100 deg past Sun and Moon with 0.01 N m"


def main() -> int:
    """Run the demonstration; return its exit code."""
    started = time.monotonic()
    folder = next(path for n in itertools.count(1) if not (path := Path(f"runs/demo-{n}")).exists())
    case1, governed, pd = folder / "case1", folder / "governed-NMPC", folder / "PD.npz"
    picture, report = folder / "flight.gif", folder / "report.html"
    try:
        gnc("launch", CASE1, "--out", case1)
        gnc("audit", case1)
        compare_with_paper(load_run(case1 / "bag").trajectory)
        gnc("launch", SUN_MOON, "--out", governed)
        gnc("audit", governed)
        gnc("simulate", PD, "--out", pd, "--quiet")
        gnc("plot", governed, pd, "--animate", picture, "--title", TITLE)
        gnc("report", governed, "--out", report)
    except subprocess.CalledProcessError as error:
        return error.returncode
    compare_with_pd(load_run(governed / "bag").trajectory, load_run(pd).trajectory)
    print(
        f"""
The flights lie in {folder}/:
  flight.gif               the turn past Sun and Moon beside a PD's, moving
  report.html              everything about it, for a browser: attitude in 3-D, curves, audit
  case1/, governed-NMPC/   of each flight every message (bag/) and what each node said (logs/)
The demonstration took {time.monotonic() - started:.0f} s.

Try next:
  {GNC} launch {SUN_MOON} --set reference_governor.governor=none
  {GNC} launch {CASE1} --set nmpc_controller.horizon=40
  {GNC} launch {CASE1} --mode free_run --rate 10
  {GNC} replay {case1} --method neighboring_extremal
  {GNC} view {governed}
and edit a copy of {SUN_MOON}: `{GNC} check COPY.yaml` tells what it lacks."""
    )
    return 0


def gnc(*arguments: str | Path) -> None:
    """Print and run a command; raise CalledProcessError if it fails."""
    command = list(map(str, arguments))
    print(f"\n$ gnc {shlex.join(command)}", flush=True)
    subprocess.run([sys.executable, "-m", "spacecraft_gnc", *command], check=True)


def compare_with_pd(governed: Flight, pd: Flight) -> None:
    """Compare the flight past two zones with that of the PD."""
    both = [summarize(flight, load(ROOT / PD)) for flight in (governed, pd)]
    rows = [
        ("", "governed NMPC", "PD"),
        *(
            (
                f"least angle to the {zone}",
                *(f"{m['zone_margin_deg'][zone]:+.2f} deg" for m in both),
            )
            for zone in both[0]["zone_margin_deg"]
        ),
        ("largest torque", *map(newton_meters, both)),
        ("under 0.1 deg for good from", *(f"{m['settle_time_0.1deg']:g} s" for m in both)),
    ]
    print("\nPast two zones, negative inside: this flight and a PD with the same torque limit")
    for row in rows:
        print(ROW.format(*row, "").rstrip())


def compare_with_paper(flight: Flight) -> None:
    """Compare the flight with the paper's and with a solution by CasADi and IPOPT."""
    scenario = load(ROOT / CASE1)
    peer = with_states_of(IPOPT, flight)
    ours, ipopt = (summarize(trajectory, scenario) for trajectory in (flight, peer))
    settled = [(f"under {x} deg for good from", f"settle_time_{x}deg") for x in (5, 1)]
    rows = [
        ("", "this flight", "paper", "IPOPT"),
        ("control steps", ours["steps"], 375, ipopt["steps"]),
        ("largest torque", newton_meters(ours), "limit 0.01 N m", newton_meters(ipopt)),
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


def with_states_of(path: Path, flight: Flight) -> Flight:
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


def newton_meters(metrics: dict[str, Any]) -> str:
    """Return the largest torque as text."""
    return f"{metrics['max_torque']:.8f} N m"


def degrees(metrics: dict[str, Any]) -> str:
    """Return the error at the end as text."""
    return f"{metrics['final_error_deg']:.5f} deg"


if __name__ == "__main__":
    sys.exit(main())
