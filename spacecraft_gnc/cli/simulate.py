"""``gnc simulate``: the closed loop of a scenario without ROS."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

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

_NOTHING = "-"  # a row without a value is left out
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
        _tell(metrics, checked.warnings, out, as_json=as_json)
    require_within_limits(scenario, summary["limits_exceeded"], strict)


def _tell(
    metrics: dict[str, Any], warnings: tuple[str, ...], out: Path | None, *, as_json: bool
) -> None:
    if as_json:
        print_json({**metrics, "warnings": list(warnings), "out": out})
        return
    print(f"{metrics['scenario']}: flown in {metrics['wall_time']:.3g} s")
    print_table(summary_rows(metrics))
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


def summary_rows(m: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the lines of a flight's summary, label and text."""
    never = "unknown" if m["final_error_deg"] is None else "never"
    settled = [(f"under {x} deg for good", m[f"settle_time_{x}deg"]) for x in ("5", "1", "0.1")]
    iterations = f"{_text(m['iterations_median'], 3)} median, {_text(m['iterations_max'], 3)} most"
    work = "command" if m["iterations_median"] is None else "solve"
    sources = ", ".join(f"{name} {count}" for name, count in m["sources"].items())
    rows = [
        ("control steps", f"{m['steps']} of {m['period']:g} s"),
        ("error at the end", _final_error(m)),
        *((label, never if at is None else f"from {at:g} s") for label, at in settled),
        *_governor_rows(m),
        ("largest torque", f"{_text(m['max_torque'], 8)} N m, {_limit(m)}"),
        ("sum of stage costs", _stage_costs(m)),
        ("least zone margin", f"{_text(m['min_zone_margin_deg'], 4)} deg"),
        ("iterations a solve", iterations),
        (f"time a {work}", _solve_times(m)),
        ("steps not solved", _text(m["unconverged_steps"], 10)),
        ("torque from", sources),
    ]
    if m["neighboring_share"] is not None:
        share = f"{100.0 * m['neighboring_share']:.1f} % of the steps"
        error = f", off the exact torque by {_text(m['neighboring_error'], 3)} N m at most"
        rows.append(("neighboring extremals", share + error))
    if m["stalled_steps"]:
        rows.append(("steps at a standstill", f"{m['stalled_steps']}, away from the target"))
    if m["escaping_steps"]:
        text = f"{m['escaping_steps']}, by a small torque added to the optimal one"
        rows.append(("standstill escapes", text))
    if m["limits_exceeded"]:
        rows.append(("warning", exceeded_text(m["limits_exceeded"])))
    if m["inadmissible_steps"]:
        text = f"no reference was admissible at {m['inadmissible_steps']} of {m['steps']} steps"
        rows.append(("warning", text))
    if m["fallback_steps"]:
        text = f"{m['fallback_steps']} of {m['steps']} steps flew on a fallback torque"
        rows.append(("warning", text))
    rows.append(hash_row(m))
    # A row without a value starts with the dash alone; a negative number is a value.
    return [row for row in rows if row[1].split(" ")[0] != _NOTHING]


def hash_row(m: dict[str, Any]) -> tuple[str, str]:
    """Return the line that tells which scenario it was, as a bag's audit tells it too."""
    return "scenario", _NOTHING if m["scenario_hash"] is None else f"sha256 {m['scenario_hash']}"


def _governor_rows(m: dict[str, Any]) -> list[tuple[str, str]]:
    if m["min_governor_margin"] is None:
        return []
    at, off = m["alpha_one_time"], m["final_reference_error_deg"]
    if at is not None:
        return [("target admitted", f"from {at:g} s (alpha = 1)")]
    where = "" if off is None else f", reference {_text(off, 5)} deg from the target at the end"
    return [("target admitted", f"never{where}")]


def _stage_costs(m: dict[str, Any]) -> str:
    """Return the cost; a governor's moving reference makes it none of the way to the target."""
    text = _text(m["cost"], 10)
    return text if text == _NOTHING or m["error_to"] != "target" else f"{text}, to the reference"


def _limit(m: dict[str, Any]) -> str:
    if not m["torque_limit"]:
        return "no limit"
    return f"limit {m['torque_limit']:g} N m, {m['saturated_steps']} steps on it"


def _final_error(m: dict[str, Any]) -> str:
    if m["final_error_deg"] is None:
        return "unknown: the last state or reference was not recorded"
    return f"{m['final_error_deg']:.5g} deg to the {m['error_to']}"


def _solve_times(m: dict[str, Any]) -> str:
    keys = {"solve_time_median": "median", "solve_time_p99": "99 %", "solve_time_max": "longest"}
    if any(m[key] is None for key in keys):
        return _NOTHING
    return ", ".join(f"{m[key] * 1e6:.0f} us {word}" for key, word in keys.items())


def _text(value: float | None, digits: int) -> str:
    return _NOTHING if value is None else f"{value:.{digits}g}"
