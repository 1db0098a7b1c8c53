"""``gnc simulate``: the closed loop of a scenario without ROS."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping, Sequence
from functools import partial
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
from spacecraft_gnc.cli._progress import Progress, show_progress
from spacecraft_gnc.errors import GncError, ParameterError

if TYPE_CHECKING:
    from spacecraft_gnc.loop.closed_loop import ClosedLoop
    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.scenario import Fleet, Scenario

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
    from spacecraft_gnc.loop.flight import save_flights
    from spacecraft_gnc.scenario import load_fleet
    from spacecraft_gnc.vehicles import registry

    fleet = load_fleet(scenario, overrides or (), namespace)
    if out is not None:
        require_writable(out, ".npz")
    if not (quiet or as_json):
        tell_warnings(fleet)
    sizes = (registry.flight_of(one.vehicle).bytes_per_step() for one in fleet.agents.values())
    require_memory(fleet.n_steps, sum(sizes))
    loops = fleet.build()
    for loop in loops.values():
        for core in (loop.plant, loop.controller, loop.governor):
            core.warm_up()  # loads the kernels, which is no part of the flight
    started = time.perf_counter()
    flights = _fly(loops, silent=quiet)
    wall_time = time.perf_counter() - started
    if out is not None:
        save_flights(out, flights, fleet.to_yaml(), fleet.stated_defaults())
    metrics = {
        "scenario": str(scenario), **summarize_agents(flights, fleet), "wall_time": wall_time
    }  # fmt: skip
    if as_json or not quiet:
        _tell(metrics, fleet, out, as_json=as_json)
    require_within_limits(scenario, metrics.get("limits_exceeded", ()), strict)


def summarize_agents(flights: Mapping[str, Flight], fleet: Fleet) -> dict[str, Any]:
    """Return the summary of a flight; of several agents that of each, by name in ``agents``."""
    from spacecraft_gnc.analysis.metrics import summarize

    told = {agent: summarize(flight, fleet.agents[agent]) for agent, flight in flights.items()}
    if "" in told:
        return told[""]
    exceeded = [
        {**each, "text": f"/{agent}: {each['text']}"}
        for agent, summary in told.items()
        for each in summary.get("limits_exceeded", ())
    ]
    return {"agents": told, "limits_exceeded": exceeded}


def _tell(metrics: dict[str, Any], fleet: Fleet, out: Path | None, *, as_json: bool) -> None:
    if as_json:
        print_json({**metrics, "warnings": list(fleet.warnings), "out": out})
        return
    print(f"{metrics['scenario']}: flown in {metrics['wall_time']:.3g} s")
    print_summaries(metrics, fleet)
    if out is not None:
        print(f"  written to {out}")


def print_summaries(
    metrics: dict[str, Any],
    fleet: Fleet,
    further: Sequence[tuple[str, str]] = (),
    *,
    flown: bool = True,
) -> None:
    """Print the summary of a flight, an agent after the other; or, where none is known, what flew.

    What is ``further`` told of the graph comes last.
    """
    for agent, one in fleet.agents.items():
        told = metrics["agents"][agent] if agent else metrics
        rows = summary_rows(told, one) if flown else [hash_row(told)]
        if agent:
            print(f"/{agent}")
        print_table(rows if agent else [*rows, *further])
    if further and "" not in fleet.agents:
        print("graph")
        print_table(further)


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


def _fly(loops: Mapping[str, ClosedLoop], silent: bool) -> dict[str, Flight]:
    """Fly the loops of all agents, which do not see each other, one after the other."""
    flights: dict[str, Flight] = {}
    total = sum(loop.plant.n_steps for loop in loops.values())
    try:
        with show_progress("flying", silent=silent) as progress:
            for agent, loop in loops.items():
                done = sum(flight.n_steps for flight in flights.values())
                flights[agent] = loop.run(partial(_tell_share, progress, done, total))
    except GncError as error:  # the input was accepted: what fails now is the run
        raise RunFailed(str(error)) from error
    return flights


def _tell_share(progress: Progress, done: int, total: int, step: int, _: int) -> None:
    progress(done + step, total)


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
