"""``gnc simulate``: the closed loop of a scenario without ROS."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from spacecraft_gnc.analysis.vehicle import part
from spacecraft_gnc.cli._common import (
    JsonOption,
    QuietOption,
    RunFailed,
    ScenarioArgument,
    SetOption,
    SpacecraftOption,
    StrictOption,
    exceeded_text,
    print_json,
    print_table,
    require_within_limits,
    require_writable,
    tell_warnings,
)
from spacecraft_gnc.cli._progress import show_progress
from spacecraft_gnc.errors import GncError, ParameterError

if TYPE_CHECKING:
    from spacecraft_gnc.loop.closed_loop import ClosedLoop
    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.scenario import Scenario

OutOption = Annotated[
    Path | None,
    typer.Option(
        "--out",
        "-o",
        metavar="FILE.npz",
        readable=False,
        help="Write the arrays of the flight here.",
    ),
]


def simulate(
    scenario: ScenarioArgument,
    out: OutOption = None,
    overrides: SetOption = None,
    namespace: SpacecraftOption = None,
    strict: StrictOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Fly a scenario without ROS: the same cores, the same numbers as `gnc launch`."""
    from spacecraft_gnc.analysis.metrics import summarize
    from spacecraft_gnc.scenario import load
    from spacecraft_gnc.vehicles import registry

    checked = load(scenario, overrides or (), namespace)
    if out is not None:
        require_writable(out, ".npz")
    if not (quiet or as_json):
        tell_warnings(checked)
    require_memory(checked.n_steps, registry.flight_of(checked.vehicle).bytes_per_step())
    loop = checked.build()
    for core in (loop.plant, loop.controller, loop.governor):
        core.warm_up()  # loads the kernels, which is no part of the flight
    started = time.perf_counter()
    trajectory = _fly(loop, silent=quiet)
    wall_time = time.perf_counter() - started
    if out is not None:
        trajectory.save(out, checked.to_yaml(), checked.stated_defaults())
    summary = summarize(trajectory, checked)
    if as_json or not quiet:
        metrics = {"scenario": str(scenario), **summary, "wall_time": wall_time}
        _tell(metrics, checked, out, as_json=as_json)
    require_within_limits(scenario, summary.get("limits_exceeded", ()), strict)


def _tell(metrics: dict[str, Any], scenario: Scenario, out: Path | None, *, as_json: bool) -> None:
    if as_json:
        print_json({**metrics, "warnings": list(scenario.warnings), "out": out})
        return
    print(f"{metrics['scenario']}: flown in {metrics['wall_time']:.3g} s")
    print_table(summary_rows(metrics, scenario))
    if out is not None:
        print(f"  written to {out}")


def require_memory(n_steps: int, bytes_per_step: int) -> None:
    """Refuse a flight whose record would not fit into the memory of this machine.

    Raises
    ------
    ParameterError
        If it would not; the system would end the process at some step without a word.
    """
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    if n_steps * bytes_per_step > memory:
        raise ParameterError(
            f"plant.duration: received {n_steps} control steps; required at most "
            f"{memory // bytes_per_step}, whose record fits into {memory >> 30} GiB; shorten it"
        )


def _fly(loop: ClosedLoop, silent: bool) -> Flight:
    try:
        with show_progress("flying", silent=silent) as progress:
            return loop.run(progress)
    except GncError as error:  # the input was accepted: what fails now is the run
        raise RunFailed(str(error)) from error


def summary_rows(m: dict[str, Any], scenario: Scenario | None = None) -> list[tuple[str, str]]:
    """Return the lines of a flight's summary, label and text."""
    rows = [
        ("control steps", f"{m['steps']} of {m['period']:g} s"),
        *part("summary", scenario)(m),
    ]
    if m.get("limits_exceeded"):
        rows.append(("warning", exceeded_text(m["limits_exceeded"])))
    if m.get("inadmissible_steps"):
        text = f"no reference was admissible at {m['inadmissible_steps']} of {m['steps']} steps"
        rows.append(("warning", text))
    if m.get("fallback_steps"):
        text = f"{m['fallback_steps']} of {m['steps']} steps flew on a fallback torque"
        rows.append(("warning", text))
    return [*rows, hash_row(m)]


def hash_row(m: dict[str, Any]) -> tuple[str, str]:
    """Return the line that tells which scenario it was, as a bag's audit tells it too."""
    return "scenario", "-" if m["scenario_hash"] is None else f"sha256 {m['scenario_hash']}"
