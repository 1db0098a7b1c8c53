"""``gnc bench``: how fast solver, integrator, closed loop and graph are on this machine."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any

import typer

from spacecraft_gnc.cli._common import QuietOption, RunFailed, json_able, print_table
from spacecraft_gnc.cli._progress import Progress, show_progress
from spacecraft_gnc.extras import require_ros
from spacecraft_gnc.scenario.shipped import shipped

ResultOption = Annotated[
    Path | None, typer.Option("--json", metavar="FILE", help="Write the figures here as JSON.")
]
GraphOption = Annotated[
    bool, typer.Option("--graph/--no-graph", help="Fly the ROS 2 graph as well (half a minute).")
]
PeersOption = Annotated[
    bool, typer.Option("--peers/--no-peers", help="Time other solvers as well (some minutes).")
]
_PEERS = Path(__file__).resolve().parents[2] / "benchmarks" / "peers" / "run.py"
_GRAPHS = {"graph_processes": [], "graph_composed": ["--composed"]}
_FLIGHT = 4000.0  # [s] simulated: 10,000 control steps, so that the start does not count


def bench(
    result: ResultOption = None,
    graph: GraphOption = True,
    peers: PeersOption = True,
    quiet: QuietOption = False,
) -> None:
    """Measure the speed of Gupta's Case I, layer by layer, and of the planner of transfers.

    Figures for docs/performance.md.
    """
    if graph:
        require_ros()
    with show_progress("measuring", silent=quiet) as progress:
        figures = _measure(graph, peers, progress)
    if not quiet:
        _print(figures)
    if peers and _PEERS.is_file():
        figures["peers"] = _time_peers(quiet)
    elif not quiet:
        print("other solvers: skipped; `make bench` in a checkout installs and times them")
    if result is not None:
        result.write_text(json.dumps(json_able(figures), indent=2) + "\n", encoding="utf-8")
        if not quiet:
            print(f"written to {result}")


def _measure(graph: bool, peers: bool, progress: Progress) -> dict[str, Any]:
    """Measure one layer after the other; return the figures by name."""
    from spacecraft_gnc.scenario import load
    from spacecraft_gnc.studies import phogat_speed, speed

    path = shipped("gupta2015_case1")
    case_1, case_2 = load(path), load(shipped("gupta2015_case2_offplane"))
    neighboring = load(path, ["nmpc_controller.method=neighboring_extremal"])
    governed = load(shipped("kalabic2014_governor"))
    plant = case_1.plant
    layers: dict[str, Callable[[], Any]] = {
        "integrator": lambda: speed.time_integrator(plant.inertia, plant.time_step),
        "solve": lambda: speed.time_solves(case_1),
        "loop": lambda: speed.time_flight(case_1.build()),
        "loop_case_2": lambda: speed.time_flight(case_2.build()),
        "loop_neighboring": lambda: speed.time_flight(neighboring.build()),
        "governor": lambda: speed.time_governor(governed),
        "planner": phogat_speed.time_planner,
    }
    if peers and find_spec("casadi") is not None:
        layers["planner_beside_ipopt"] = phogat_speed.time_beside_ipopt
    if graph:
        for name, options in _GRAPHS.items():
            layers[name] = partial(_time_graph, path, options)
    figures: dict[str, Any] = {"machine": speed.machine()}
    for done, (name, measure) in enumerate(layers.items()):
        progress(done, len(layers), f"measuring {name}")
        figures[name] = measure()
    return figures


def _time_graph(path: Path, options: list[str]) -> dict[str, Any]:
    """Fly the graph in lockstep with the recorder; return its own account."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "spacecraft_gnc", "launch", str(path), "--json"]
        command += ["--out", str(Path(folder) / "run"), "--duration", str(_FLIGHT), *options]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RunFailed(f"gnc launch {' '.join(options)}: {done.stderr.strip()}")
    account: dict[str, Any] = json.loads(done.stdout)
    return account


def _time_peers(quiet: bool) -> dict[str, Any]:
    """Run the comparison of the checkout, which prints its own table; return its figures."""
    sys.stdout.flush()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "peers.json"
        command = [sys.executable, str(_PEERS), "--json", str(path)]
        output = subprocess.DEVNULL if quiet else None
        if subprocess.run(command, check=False, stdout=output).returncode != 0:
            raise RunFailed(f"{' '.join(command)} failed; what it said stands above")
        figures: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return figures


def _print(figures: dict[str, Any]) -> None:
    machine = figures["machine"]
    print(
        f"{machine['processor']}, {machine['cores']} cores (load {machine['load']:.1f}), "
        f"{machine['system']}, Python {machine['python']}, numpy {machine['numpy']}"
    )
    rows = [
        ("LGVI step, kernel", _times(figures["integrator"]["kernel"], 1e9, "ns")),
        ("LGVI step, from Python", _times(figures["integrator"]["call"], 1e6, "us")),
        ("warm solve, kernel", _times(figures["solve"]["kernel"], 1e6, "us")),
        ("warm solve, from Python", _times(figures["solve"]["call"], 1e6, "us")),
        ("neighboring extremals", _times(figures["loop_neighboring"]["solve"], 1e6, "us")),
        ("governor, 20 x 100 steps", _times(figures["governor"]["update"], 1e3, "ms")),
        ("governor, Kalabic's flight", _times(figures["governor"]["flight"], 1e3, "ms")),
        ("Case I without ROS", _times(figures["loop"]["flight"], 1e3, "ms")),
        ("over its solves and steps", f"{_over_kernels(figures):.2f}"),
        ("Case II without ROS", _times(figures["loop_case_2"]["flight"], 1e3, "ms")),
    ]
    flown = {name: figures[name]["steps_per_second"] for name in _GRAPHS if name in figures}
    rows += [(name.replace("_", ", "), f"{rate:.0f} steps/s") for name, rate in flown.items()]
    print_table([*rows, *_planner_rows(figures)])


def _over_kernels(figures: dict[str, Any]) -> float:
    """Return the time of a control step of Case I over that of its two kernels."""
    kernels = figures["solve"]["kernel"]["median"] + figures["integrator"]["kernel"]["median"]
    return float(figures["loop"]["step"]["median"] / kernels)


def _planner_rows(figures: dict[str, Any]) -> list[tuple[str, str]]:
    planner, beside = figures["planner"], figures.get("planner_beside_ipopt")
    rows = [("transfer, 190 steps", _times(planner["solves"], 1e3, "ms"))]
    for one in planner["lengths"]:
        text = f"{1e3 * one['time']:.3g} ms, {one['iterations']} Newton steps"
        rows.append((f"figure 4, {one['n_steps']} steps", text))
    if beside is None:
        return rows
    ratio = beside["ratio"]
    return [
        *rows,
        ("transfer, one start", _times(beside["ours"], 1e3, "ms")),
        ("the same by IPOPT", _times(beside["ipopt"], 1e3, "ms")),
        ("ratio", f"{ratio['median']:.1f} median, {ratio['samples']} transfers"),
    ]


def _times(q: dict[str, float], factor: float, unit: str) -> str:
    median, p99, largest = (factor * q[key] for key in ("median", "p99", "max"))
    return f"{median:.3g} {unit} median, {p99:.3g} 99 %, {largest:.3g} longest"
