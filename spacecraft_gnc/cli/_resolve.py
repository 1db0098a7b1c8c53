"""``gnc replay`` without a graph: re-solve every recorded step and print the comparison."""

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
    from spacecraft_gnc.analysis.reader import RecordedRun
    from spacecraft_gnc.scenario import Scenario
    from spacecraft_gnc.vehicles.replay import VehicleReplay

_STEPS: Final = re.compile(r"(\d*):(\d*)")
_CONTROLLER: Final = "nmpc_controller"


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
    from spacecraft_gnc.analysis.vehicle import part
    from spacecraft_gnc.scenario import revise

    require_folder(wish.out)
    flight = load_run(wish.source, namespace=wish.namespace, allow_unfinished=wish.unfinished)
    recorded = _scenario(flight, wish.scenario)
    revised, unread = revise(recorded, wish.overrides, wish.method)
    same = revised.values[_CONTROLLER] == recorded.values[_CONTROLLER]
    steps = _steps(wish.steps, flight.trajectory.n_steps)
    vehicle: VehicleReplay = part("resolve", recorded)
    with show_progress("solving", silent=wish.quiet or wish.as_json) as progress:
        resolved = vehicle.resolve(
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
    numbers = vehicle.compare(resolved, recorded, revised) | {"check": check}
    files: list[Path] = []
    if wish.out is not None:
        files = _draw(wish.source, wish.out, vehicle, resolved, (recorded, revised))
    for warning in flight.info.warnings():
        print(f"warning: {warning}", file=sys.stderr)
    if wish.as_json:
        print_json({"source": wish.source, "cold": wish.cold, "not_read": unread, **numbers})
    elif not wish.quiet:
        _print(wish, flight, vehicle, numbers, unread)
        for file in files:
            print(file)
    if check == "differs":
        doubt = "it was restarted, or flew in another version or elsewhere"
        if flight.info.scenario is None:
            doubt = f"--scenario names what flew, and whether {doubt}"
        raise RunFailed(
            f"{wish.source}: step {numbers['first_difference']}: {recorded.controller.method} "
            f"commands another {vehicle.control} than it did in this lockstep flight; required the "
            f"same bit for bit; find out whether {doubt}"
        )


def _scenario(flight: RecordedRun, path: Path | None) -> Scenario:
    """Return the scenario in the bag, or else the one named on the command line."""
    info = flight.info
    scenario = known_scenario(info, given_scenario(path, info.namespace))
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


def _must_repeat(wish: Solving, flight: RecordedRun, recorded: Scenario, resolved: Any) -> bool:
    """Tell whether a controller has to command again what it did: the same past, step by step."""
    disturbed = flight.info.missing or flight.info.overridden
    whole_past = resolved.steps[0] == 0 and not wish.cold
    return whole_past and not disturbed and recorded.plant.mode == "lockstep"


def _draw(
    source: Path,
    folder: Path,
    vehicle: VehicleReplay,
    resolved: Any,
    scenarios: tuple[Scenario, Scenario],
) -> list[Path]:
    from spacecraft_gnc.drawing.figures import save_figures

    recorded, revised = (scenario.controller.method for scenario in scenarios)
    names = (recorded, f"{revised} again" if revised == recorded else revised)
    drawn = vehicle.figure(resolved, names, "/".join(source.resolve().parts[-2:]))
    return save_figures([("replay", drawn)], folder, ("png", "svg"))


def _print(
    wish: Solving,
    flight: RecordedRun,
    vehicle: VehicleReplay,
    m: dict[str, Any],
    unread: tuple[str, ...],
) -> None:
    """Print the table."""
    period = flight.trajectory.period
    history = "each from a cold start" if wish.cold else "warm along the flight"
    print(
        f"{wish.source}: {m['steps']} of {flight.trajectory.n_steps} steps solved again by "
        f"{m['replayed']['method']}, {history}"
    )
    rows = [("", "as flown", "replayed")]
    rows += vehicle.sides(m["recorded"], m["replayed"])
    widths = [max(len(row[i]) for row in rows) for i in range(2)]
    for label, old, new in rows:
        print(f"  {label:<{widths[0]}}  {old:<{widths[1]}}  {new}".rstrip())
    for label, text in vehicle.differences(m, period):
        print(f"  {label:<{widths[0]}}  {text}")
    if unread:
        print(f"  {'not read':<{widths[0]}}  {', '.join(unread)}")
