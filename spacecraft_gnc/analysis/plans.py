"""Plans of ``gnc plan`` beside flights: read as runs, and shown by the parts of their vehicle."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from spacecraft_gnc.analysis.flown import Flown
from spacecraft_gnc.analysis.plan_file import require_one_kind, vehicle_in
from spacecraft_gnc.analysis.run_info import RunInfo
from spacecraft_gnc.analysis.vehicle import common_part, part_of
from spacecraft_gnc.scenario.recorded import parse_scenario
from spacecraft_gnc.vehicles.registry import vehicle_of

if TYPE_CHECKING:
    from spacecraft_gnc.drawing.vehicle import VehicleFigures, VehiclePlanner, VehicleReport
    from spacecraft_gnc.scenario import Scenario


def read_plan(name: str, path: Path) -> Flown:
    """Read a plan as a run, whose trajectory is the plan as its vehicle knows it.

    Raises
    ------
    RecordingError
        If it is damaged, or its numbers are no optimal plan.
    ParameterError
        If its vehicle plans no transfers.
    """
    planner: VehiclePlanner = part_of("planner", vehicle_of(vehicle_in(path), str(path)))
    plan, text, defaults = planner.load(path)
    scenario, problem = parse_scenario(text, path, defaults=defaults)
    info = RunInfo(
        path=path,
        scenario=scenario,
        scenario_text=text,
        scenario_problem=problem,
        is_plan=True,
    )
    return Flown(name=name, trajectory=plan, info=info, telemetry=None, scenario=scenario)


def report_part(runs: Sequence[Flown]) -> VehicleReport:
    """Return the part of the vehicle that shows runs on a page, flights or plans.

    Raises
    ------
    ParameterError
        If there are both, or runs of different vehicles.
    """
    found: VehicleReport = _part(runs, "report")
    return found


def figures_part(runs: Sequence[Flown]) -> VehicleFigures:
    """Return, likewise, the one that draws them for print."""
    found: VehicleFigures = _part(runs, "figures")
    return found


def planner_of(scenario: Scenario | None) -> VehiclePlanner:
    """Return the planner of the vehicle of a plan."""
    found: VehiclePlanner = common_part("planner", [scenario])
    return found


def _part(runs: Sequence[Flown], name: str) -> Any:
    scenarios = [run.scenario for run in runs]
    if not any(run.info.is_plan for run in runs):
        return common_part(name, scenarios)
    require_one_kind(run.info.path for run in runs)
    return getattr(common_part("planner", scenarios), name)
