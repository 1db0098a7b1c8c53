"""``gnc replay`` without a graph: every recorded step solved again, and the table beside it."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from spacecraft_gnc.cli._common import (
    RunFailed,
    given_scenario,
    known_scenario,
    print_json,
    require_folder,
)
from spacecraft_gnc.cli._progress import show_progress
from spacecraft_gnc.errors import ParameterError, RecordingError

if TYPE_CHECKING:
    from spacecraft_gnc.analysis.reader import Flight
    from spacecraft_gnc.scenario import Scenario
    from spacecraft_gnc.vehicles.rigid_body.resolve.replay import Resolved

_STEPS: Final = re.compile(r"(\d*):(\d*)")
_CONTROLLER: Final = "nmpc_controller"
_COUNTS: Final = 1e-3  # share of the largest difference of the costs


class Solving(NamedTuple):
    """What the user asks of another controller."""

    source: Path
    method: str | None
    overrides: list[str]
    scenario: Path | None
    steps: str | None
    cold: bool
    namespace: str | None
    unfinished: bool
    out: Path | None
    as_json: bool
    quiet: bool


def solve_again(wish: Solving) -> None:
    """Compare a recorded flight with what another controller would have commanded.

    Raises
    ------
    RunFailed
        If the controller that flew does not command the same again, where it has to.
    """
    from spacecraft_gnc.analysis.reader import load_run
    from spacecraft_gnc.scenario import revise
    from spacecraft_gnc.vehicles.rigid_body.resolve.comparison import compare
    from spacecraft_gnc.vehicles.rigid_body.resolve.replay import resolve

    require_folder(wish.out)
    flight = load_run(wish.source, namespace=wish.namespace, allow_unfinished=wish.unfinished)
    recorded = _scenario(flight, wish.scenario)
    revised, unread = revise(recorded, wish.overrides, wish.method)
    same = revised.values[_CONTROLLER] == recorded.values[_CONTROLLER]
    steps = _steps(wish.steps, flight.trajectory.n_steps)
    with show_progress("solving", silent=wish.quiet or wish.as_json) as progress:
        resolved = resolve(
            flight.trajectory,
            recorded,
            recorded if same else revised,
            steps=steps,
            cold=wish.cold,
            progress=progress,
        )
    check = None
    if same and _must_repeat(wish, flight, recorded, resolved):
        check = "exact" if resolved.first_difference is None else "differs"
    numbers = compare(resolved, recorded, revised) | {"check": check}
    files: list[Path] = []
    if wish.out is not None:
        files = _draw(wish.source, wish.out, resolved, (recorded, revised))
    for warning in flight.info.warnings():
        print(f"warning: {warning}", file=sys.stderr)
    if wish.as_json:
        print_json({"source": wish.source, "cold": wish.cold, "not_read": unread, **numbers})
    elif not wish.quiet:
        _print(wish, flight, numbers, unread)
        for file in files:
            print(file)
    if check == "differs":
        doubt = "it was restarted, or flew in another version or elsewhere"
        if flight.info.scenario is None:
            doubt = f"--scenario names what flew, and whether {doubt}"
        raise RunFailed(
            f"{wish.source}: step {numbers['first_difference']}: {recorded.controller.method} "
            "commands another torque than it did in this lockstep flight; required the same bit "
            f"for bit; find out whether {doubt}"
        )


def _scenario(flight: Flight, path: Path | None) -> Scenario:
    """Return the scenario in the bag, or else the one named on the command line."""
    info = flight.info
    scenario = known_scenario(info, given_scenario(path))
    if scenario is None:
        reason = f" that this version reads ({info.scenario_problem})"
        raise RecordingError(
            f"{info.path}: received a flight without a scenario"
            f"{reason if info.scenario_problem else ''}; required the one that flew, whose "
            "controller is to be compared; name it with --scenario"
        )
    return scenario


def _steps(text: str | None, n_steps: int) -> tuple[int, int]:
    """Return the first step and the one after the last of ``A:B``."""
    if text is None:
        return 0, n_steps
    match = _STEPS.fullmatch(text.strip())
    if match is None:
        raise ParameterError(
            f"--steps: received {text!r}; required A:B, two step numbers of which either may be "
            f"left out; give for example 0:{n_steps}"
        )
    return int(match[1] or 0), int(match[2] or n_steps)


def _must_repeat(wish: Solving, flight: Flight, recorded: Scenario, resolved: Resolved) -> bool:
    """Tell whether a controller has to command again what it did: the same past, step by step."""
    disturbed = flight.info.missing or flight.info.overridden
    whole_past = resolved.steps[0] == 0 and not wish.cold
    return whole_past and not disturbed and recorded.plant.mode == "lockstep"


def _draw(
    source: Path, folder: Path, resolved: Resolved, scenarios: tuple[Scenario, Scenario]
) -> list[Path]:
    from spacecraft_gnc.drawing.figures import save_figures
    from spacecraft_gnc.vehicles.rigid_body.resolve.comparison import figure

    recorded, revised = (scenario.controller.method for scenario in scenarios)
    names = (recorded, f"{revised} again" if revised == recorded else revised)
    drawn = figure(resolved, names, "/".join(source.resolve().parts[-2:]))
    return save_figures([("replay", drawn)], folder, ("png", "svg"))


def _print(wish: Solving, flight: Flight, m: dict[str, Any], unread: tuple[str, ...]) -> None:
    """Print the table."""
    period = flight.trajectory.period
    history = "each from a cold start" if wish.cold else "warm along the flight"
    print(
        f"{wish.source}: {m['steps']} of {flight.trajectory.n_steps} steps solved again by "
        f"{m['replayed']['method']}, {history}"
    )
    rows = [("", "as flown", "replayed")]
    rows += _sides(m["recorded"], m["replayed"])
    widths = [max(len(row[i]) for row in rows) for i in range(2)]
    for label, old, new in rows:
        print(f"  {label:<{widths[0]}}  {old:<{widths[1]}}  {new}".rstrip())
    for label, text in _differences(m, period):
        print(f"  {label:<{widths[0]}}  {text}")
    if unread:
        print(f"  {'not read':<{widths[0]}}  {', '.join(unread)}")


def _sides(old: dict[str, Any], new: dict[str, Any]) -> list[tuple[str, str, str]]:
    return [
        ("method", old["method"], new["method"]),
        ("largest torque", _number(old["max_torque"], "N m"), _number(new["max_torque"], "N m")),
        ("iterations a solve", _iterations(old), _iterations(new)),
        ("largest residual", _number(old["residual_max"]), _number(new["residual_max"])),
        ("time a solve", _time(old), _time(new)),
        ("steps not solved", _count(old["unconverged_steps"]), _count(new["unconverged_steps"])),
        ("torque from", _sources(old), _sources(new)),
        *_standstills(old, new),
    ]


def _standstills(old: dict[str, Any], new: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Return the rows on standstills away from the target, where either side had one."""
    rows = {"steps at a standstill": "stalled_steps", "standstill escapes": "escaping_steps"}
    return [
        (label, _count(old[name]), _count(new[name]))
        for label, name in rows.items()
        if old[name] or new[name]
    ]


def _differences(m: dict[str, Any], period: float) -> list[tuple[str, str]]:
    """Return the rows that hold for both together."""
    steps, same = m["steps"], m["identical_steps"]
    equal = f"{same} of {steps} steps, bit for bit"
    if m["check"] == "exact":
        equal += ": the flight is repeated exactly, as a lockstep flight has to be"
    elif same < steps:
        equal += f"; the first other one at step {m['first_difference']}"
    rows = [("equal torques", equal)]
    torque = _at(m, "torque_difference", "N m", period)
    rows.append(("torque difference", torque))
    if m["cost_difference_max"] is None:
        rows.append(("cost difference", "-, no plans to compare by the recorded problem"))
    elif not _penalties_count(m):
        rows.append(("cost difference", _at(m, "cost_difference", "", period)))
    else:
        without = f"{_at(m, 'plain_cost_difference', '', period)}, without penalties"
        rows += [("cost difference", without), ("penalties", _penalties(m, period))]
    return rows


def _penalties_count(m: dict[str, Any]) -> bool:
    """Tell whether a penalty is so large beside the cost that it would blur the comparison."""
    penalty, plain = m["penalty_max"], m["plain_cost_difference_max"]
    return penalty is not None and plain is not None and penalty > _COUNTS * abs(plain)


def _penalties(m: dict[str, Any], period: float) -> str:
    """Say which plan pays most for leaving a limit of the recorded problem, and by how much."""
    step, torque, zone = (m[f"penalty_{n}"] for n in ("step", "torque_excess", "zone_excess_deg"))
    text = f"{_number(m['penalty_max'])} at the most (step {step}, {step * period:g} s)"
    excess = [f"{torque:.2g} N m above the torque limit"] if torque and torque > 0.0 else []
    excess += [f"{zone:.2g} deg inside a zone"] if zone and zone > 0.0 else []
    which = "the plan as flown" if m["penalty_side"] == "recorded" else "the plan replayed"
    return f"{text}: {which} is {' and '.join(excess)}" if excess else text


def _at(m: dict[str, Any], name: str, unit: str, period: float) -> str:
    step = m[f"{name}_max_step"]
    largest, rms = _number(m[f"{name}_max"], unit), _number(m[f"{name}_rms"], unit)
    if m[f"{name}_rms"] == 0.0:
        return f"{largest} in every step"
    return f"{largest} at the most (step {step}, {step * period:g} s), {rms} rms"


def _number(value: float | None, unit: str = "") -> str:
    return "-" if value is None else f"{value:.6g} {unit}".rstrip()


def _iterations(side: dict[str, Any]) -> str:
    if side["iterations_median"] is None:
        return "-"
    return f"{side['iterations_median']:.3g} median, {side['iterations_max']} most"


def _count(steps: int | None) -> str:
    return "-" if steps is None else str(steps)


def _time(side: dict[str, Any]) -> str:
    median, p99 = side["solve_time_median"], side["solve_time_p99"]
    if median is None:
        return "-"
    return f"{1e6 * median:.0f} us median, {1e6 * p99:.0f} us 99 %"


def _sources(side: dict[str, Any]) -> str:
    return ", ".join(f"{name} {count}" for name, count in side["sources"].items())
