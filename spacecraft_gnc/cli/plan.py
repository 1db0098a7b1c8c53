"""``gnc plan``: the optimal transfer of a scenario, without flying it."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from spacecraft_gnc.cli._common import (
    JsonOption,
    QuietOption,
    ScenarioArgument,
    SetOption,
    SpacecraftOption,
    print_json,
    print_table,
    require_writable,
    tell_warnings,
)
from spacecraft_gnc.cli._progress import show_progress
from spacecraft_gnc.errors import ParameterError

if TYPE_CHECKING:
    from spacecraft_gnc.drawing.vehicle import VehiclePlanner
    from spacecraft_gnc.parameters.problems import Problem
    from spacecraft_gnc.scenario import Scenario

OutOption = Annotated[
    Path | None,
    typer.Option(
        "--out",
        "-o",
        metavar="FILE.npz",
        readable=False,
        help="Write the plan here, for gnc report, gnc plot and nmpc_controller.plan.file.",
    ),
]
ShortestOption = Annotated[
    bool,
    typer.Option(
        "--shortest", help="Find the shortest time for which there is a plan, and that plan."
    ),
]


def plan(
    scenario: ScenarioArgument,
    out: OutOption = None,
    overrides: SetOption = None,
    namespace: SpacecraftOption = None,
    shortest: ShortestOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Plan the energy-optimal transfer of a scenario within its bounds on torque and momentum.

    From the start to rest at the target; of a scenario with method or governor: planned.
    """
    from spacecraft_gnc.scenario import InvalidScenario, load

    one = load(scenario, overrides or (), namespace)
    planner = _planner(one)
    if out is not None:
        require_writable(out, ".npz")
    if not (quiet or as_json):
        tell_warnings(one)
    with show_progress("planning", silent=quiet) as progress:
        progress(0, 1)
        planner.warm_up()
        started = time.perf_counter()
        found = planner.solve(one, shortest=shortest)
        wall_time = time.perf_counter() - started
        problem = planner.refusal(one, found)
    numbers = {"scenario": str(scenario), **planner.numbers(found), "wall_time": wall_time}
    if problem is not None:
        if not as_json:
            raise InvalidScenario([problem])
        print_json({**numbers, **_told(one, out=None, problem=problem)})
        raise typer.Exit(InvalidScenario.exit_code)
    if out is not None:
        planner.save(out, found, one.to_yaml(), one.stated_defaults())
    if as_json:
        print_json({**numbers, **_told(one, out)})
    elif not quiet:
        print(f"{scenario}: planned in {wall_time:.3g} s")
        print_table(planner.summary(numbers))
        if out is not None:
            print(f"  written to {out}")


def _told(one: Scenario, out: Path | None, problem: Problem | None = None) -> dict[str, Any]:
    problems = [] if problem is None else [problem.as_dict()]
    return {"problems": problems, "warnings": list(one.warnings), "out": out}


def _planner(scenario: Scenario) -> VehiclePlanner:
    """Return the planner of a scenario's vehicle.

    Raises
    ------
    ParameterError
        If it plans no transfers.
    """
    vehicle = scenario.vehicle
    if vehicle.planner is None:
        raise ParameterError(
            f"{scenario.path}: plant.vehicle: received {vehicle.name!r}, which plans no transfers; "
            "required a vehicle that does, such as rigid_body; fly the scenario: gnc simulate"
        )
    found: VehiclePlanner = vehicle.planner.load()
    return found
